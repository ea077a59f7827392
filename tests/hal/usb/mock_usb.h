// A USB that tests can plug things into, through umockdev: the code under test meets sysfs, device nodes and udev's
// events as on a real machine. The program must run with libumockdev-preload loaded.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace cheval::test {

struct MockDevice {
    std::string portPath = "1-2";  ///< On bus 1; a port of the root hub, or of a hub that is plugged in.
    int address = 5;               ///< Device number on the bus.
    std::uint16_t vendor = 0x1d27;
    std::uint16_t product = 0x0609;
};

/// How a device's node answers the request for a reset.
enum class MockReset : std::uint8_t { done, gone, refused, hangs };

/// One bus with a root hub, from construction to destruction. Thread-bound.
class MockUsb {
  public:
    MockUsb();
    ~MockUsb();
    MockUsb(const MockUsb&) = delete;
    MockUsb& operator=(const MockUsb&) = delete;

    /// Plugs a device in, with the event that udev would send.
    void plugIn(const MockDevice& device);
    /// Pulls it out, likewise.
    void pullOut(const MockDevice& device);
    /// From here on the device's node can be opened and answers like this.
    void answerResets(const MockDevice& device, MockReset answer);
    /// Requests for a reset that reached a device.
    [[nodiscard]] int resets() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace cheval::test

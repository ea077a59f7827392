// Which depth sensors are plugged in, and when one comes or goes.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hal/expected.h"
#include "hal/usb/usb_sensor.h"

namespace cheval::hal {

enum class UsbChange : std::uint8_t { arrived, left };

struct UsbEvent {
    UsbChange change = UsbChange::arrived;
    UsbSensor sensor;
};

/// Counted since start().
struct UsbCounts {
    std::uint64_t arrived = 0;
    std::uint64_t left = 0;
    std::uint64_t dropped = 0;  ///< Events that nobody took in time; the oldest go first.
};

/// Hot-plug events of the sensors in sensor_ids.h. Thread-bound: libusb gathers events on a thread of its own, and
/// poll() has it report them in the caller's, so that there is no lock and no callback elsewhere. The mirror goes on
/// without it: a sensor is then found by trying again alone. Events come by way of udev, so in a container without
/// it none come, though sensors() works; where there is no USB at all, none is ever plugged in.
class UsbWatcher {
  public:
    static constexpr std::size_t kMostWaiting = 16;

    /// Errors: unavailable (udev cannot be listened to, no hot-plug in this libusb), resource.
    static Expected<std::unique_ptr<UsbWatcher>> start();
    virtual ~UsbWatcher() = default;
    UsbWatcher(const UsbWatcher&) = delete;
    UsbWatcher& operator=(const UsbWatcher&) = delete;

    /// Gathers what has happened; never waits, and takes no memory while nothing has. Call it a few times a second.
    /// A sensor that was plugged in before start() is no event, but its leaving is. Errors: unavailable.
    virtual Expected<void> poll() = 0;
    /// The oldest event that was gathered; false: there is none.
    virtual bool take(UsbEvent& event) = 0;
    /// What is plugged in now, by port path. Takes memory. Errors: unavailable, resource.
    [[nodiscard]] virtual Expected<std::vector<UsbSensor>> sensors() const = 0;
    [[nodiscard]] virtual const UsbCounts& counts() const = 0;

  protected:
    UsbWatcher() = default;
};

}  // namespace cheval::hal

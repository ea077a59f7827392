// Resets a sensor that hangs, as if it were pulled out and plugged in again.
//
// The kernel may hold whoever asks for a reset, or merely opens a device that hangs, for as long as it likes, and a
// thread that it holds cannot be ended: the whole process would stay undead, and no watchdog could restart the
// mirror. So a process of its own does it (`cheval-usb-reset`, a front door of resetSensorHere()), which the mirror
// can give up on. It is started afresh and not forked off, because in a child that was forked from several threads
// neither libusb nor malloc may be relied on.
#pragma once

#include <optional>
#include <string>

#include "hal/child_process.h"
#include "hal/clock.h"
#include "hal/expected.h"

namespace cheval::hal {

enum class UsbResetOutcome : std::uint8_t {
    reset,          ///< Done; the device kept its address.
    reEnumerating,  ///< Done; the device comes back as another one, and the watcher says when.
};

struct UsbResetOptions {
    std::string program;                       ///< Where cheval-usb-reset is.
    std::string portPath;                      ///< The sensor, as UsbSensor::portPath; empty: the only one.
    Duration limit = std::chrono::seconds(5);  ///< After this long the reset counts as failed. Machine time.
};

/// A reset under way. Thread-bound. One at a time in a process: while one that was given up on still hangs in the
/// kernel, start() refuses.
class UsbReset {
  public:
    /// Returns at once. Errors: notFound (the program), unavailable (an earlier one hangs), resource.
    static Expected<UsbReset> start(const UsbResetOptions& options);
    UsbReset(UsbReset&&) noexcept = default;
    UsbReset& operator=(UsbReset&&) = delete;
    UsbReset(const UsbReset&) = delete;
    UsbReset& operator=(const UsbReset&) = delete;
    /// Gives up on it if it is not over.
    ~UsbReset() { giveUp(); }

    /// What came of it, waiting for at most `patience`; empty: it is not over. Once it is, says the same again. Errors:
    /// notFound (no such sensor), invalidInput (several, and no port path), unavailable (no permission, the device
    /// refuses), timedOut (beyond the limit; it is given up on), internal (the program crashed).
    std::optional<Expected<UsbResetOutcome>> outcome(Duration patience = Duration::zero());

  private:
    UsbReset(ChildProcess process, const UsbResetOptions& options);
    void giveUp();

    std::string portPath_;
    ChildProcess process_;
    std::chrono::steady_clock::time_point deadline_;
    std::optional<Expected<UsbResetOutcome>> outcome_;
};

/// start() and outcome() in one, for a caller that may be held as long as the limit. Errors as theirs.
Expected<UsbResetOutcome> resetSensor(const UsbResetOptions& options);

/// What cheval-usb-reset does and ends with: resets the sensor in this process, which may be held for ever. Returns an
/// exit status; `message` says in words what went wrong and is empty where nothing did.
int resetSensorHere(const std::string& portPath, std::string& message);

}  // namespace cheval::hal

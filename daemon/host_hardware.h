// The rungs above recycle on a real machine: the USB, the sensor's power line, the daemon and the machine itself.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "config/settings.h"
#include "daemon/recovery.h"
#include "hal/clock.h"
#include "hal/gpiod/power_line.h"
#include "hal/usb/usb_reset.h"
#include "hal/usb/usb_watcher.h"

namespace cheval::daemon {

/// How the service ends.
enum class ServiceEnd : std::uint8_t {
    stopped,  ///< Somebody asked for it.
    restart,  ///< To be started anew by systemd, in the hope that it helps the sensor.
    /// The machine is to be started anew: by this process and its successors ending at once, until systemd's restart
    /// limit takes the action that it was given (systemd/cheval.service).
    reboot,
};

struct HostHardwareOptions {
    std::string resetProgram;  ///< cheval-usb-reset.
    /// Where the count of restarts is kept over restarts of the daemon, not of the machine; empty: nowhere, and the
    /// daemon is never restarted.
    std::string runtimeFolder;
    bool supervised = false;      ///< A service manager starts the daemon again.
    hal::PowerLineOptions power;  ///< Without a line there is none.
};

/// From the settings, $RUNTIME_DIRECTORY and $NOTIFY_SOCKET, and where the programs are.
HostHardwareOptions hostHardwareOptions(const config::Settings& settings);

/// A daemon before this one asked for a reboot, which has not come yet.
bool rebootIsDue(const HostHardwareOptions& options);

/// Thread-bound to the frame loop, but for end(), which any thread may call. Takes no memory while the sensor is well.
class HostHardware final : public RecoveryHardware {
  public:
    /// `lines`: where the power line comes from; null: the kernel's.
    HostHardware(HostHardwareOptions options, const hal::Clock& clock,
                 std::unique_ptr<hal::LineProvider> lines = nullptr);
    ~HostHardware() override;

    [[nodiscard]] bool available(RecoveryRung rung) const override;
    Expected<void> perform(RecoveryRung rung) override;
    bool takeArrival() override;
    [[nodiscard]] std::uint32_t restartsBefore() const override { return restartsBefore_; }
    void healthy() override;

    /// Set when the daemon, or the machine, is to be started anew; the process is told by SIGTERM.
    [[nodiscard]] ServiceEnd end() const { return end_.load(std::memory_order_acquire); }

  private:
    [[nodiscard]] bool sensorPluggedIn() const;
    Expected<void> resetUsb();
    Expected<void> endService(ServiceEnd end);

    HostHardwareOptions options_;
    const hal::Clock& clock_;
    std::unique_ptr<hal::UsbWatcher> watcher_;  ///< Null: the USB cannot be watched.
    std::optional<hal::UsbReset> reset_;
    std::unique_ptr<hal::PowerLine> power_;  ///< Null: none is wired.
    hal::TimePoint nextPoll_{};
    std::uint32_t restartsBefore_ = 0;
    std::string countFile_;  ///< Empty: there is none.
    bool counted_ = false;   ///< countFile_ is there and says more than 0.
    std::atomic<ServiceEnd> end_{ServiceEnd::stopped};
};

}  // namespace cheval::daemon

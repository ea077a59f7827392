// What the service manager (systemd) is told: that the mirror is lit, how it does, and that it is alive. Everything
// goes through sd_notify(3); without a service manager nothing is sent.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "daemon/mirror.h"
#include "hal/clock.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// Notices that one of the two threads stands still: the whole of the watchdog's judgement. Thread-bound.
class ProgressWatch {
  public:
    /// True when both counters have changed since the last time that this was true. A change is enough, up or down: a
    /// mirror that was lit again counts from zero.
    bool bothMoved(std::uint64_t loopTurns, std::uint64_t drawTurns);

  private:
    std::uint64_t loopTurns_ = 0;
    std::uint64_t drawTurns_ = 0;
};

/// "wearing: T-shirt, sensor ok": one line for people, without figures that change all the time. `problem` is what a
/// technician should know beside that (refused settings); may be empty.
std::string serviceStatus(const MirrorStatus& status, std::string_view problem);

/// Thread-bound.
class ServiceManager {
  public:
    /// Sends one message in the form of sd_notify(3).
    using Send = std::function<void(const std::string&)>;

    /// `watchdog`: unfed for this long the service is killed; zero: there is no watchdog. `clock` outlives this object.
    ServiceManager(const hal::Clock& clock, hal::Duration watchdog, Send send);
    /// The one that started this process, as its environment says (NOTIFY_SOCKET, WATCHDOG_USEC).
    static ServiceManager ofThisProcess(const hal::Clock& clock);

    /// Call at least every pause(). Says READY as soon as there is a picture on the screen (or the screen, not the
    /// renderer, is what is away), feeds the watchdog if both threads have moved on, and tells what has changed, at
    /// most twice a second.
    void report(const MirrorStatus& status, std::string_view problem);
    /// The settings are being read again; the next report() with a picture ends it. Until then both threads may stand
    /// still for as long as a start may take, a minute, before the watchdog ends the process.
    void reloading();
    void stopping();
    /// The mirror cannot be lit, and why; the process is about to exit.
    void failed(const Error& error);

    /// The longest time between two reports: half a second; less until READY was said and under a short watchdog.
    [[nodiscard]] hal::Duration pause() const;

  private:
    const hal::Clock& clock_;
    hal::Duration watchdog_;
    Send send_;
    ProgressWatch progress_;
    bool ready_ = false;
    bool longWatchdog_ = false;  ///< While reloading.
    std::string told_;           ///< The last STATUS.
    hal::TimePoint toldAt_{};
};

}  // namespace cheval::daemon

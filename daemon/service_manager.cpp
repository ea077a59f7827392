#include "daemon/service_manager.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <systemd/sd-daemon.h>

#include "daemon/log.h"

namespace cheval::daemon {

namespace {

using std::chrono::milliseconds;

constexpr hal::Duration kPause = milliseconds(500);
/// Until READY was said: somebody waits for it.
constexpr hal::Duration kShortPause = milliseconds(50);
/// A mirror that is lit anew loads what it did at its start, so it gets the time of a start (TimeoutStartSec of the
/// unit).
constexpr hal::Duration kReloadLimit = std::chrono::seconds(60);
/// Reports within one watchdog's limit, so that one which comes late is no death.
constexpr int kReportsALimit = 4;

std::int64_t microseconds(hal::Duration duration) {
    return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
}

std::string watchdogLimit(hal::Duration limit) {
    return fmt::format("WATCHDOG_USEC={}\n", microseconds(limit));
}

std::string_view activity(const MirrorStatus& status) {
    switch (status.state) {
        case SessionState::idle:
            return "nobody is there";
        case SessionState::approaching:
            return "somebody comes near";
        case SessionState::acquiring:
            return "somebody is being measured";
        case SessionState::wearing:
            return "wearing";
        case SessionState::leaving:
            return "somebody leaves";
    }
    return "";
}

std::string_view sensor(const MirrorStatus& status) {
    switch (status.camera) {
        case CameraState::closed:
        case CameraState::waiting:
            return "sensor starts";
        case CameraState::streaming:
            return "sensor ok";
        case CameraState::lost:
            return "sensor lost";
        case CameraState::ended:
            return "recording over";
    }
    return "";
}

/// A message to the service manager has a line a field: no text may begin another.
std::string oneLine(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
    return text;
}

void sendToServiceManager(const std::string& message) {
    const int sent = sd_notify(0, message.c_str());
    if (sent >= 0) return;
    static bool told = false;
    // Said once: what follows would fail in the same way, twice a second.
    if (!std::exchange(told, true)) {
        log(Severity::warning, fmt::format("the service manager cannot be told anything: {}", std::strerror(-sent)));
    }
}

}  // namespace

bool ProgressWatch::bothMoved(std::uint64_t loopTurns, std::uint64_t drawTurns) {
    if (loopTurns == loopTurns_ || drawTurns == drawTurns_) return false;
    loopTurns_ = loopTurns;
    drawTurns_ = drawTurns;
    return true;
}

std::string serviceStatus(const MirrorStatus& status, std::string_view problem) {
    std::string text(activity(status));
    if (status.state == SessionState::wearing) text += fmt::format(": {}", status.outfit.view());
    text += fmt::format(", {}", sensor(status));
    if (status.fault.length > 0) text += fmt::format(": {}", status.fault.view());
    if (status.degradeLevel > 0) text += fmt::format(", plainer: {}", status.degradeName);
    if (!problem.empty()) text += fmt::format("; {}", problem);
    return oneLine(std::move(text));
}

ServiceManager::ServiceManager(const hal::Clock& clock, hal::Duration watchdog, Send send)
    : clock_(clock), watchdog_(watchdog), send_(std::move(send)) {}

ServiceManager ServiceManager::ofThisProcess(const hal::Clock& clock) {
    std::uint64_t limit = 0;
    const int watched = sd_watchdog_enabled(0, &limit);
    if (watched < 0) {
        log(Severity::warning,
            fmt::format("the service manager's watchdog is not understood: {}", std::strerror(-watched)));
    }
    // As much as a time point can hold is as good as no watchdog.
    const bool sensible = watched > 0 && limit < std::uint64_t{1} << 50U;
    return {clock, sensible ? std::chrono::microseconds(static_cast<std::int64_t>(limit)) : hal::Duration{},
            sendToServiceManager};
}

void ServiceManager::report(const MirrorStatus& status, std::string_view problem) {
    const hal::TimePoint now = clock_.now();
    std::string message;
    if (!ready_ && status.drawTurns > 0) {
        ready_ = true;
        message = "READY=1\n";
        if (std::exchange(longWatchdog_, false)) message += watchdogLimit(watchdog_);
    }
    if (watchdog_ > hal::Duration{} && progress_.bothMoved(status.turns, status.drawTurns)) message += "WATCHDOG=1\n";
    if (told_.empty() || now - toldAt_ >= kPause) {
        std::string text = serviceStatus(status, problem);
        if (text != told_) {
            message += "STATUS=" + text + "\n";
            told_ = std::move(text);
            toldAt_ = now;
        }
    }
    if (!message.empty()) send_(message);
}

void ServiceManager::reloading() {
    ready_ = false;
    std::string message =
        fmt::format("RELOADING=1\nMONOTONIC_USEC={}\n", microseconds(clock_.now().time_since_epoch()));
    longWatchdog_ = watchdog_ > hal::Duration{} && watchdog_ < kReloadLimit;
    if (longWatchdog_) message += watchdogLimit(kReloadLimit);
    send_(message);
}

void ServiceManager::stopping() {
    send_("STOPPING=1\n");
}

void ServiceManager::failed(const Error& error) {
    send_(fmt::format("STATUS={}\n", oneLine("the mirror cannot be lit: " + error.message())));
}

hal::Duration ServiceManager::pause() const {
    hal::Duration pause = ready_ ? kPause : kShortPause;
    if (watchdog_ > hal::Duration{}) pause = std::min(pause, watchdog_ / kReportsALimit);
    return std::max(pause, hal::Duration(milliseconds(1)));
}

}  // namespace cheval::daemon

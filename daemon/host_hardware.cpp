#include "daemon/host_hardware.h"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include <unistd.h>

#include "config/shipped_files.h"
#include "daemon/log.h"
#include "daemon/room_options.h"
#include "hal/png/png.h"

namespace cheval::daemon {

namespace {

constexpr hal::Duration kPollEvery = std::chrono::milliseconds(250);
constexpr std::size_t kLongestCount = 32;

std::string environmentValue(const char* name) {
    const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): nobody changes the environment.
    return value == nullptr ? std::string() : std::string(value);
}

/// In place of a count.
constexpr std::uint32_t kRebootDue = 1'000'000;

std::string countFileIn(const std::string& folder) {
    return folder.empty() ? folder : (std::filesystem::path(folder) / "sensor-restarts").string();
}

std::uint32_t readCount(const std::string& file) {
    std::vector<std::byte> bytes;
    std::uint32_t count = 0;
    if (file.empty() || !hal::readBytes(file, kLongestCount, bytes)) return 0;
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    std::from_chars(text, text + bytes.size(), count);
    return count;
}

}  // namespace

HostHardwareOptions hostHardwareOptions(const config::Settings& settings) {
    HostHardwareOptions options{.resetProgram = config::shippedPath("lib/cheval/cheval-usb-reset"),
                                .runtimeFolder = environmentValue("RUNTIME_DIRECTORY"),
                                .supervised = !environmentValue("NOTIFY_SOCKET").empty(),
                                .power = powerLineOptions(settings)};
    if (options.resetProgram.empty()) options.resetProgram = config::shippedPath("bin/cheval-usb-reset");
    return options;
}

bool rebootIsDue(const HostHardwareOptions& options) {
    return options.supervised && readCount(countFileIn(options.runtimeFolder)) >= kRebootDue;
}

HostHardware::HostHardware(HostHardwareOptions options, const hal::Clock& clock,
                           std::unique_ptr<hal::LineProvider> lines)
    : options_(std::move(options)), clock_(clock) {
    Expected<std::unique_ptr<hal::UsbWatcher>> watcher = hal::UsbWatcher::start();
    if (watcher) {
        watcher_ = std::move(*watcher);
    } else {
        log(Severity::notice, watcher.error().message());
    }
    if (!options_.power.line.line.empty()) {
        power_ = std::make_unique<hal::PowerLine>(options_.power,
                                                  lines != nullptr ? std::move(lines) : hal::makeGpiodLines(), clock_);
        const Expected<void> held = power_->hold();
        if (!held) log(Severity::warning, held.error().message());
    }
    countFile_ = countFileIn(options_.runtimeFolder);
    restartsBefore_ = readCount(countFile_);
    counted_ = restartsBefore_ > 0;
}

HostHardware::~HostHardware() = default;

bool HostHardware::sensorPluggedIn() const {
    if (watcher_ == nullptr) return false;
    const Expected<std::vector<hal::UsbSensor>> sensors = watcher_->sensors();
    return sensors && !sensors->empty();
}

bool HostHardware::available(RecoveryRung rung) const {
    switch (rung) {
        case RecoveryRung::resetUsb:
            return sensorPluggedIn();
        case RecoveryRung::powerCycle:
            // Asked for anew each time: its chip may have come.
            return power_ != nullptr && power_->hold().hasValue();
        case RecoveryRung::restartDaemon:
        case RecoveryRung::reboot:
            // A sensor that is not there comes back by being plugged in, not by a dark mirror.
            return options_.supervised && !countFile_.empty() && sensorPluggedIn();
        case RecoveryRung::retryRead:
        case RecoveryRung::restartStream:
        case RecoveryRung::reopenDevice:
        case RecoveryRung::recycle:
            break;
    }
    return true;
}

Expected<void> HostHardware::perform(RecoveryRung rung) {
    switch (rung) {
        case RecoveryRung::resetUsb:
            return resetUsb();
        case RecoveryRung::powerCycle:
            if (power_ != nullptr) return power_->cycle();
            break;
        case RecoveryRung::restartDaemon:
            return endService(ServiceEnd::restart);
        case RecoveryRung::reboot:
            return endService(ServiceEnd::reboot);
        default:
            break;
    }
    return Error{.code = ErrorCode::internal, .cause = "there is no such rung on this machine"};
}

Expected<void> HostHardware::resetUsb() {
    if (!reset_) {
        Expected<hal::UsbReset> started = hal::UsbReset::start({.program = options_.resetProgram});
        if (!started) return std::move(started).error();
        reset_.emplace(std::move(*started));
        log(Severity::warning, "the sensor's USB device is reset");
    }
    std::optional<Expected<hal::UsbResetOutcome>> outcome = reset_->outcome();
    if (!outcome) return Error{.code = ErrorCode::timedOut, .cause = "the reset is not over"};
    reset_.reset();
    if (!*outcome) {
        // To the caller timedOut would mean "not over yet".
        Error error = std::move(*outcome).error();
        if (error.code == ErrorCode::timedOut) error.code = ErrorCode::unavailable;
        return error;
    }
    return {};
}

Expected<void> HostHardware::endService(ServiceEnd end) {
    if (this->end() != ServiceEnd::stopped) return Error{.code = ErrorCode::timedOut, .cause = "the daemon ends"};
    const std::string count = std::to_string(end == ServiceEnd::reboot ? kRebootDue : restartsBefore_ + 1) + "\n";
    const Expected<void> written = hal::writeBytes(countFile_, std::as_bytes(std::span(count)));
    // Without the count there would be no end to restarting.
    if (!written) return written.error();
    log(Severity::error, end == ServiceEnd::reboot ? "no frames, whatever was tried: the machine is started anew"
                                                   : "no frames, whatever was tried: the daemon is started anew");
    end_.store(end, std::memory_order_release);
    ::kill(::getpid(), SIGTERM);
    // Over when the process is.
    return Error{.code = ErrorCode::timedOut, .cause = "the daemon ends"};
}

bool HostHardware::takeArrival() {
    const hal::TimePoint now = clock_.now();
    if (watcher_ == nullptr || now < nextPoll_) return false;
    nextPoll_ = now + kPollEvery;
    if (!watcher_->poll()) return false;
    bool arrived = false;
    for (hal::UsbEvent event; watcher_->take(event);)
        arrived = arrived || event.change == hal::UsbChange::arrived;
    return arrived;
}

void HostHardware::healthy() {
    if (!std::exchange(counted_, false)) return;
    restartsBefore_ = 0;
    std::error_code failed;
    std::filesystem::remove(countFile_, failed);
}

}  // namespace cheval::daemon

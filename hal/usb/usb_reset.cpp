#include "hal/usb/usb_reset.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include <libusb.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
extern "C" {
#include <sys/pidfd.h>  // glibc 2.36 forgets to say that it is C.
}

#include "hal/usb/usb_bus.h"

namespace cheval::hal {

namespace {

using SteadyTime = std::chrono::steady_clock;

/// What cheval-usb-reset ends with. 127 is what a program that cannot be started ends with.
enum class Exit : std::uint8_t {
    reset = 0,
    reEnumerating = 10,
    noSuchSensor = 11,
    severalSensors = 12,
    denied = 13,
    noUsb = 14,
    refused = 15,
};

/// A reset that was given up on and is still held by the kernel; -1: there is none.
std::atomic<pid_t> abandoned{-1};

std::string sensorAt(const std::string& portPath) {
    return portPath.empty() ? "the sensor" : "the sensor at port " + portPath;
}

Expected<UsbResetOutcome> explain(Exit exit, const std::string& portPath) {
    switch (exit) {
        case Exit::reset:
            return UsbResetOutcome::reset;
        case Exit::reEnumerating:
            return UsbResetOutcome::reEnumerating;
        case Exit::noSuchSensor:
            return Error{.code = ErrorCode::notFound,
                         .cause = sensorAt(portPath) + " is not plugged in",
                         .mend = "look at its cable, plug and power"};
        case Exit::severalSensors:
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "more than one sensor is plugged in",
                         .mend = "name the port of the one to reset"};
        case Exit::denied:
            return Error{.code = ErrorCode::unavailable,
                         .cause = sensorAt(portPath) + " may not be reset by this user",
                         .mend = "install the udev rules of the mirror and plug the sensor in again"};
        case Exit::noUsb:
            return Error{.code = ErrorCode::unavailable,
                         .cause = "the USB cannot be reached",
                         .mend = "let the mirror open netlink sockets (AF_NETLINK) and enough files",
                         .why = "libusb hears from udev through them what comes and goes"};
        case Exit::refused:
            return Error{.code = ErrorCode::unavailable,
                         .cause = sensorAt(portPath) + " refused the reset",
                         .mend = "switch its power off and on"};
    }
    return Error{.code = ErrorCode::internal,
                 .cause = "the reset ended with the unknown status " + std::to_string(static_cast<int>(exit)),
                 .mend = "install chevald and cheval-usb-reset of the same version"};
}

Expected<UsbResetOutcome> explainStatus(int status, const std::string& portPath) {
    if (WIFEXITED(status)) return explain(static_cast<Exit>(WEXITSTATUS(status)), portPath);
    return Error{.code = ErrorCode::internal,
                 .cause = "the program that resets the sensor was ended by signal " + std::to_string(WTERMSIG(status)),
                 .mend = "switch the sensor's power off and on"};
}

struct DeviceListDeleter {
    void operator()(libusb_device** devices) const { libusb_free_device_list(devices, 1); }
};
struct HandleDeleter {
    void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
};

Exit exitOf(int code) {
    if (code == LIBUSB_SUCCESS) return Exit::reset;
    // The kernel took it away and finds it again, perhaps with another face: that is what a reset is for.
    if (code == LIBUSB_ERROR_NOT_FOUND || code == LIBUSB_ERROR_NO_DEVICE) return Exit::reEnumerating;
    return code == LIBUSB_ERROR_ACCESS ? Exit::denied : Exit::refused;
}

Exit resetOne(const std::string& portPath) {
    const Expected<UsbContext> context = openUsb();
    if (!context) return Exit::noUsb;
    libusb_device** all = nullptr;
    if (libusb_get_device_list(context->get(), &all) < 0) return Exit::noUsb;
    const std::unique_ptr<libusb_device*, DeviceListDeleter> devices(all);
    libusb_device* chosen = nullptr;
    for (libusb_device** device = all; *device != nullptr; ++device) {
        const std::optional<UsbSensor> sensor = describeSensor(*device);
        if (!sensor || (!portPath.empty() && sensor->portPath != portPath)) continue;
        if (chosen != nullptr) return Exit::severalSensors;
        chosen = *device;
    }
    if (chosen == nullptr) return Exit::noSuchSensor;
    libusb_device_handle* opened = nullptr;
    if (const int code = libusb_open(chosen, &opened); code != LIBUSB_SUCCESS) {
        return code == LIBUSB_ERROR_NO_DEVICE ? Exit::noSuchSensor : exitOf(code);
    }
    const std::unique_ptr<libusb_device_handle, HandleDeleter> handle(opened);
    return exitOf(libusb_reset_device(opened));
}

/// What a started process takes with it: no descriptor but the three standard ones, no blocked signal.
class SpawnPlan {
  public:
    SpawnPlan() {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_addclosefrom_np(&actions_, STDERR_FILENO + 1);
        posix_spawnattr_init(&attributes_);
        sigset_t none;
        sigemptyset(&none);
        posix_spawnattr_setsigmask(&attributes_, &none);
        posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK);
    }
    ~SpawnPlan() {
        posix_spawnattr_destroy(&attributes_);
        posix_spawn_file_actions_destroy(&actions_);
    }
    SpawnPlan(const SpawnPlan&) = delete;
    SpawnPlan& operator=(const SpawnPlan&) = delete;

    int start(std::vector<std::string> words, pid_t& process) const {
        std::vector<char*> arguments;
        arguments.reserve(words.size() + 1);
        for (std::string& word : words)
            arguments.push_back(word.data());
        arguments.push_back(nullptr);
        return posix_spawn(&process, arguments.front(), &actions_, &attributes_, arguments.data(), environ);
    }

  private:
    posix_spawn_file_actions_t actions_{};
    posix_spawnattr_t attributes_{};
};

bool abandonedStillHangs() {
    const pid_t process = abandoned.load();
    if (process < 0) return false;
    if (::waitpid(process, nullptr, WNOHANG) == 0) return true;
    abandoned = -1;
    return false;
}

/// True as soon as the process is over.
bool waitForEnd(int descriptor, Duration patience) {
    const auto until = SteadyTime::now() + patience;
    while (true) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - SteadyTime::now());
        pollfd watched{.fd = descriptor, .events = POLLIN, .revents = 0};
        const int ready = ::poll(&watched, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 60'000)));
        if (ready > 0) return true;
        if (SteadyTime::now() >= until || (ready < 0 && errno != EINTR)) return false;
    }
}

}  // namespace

Expected<UsbReset> UsbReset::start(const UsbResetOptions& options) {
    if (abandonedStillHangs()) {
        return Error{.code = ErrorCode::unavailable,
                     .cause = "an earlier reset of the sensor still hangs",
                     .mend = "switch the sensor's power off and on",
                     .why = "the kernel waits for the device, and nothing but the device can end that"};
    }
    UsbReset reset;
    reset.portPath_ = options.portPath;
    reset.deadline_ = SteadyTime::now() + options.limit;
    std::vector<std::string> words{options.program};
    if (!options.portPath.empty()) words.push_back(options.portPath);
    if (const int fault = SpawnPlan().start(std::move(words), reset.process_)) {
        reset.process_ = -1;
        return Error{.code = fault == ENOENT || fault == EACCES ? ErrorCode::notFound : ErrorCode::resource,
                     .cause = std::string("the program that resets the sensor cannot be started: ") +
                              std::strerror(fault),  // NOLINT(concurrency-mt-unsafe): glibc's is safe.
                     .mend = "install it again",
                     .file = options.program};
    }
    reset.descriptor_ = ::pidfd_open(reset.process_, 0);
    if (reset.descriptor_ < 0) {
        const int fault = errno;
        reset.giveUp();
        return Error{.code = ErrorCode::resource,
                     .cause = std::string("the reset cannot be waited for: ") +
                              std::strerror(fault)};  // NOLINT(concurrency-mt-unsafe): glibc's is safe.
    }
    return reset;
}

UsbReset::UsbReset(UsbReset&& other) noexcept
    : portPath_(std::move(other.portPath_)),
      process_(std::exchange(other.process_, -1)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      deadline_(other.deadline_),
      outcome_(std::move(other.outcome_)) {}

UsbReset::~UsbReset() {
    giveUp();
    if (descriptor_ >= 0) ::close(descriptor_);
}

void UsbReset::giveUp() {
    if (process_ < 0) return;
    ::kill(process_, SIGKILL);
    // One that is not in the kernel's hands is over as soon as it is scheduled.
    constexpr Duration kMoment = std::chrono::milliseconds(100);
    if (descriptor_ >= 0) waitForEnd(descriptor_, kMoment);
    if (::waitpid(process_, nullptr, WNOHANG) == 0) abandoned = process_;
    process_ = -1;
}

std::optional<Expected<UsbResetOutcome>> UsbReset::outcome(Duration patience) {
    if (outcome_) return outcome_;
    const Duration left = std::max<Duration>(deadline_ - SteadyTime::now(), Duration::zero());
    if (waitForEnd(descriptor_, std::min(patience, left))) {
        int status = 0;
        const pid_t ended = ::waitpid(process_, &status, WNOHANG);
        if (ended == process_) {
            outcome_ = explainStatus(status, portPath_);
        } else {
            outcome_ = Error{.code = ErrorCode::internal,
                             .cause = "what came of the reset was taken by another part of the program"};
        }
        process_ = -1;
        return outcome_;
    }
    if (SteadyTime::now() < deadline_) return std::nullopt;
    giveUp();
    outcome_ = Error{.code = ErrorCode::timedOut,
                     .cause = "the reset of " + sensorAt(portPath_) + " did not end in time",
                     .mend = "switch its power off and on",
                     .why = "the device does not answer the kernel"};
    return outcome_;
}

Expected<UsbResetOutcome> resetSensor(const UsbResetOptions& options) {
    Expected<UsbReset> reset = UsbReset::start(options);
    if (!reset) return std::move(reset).error();
    while (true) {
        if (auto outcome = reset->outcome(options.limit)) return *std::move(outcome);
    }
}

int resetSensorHere(const std::string& portPath, std::string& message) {
    const Exit exit = resetOne(portPath);
    const Expected<UsbResetOutcome> outcome = explain(exit, portPath);
    message = outcome ? std::string() : outcome.error().message();
    return static_cast<int>(exit);
}

}  // namespace cheval::hal

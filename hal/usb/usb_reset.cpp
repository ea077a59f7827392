#include "hal/usb/usb_reset.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <memory>
#include <optional>
#include <utility>

#include <libusb.h>

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

}  // namespace

Expected<UsbReset> UsbReset::start(const UsbResetOptions& options) {
    ChildProcess::reapAbandoned();
    if (abandoned.load() >= 0 && ::kill(abandoned.load(), 0) == 0) {
        return Error{.code = ErrorCode::unavailable,
                     .cause = "an earlier reset of the sensor still hangs",
                     .mend = "switch the sensor's power off and on",
                     .why = "the kernel waits for the device, and nothing but the device can end that"};
    }
    abandoned = -1;
    ChildProcess::Start start{.program = options.program};
    if (!options.portPath.empty()) start.arguments.push_back(options.portPath);
    Expected<ChildProcess> process = ChildProcess::start(start);
    if (!process) return std::move(process).error().within("while resetting the sensor");
    return UsbReset(std::move(*process), options);
}

UsbReset::UsbReset(ChildProcess process, const UsbResetOptions& options)
    : portPath_(options.portPath), process_(std::move(process)), deadline_(SteadyTime::now() + options.limit) {}

void UsbReset::giveUp() {
    // One that is not in the kernel's hands is over as soon as it is scheduled.
    constexpr Duration kMoment = std::chrono::milliseconds(100);
    const pid_t pid = process_.pid();
    if (pid >= 0 && !process_.kill(kMoment)) abandoned = pid;
}

std::optional<Expected<UsbResetOutcome>> UsbReset::outcome(Duration patience) {
    if (outcome_) return outcome_;
    const Duration left = std::max<Duration>(deadline_ - SteadyTime::now(), Duration::zero());
    if (process_.waitEnd(std::min(patience, left))) {
        outcome_ = process_.exitStatus() >= 0
                       ? explain(static_cast<Exit>(process_.exitStatus()), portPath_)
                       : Error{.code = ErrorCode::internal,
                               .cause = "the program that resets the sensor " + process_.ending(),
                               .mend = "switch the sensor's power off and on"};
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

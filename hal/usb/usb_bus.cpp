#include "hal/usb/usb_bus.h"

#include <algorithm>
#include <array>
#include <utility>

#include <libusb.h>

#include "hal/usb/sensor_ids.h"

namespace cheval::hal {

namespace {

/// A hub more than seven tiers down would not work, says the USB specification.
constexpr int kMostTiers = 7;

double megabits(int speed) {
    switch (speed) {
        case LIBUSB_SPEED_LOW:
            return 1.5;
        case LIBUSB_SPEED_FULL:
            return 12.0;
        case LIBUSB_SPEED_HIGH:
            return 480.0;
        case LIBUSB_SPEED_SUPER:
            return 5000.0;
        case LIBUSB_SPEED_SUPER_PLUS:
            return 10000.0;
        default:
            return 0.0;
    }
}

std::string portPathOf(libusb_device* device) {
    std::array<std::uint8_t, kMostTiers> ports{};
    const int count = libusb_get_port_numbers(device, ports.data(), kMostTiers);
    std::string path = std::to_string(libusb_get_bus_number(device));
    for (int i = 0; i < count; ++i) {
        path += i == 0 ? '-' : '.';
        path += std::to_string(ports.at(static_cast<std::size_t>(i)));
    }
    return path;
}

}  // namespace

void UsbContextDeleter::operator()(libusb_context* context) const {
    libusb_exit(context);
}

Error usbError(int code, std::string_view attempt) {
    Error error{.code = ErrorCode::unavailable,
                .cause = std::string(attempt) + ": " + libusb_strerror(code),
                .mend = "look at the sensor's cable and plug"};
    if (code == LIBUSB_ERROR_ACCESS) {
        error.mend = "install the udev rules of the mirror and plug the sensor in again";
        error.why = "this user may not use the device";
    } else if (code == LIBUSB_ERROR_NO_MEM) {
        error.code = ErrorCode::resource;
        error.mend = "free some memory";
    }
    return error;
}

Expected<UsbContext> openUsb() {
    libusb_context* context = nullptr;
    if (const int code = libusb_init(&context); code != LIBUSB_SUCCESS) {
        Error error = usbError(code, "the USB cannot be reached");
        if (code == LIBUSB_ERROR_OTHER) {
            error.mend = "let the mirror open netlink sockets (AF_NETLINK) and enough files";
            error.why = "libusb hears from udev through them what comes and goes";
        }
        return error;
    }
    return UsbContext(context);
}

std::optional<UsbSensor> describeSensor(libusb_device* device) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS) return std::nullopt;
    const SensorId* id = findSensorId(descriptor.idVendor, descriptor.idProduct);
    if (id == nullptr) return std::nullopt;
    return UsbSensor{.vendor = descriptor.idVendor,
                     .product = descriptor.idProduct,
                     .bus = libusb_get_bus_number(device),
                     .address = libusb_get_device_address(device),
                     .portPath = portPathOf(device),
                     .name = id->name,
                     .driver = id->driver,
                     .megabitsPerSecond = megabits(libusb_get_device_speed(device))};
}

Expected<std::vector<UsbSensor>> listSensors(libusb_context* context) {
    libusb_device** devices = nullptr;
    const auto count = libusb_get_device_list(context, &devices);
    if (count < 0) return usbError(static_cast<int>(count), "the USB devices cannot be listed");
    std::vector<UsbSensor> sensors;
    for (libusb_device** device = devices; *device != nullptr; ++device) {
        if (std::optional<UsbSensor> sensor = describeSensor(*device)) sensors.push_back(std::move(*sensor));
    }
    libusb_free_device_list(devices, 1);
    std::sort(sensors.begin(), sensors.end(),
              [](const UsbSensor& a, const UsbSensor& b) { return a.portPath < b.portPath; });
    return sensors;
}

}  // namespace cheval::hal

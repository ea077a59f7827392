// libusb's context and what every user of it here needs. Only hal/usb includes this.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/expected.h"
#include "hal/usb/usb_sensor.h"

struct libusb_context;
struct libusb_device;

namespace cheval::hal {

struct UsbContextDeleter {
    void operator()(libusb_context* context) const;
};
using UsbContext = std::unique_ptr<libusb_context, UsbContextDeleter>;

/// Errors: unavailable (libusb cannot listen to udev), resource.
Expected<UsbContext> openUsb();
/// What libusb's code means, for people.
Error usbError(int code, std::string_view attempt);
/// The device as a sensor; empty: it is none that sensor_ids.h knows.
std::optional<UsbSensor> describeSensor(libusb_device* device);
/// The sensors that are plugged in now, in the order of their port paths. Errors as openUsb().
Expected<std::vector<UsbSensor>> listSensors(libusb_context* context);

}  // namespace cheval::hal

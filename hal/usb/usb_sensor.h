// A depth sensor on the USB, as plain values.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cheval::hal {

struct UsbSensor {
    std::uint16_t vendor = 0;
    std::uint16_t product = 0;
    std::uint8_t bus = 0;
    std::uint8_t address = 0;  ///< Changes each time the device is plugged in or found again; `portPath` does not.
    std::string portPath;      ///< Where it is plugged in, as the kernel writes it: bus-port[.port…], e.g. "1-2.3".
    std::string_view name;     ///< From sensor_ids.h.
    std::string_view driver;   ///< OpenNI2's driver, from sensor_ids.h.
    double megabitsPerSecond = 0.0;  ///< As negotiated: 12, 480, 5000 …; 0: unknown.
};

}  // namespace cheval::hal

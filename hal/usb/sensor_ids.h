// The depth sensors that the mirror knows, by USB vendor and product number, and the OpenNI2 driver that serves each.
// The one list of them: the udev rules that give the mirror access are held to it.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace cheval::hal {

/// A sensor, or a family of them with consecutive product numbers. Immutable.
struct SensorId {
    std::uint16_t vendor = 0;
    std::uint16_t firstProduct = 0;
    std::uint16_t lastProduct = 0;  ///< Inclusive.
    std::string_view name;          ///< For people.
    std::string_view driver;        ///< OpenNI2's driver, as in lib<driver>.so.
    bool packaged = false;          ///< Debian's libopenni2-0 brings that driver; else it must be installed.
};

/// Products 0500 … f9db: the drivers PS1080 and PSLink of OpenNI2 2.2. Kinect v1: the OpenNI2 driver of libfreenect.
/// Orbbec: the vendor's own driver, which takes 04xx and 06xx.
inline constexpr std::array<SensorId, 14> kSensorIds{{
    {0x1d27, 0x0500, 0x0500, "PrimeSense or ASUS depth sensor", "PS1080", true},
    {0x1d27, 0x0600, 0x0600, "PrimeSense or ASUS depth sensor", "PS1080", true},
    {0x1d27, 0x0601, 0x0601, "PrimeSense or ASUS depth sensor", "PS1080", true},
    {0x1d27, 0x0609, 0x0609, "PrimeSense or ASUS depth sensor", "PS1080", true},
    {0x1d27, 0x1250, 0x1250, "PrimeSense depth sensor", "PSLink", true},
    {0x1d27, 0x1260, 0x1260, "PrimeSense depth sensor", "PSLink", true},
    {0x1d27, 0x1270, 0x1270, "PrimeSense depth sensor", "PSLink", true},
    {0x1d27, 0x1280, 0x1280, "PrimeSense depth sensor", "PSLink", true},
    {0x1d27, 0x1290, 0x1290, "PrimeSense depth sensor", "PSLink", true},
    {0x1d27, 0xf9db, 0xf9db, "PrimeSense depth sensor", "PSLink", true},
    {0x045e, 0x02ae, 0x02ae, "Microsoft Kinect", "FreenectDriver", false},
    {0x045e, 0x02bf, 0x02bf, "Microsoft Kinect for Windows", "FreenectDriver", false},
    {0x2bc5, 0x0400, 0x04ff, "Orbbec Astra", "orbbec", false},
    {0x2bc5, 0x0600, 0x06ff, "Orbbec Astra", "orbbec", false},
}};

/// The entry that a device belongs to; null: no depth sensor that the mirror knows.
constexpr const SensorId* findSensorId(std::uint16_t vendor, std::uint16_t product) {
    for (const SensorId& id : kSensorIds) {
        if (id.vendor == vendor && product >= id.firstProduct && product <= id.lastProduct) return &id;
    }
    return nullptr;
}

}  // namespace cheval::hal

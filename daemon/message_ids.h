// The journal's message IDs: what a technician may meet. What each means and what to do about it is in
// systemd/cheval.catalog, which journalctl -x shows beside the message.
#pragma once

#include <string_view>

namespace cheval::daemon::message {

inline constexpr std::string_view kSensorLost =
    "2e3d25b77762468aa4de0835b8f91189";  ///< There are no frames from the sensor.
inline constexpr std::string_view kSettingsRefused =
    "a45f23b2b97742ba8c966d7d5aa6ab7d";  ///< A setting, or a whole file of them, is refused.
inline constexpr std::string_view kGarmentRefused =
    "9fd7d67492d04662990b816a826a94a1";  ///< A garment, or a size table, is refused.
inline constexpr std::string_view kPictureNotShown =
    "154307a9731a4ce2b50aab905d648840";  ///< A picture cannot be drawn or shown.
inline constexpr std::string_view kNotLit = "d1485beaed214def8343ff7942675e75";  ///< The mirror cannot be lit.

}  // namespace cheval::daemon::message

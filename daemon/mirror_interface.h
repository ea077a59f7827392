// org.cheval.Mirror1, as both of its ends write it. Once shipped, nothing here changes its name, type or meaning; what
// is new is added, and what must change becomes Mirror2.
//
//   property         type          signal  meaning
//   State            s             yes     "starting", then the session's: "idle", "approaching", "acquiring",
//                                          "wearing", "leaving"
//   Outfit           s             yes     the id of the outfit that is chosen
//   Outfits          a(ss)                 id and name, in the order of Next
//   View             s                     "mirror" or "avatar"
//   FramesPerSecond  d                     pictures shown
//   DegradeLevel     u                     0: all details
//   DegradeName      s                     that rung's
//   Visits, Frames, Pictures  t            since the mirror was lit
//   Uptime           t                     seconds since the daemon started
//   Version, Renderer  s
//   Health           a(ssstt)      yes     part, state ("ok", "absent by design", "degraded", "at fault"), reason,
//                                          since: microseconds since 1970, and of the steady clock
//   Overall          s             yes     the worst of these states
//   Tasks            a(sttttttttt)         name, budget, minimum, mean, 99th percentile, maximum (microseconds), runs,
//                                          overruns, skips, of the frame loop and of the renderer, and 1 where the row
//                                          is a thread's whole frame, else 0
//   Recovery         a(st)                 how often each rung of the sensor's recovery was taken
//
// Methods: NextOutfit(), PreviousOutfit(), SetOutfit(s: id or name), SetView(s), Reload(). Changes are told by
// PropertiesChanged at most twice a second.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <sdbus-c++/sdbus-c++.h>

namespace cheval::daemon::mirror1 {

inline constexpr const char* kName = "org.cheval.Mirror1";
inline constexpr const char* kPath = "/org/cheval/Mirror1";
inline constexpr const char* kInterface = "org.cheval.Mirror1";

inline constexpr const char* kUnknownOutfit = "org.cheval.Error.UnknownOutfit";
inline constexpr const char* kUnknownView = "org.cheval.Error.UnknownView";
inline constexpr const char* kBusy = "org.cheval.Error.Busy";          ///< Too many wishes at once; ask again.
inline constexpr const char* kNotReady = "org.cheval.Error.NotReady";  ///< The mirror is not lit yet.

using OutfitRow = sdbus::Struct<std::string, std::string>;
using HealthRow = sdbus::Struct<std::string, std::string, std::string, std::uint64_t, std::uint64_t>;
using TaskRow = sdbus::Struct<std::string, std::uint64_t, std::uint64_t, std::uint64_t, std::uint64_t, std::uint64_t,
                              std::uint64_t, std::uint64_t, std::uint64_t, std::uint64_t>;
using RecoveryRow = sdbus::Struct<std::string, std::uint64_t>;

}  // namespace cheval::daemon::mirror1

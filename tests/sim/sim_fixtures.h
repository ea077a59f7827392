// What the tests of the simulated kiosk share.
#pragma once

#include <cstdint>

#include "hal/image.h"
#include "hal/sim/motion.h"
#include "hal/sim/world.h"

namespace cheval::hal::sim::test {

inline constexpr std::uint32_t kKindsOfPeople = 6;  ///< They take turns.

/// World time of a moment of the script in a visit.
inline double worldTime(const WorldOptions& options, std::uint32_t visit, double scriptTime) {
    return visit * (options.visitSeconds + options.pauseSeconds) + scriptTime * options.visitSeconds / kScriptSeconds;
}

/// The frame nearest to it.
inline std::uint64_t frameAt(const WorldOptions& options, std::uint32_t visit, double scriptTime) {
    return static_cast<std::uint64_t>(worldTime(options, visit, scriptTime) * options.framesPerSecond + 0.5);
}

inline constexpr double kInPause = 22.0;  ///< Script time at which nobody is there.

}  // namespace cheval::hal::sim::test

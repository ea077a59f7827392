#pragma once

#include <cstdint>

namespace cheval::hal::sim {

/// The whole number nearest to a value that is not negative. Unlike std::lround, a loop of these runs on vectors.
inline std::int32_t nearestWhole(float notNegative) {
    const float raised = notNegative + 0.5F;
    return static_cast<std::int32_t>(raised);
}

}  // namespace cheval::hal::sim

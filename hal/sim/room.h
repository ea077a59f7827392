// The shop behind the shopper: floor, back wall, a clothes rack. It never moves, so it is drawn once.
#pragma once

#include "hal/image.h"
#include "hal/sim/shopper.h"
#include "hal/sim/view.h"

namespace cheval::hal::sim {

inline constexpr float kWallDepth = 4.2F;  ///< Back wall, metres from the glass.

/// What one pixel of the empty room shows. Immutable once made.
struct Room {
    Image<Rgb8> colour;
    Image<float> depth;  ///< Millimetres along z, exact; 0 where there is nothing.
    Image<Material> material;
};
Room makeRoom(const View& view, std::uint32_t seed);

}  // namespace cheval::hal::sim

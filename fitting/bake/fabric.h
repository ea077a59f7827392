// Paints the cloth: knit and denim, ribs, seams and stitches, in the flat pattern's own metres.
#pragma once

#include <cstdint>

#include "fitting/bake/pattern_layout.h"
#include "hal/image.h"

namespace cheval::fitting::bake {

/// An sRGB colour, 0…1.
using Colour = Eigen::Vector3d;

enum class Weave : std::uint8_t {
    jersey,   ///< Plain knit, heather.
    striped,  ///< The same with woven-in stripes.
    denim,
    chino,
};

struct Fabric {
    Weave weave = Weave::jersey;
    Colour main = Colour::Ones();
    Colour second = Colour::Zero();  ///< Stripes, print or stitches.
    bool print = false;              ///< The mirror mark on the chest.
};

inline constexpr int kTexturePixels = 1024;

/// Paints all panels; what lies between them continues their colour, so that coarser mip levels do not bleed.
hal::Image<hal::Rgba8> paint(const PatternLayout& layout, const Fabric& fabric);

}  // namespace cheval::fitting::bake

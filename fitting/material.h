// What a surface looks like.
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "hal/image.h"

namespace cheval::fitting {

/// glTF 2.0 metallic-roughness, as far as cloth needs it. Colours are linear, 0…1.
struct Material {
    std::string name;
    Eigen::Vector4f baseColour = Eigen::Vector4f::Ones();
    float roughness = 0.9F;
    hal::Image<hal::Rgba8> baseColourTexture;  ///< sRGB; empty: baseColour alone. Row 0 is v = 0 (glTF: top).
    bool doubleSided = false;
};

}  // namespace cheval::fitting

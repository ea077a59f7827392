// The shopper's body as measured, and as a shape that garments can follow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <Eigen/Core>

namespace cheval::fitting {

enum class Dimension : std::uint8_t {
    stature,
    chestGirth,
    waistGirth,
    hipGirth,
    neckGirth,
    shoulderBreadth,
    armLength,
    insideLeg,
};
inline constexpr std::size_t kDimensionCount = 8;
/// Names as the tracks file has them.
inline constexpr std::array<std::string_view, kDimensionCount> kDimensionNames = {
    "stature", "chest_girth", "waist_girth", "hip_girth", "neck_girth", "shoulder_breadth", "arm_length", "inside_leg"};

/// A length in metres with its standard uncertainty.
struct Measurement {
    float value = 0.0F;
    float uncertainty = 0.0F;
    bool valid = false;  ///< False: cannot tell (yet).
};

struct Measurements {
    std::array<Measurement, kDimensionCount> dimensions{};
    int frames = 0;  ///< Frames averaged so far.
    bool converged = false;

    Measurement& operator[](Dimension dimension) { return dimensions[static_cast<std::size_t>(dimension)]; }
    const Measurement& operator[](Dimension dimension) const { return dimensions[static_cast<std::size_t>(dimension)]; }
};

/// What shapes the body mesh, its cage and its capsules. For now the mannequin scaled along its axes (D12): x breadth,
/// y height, z depth = mean of both. `revision` rises by one whenever the shape changes, so that whoever follows it
/// knows.
struct BodyShape {
    Eigen::Vector3f scale = Eigen::Vector3f::Ones();
    bool measured = false;  ///< A shopper shaped it; false: the mannequin as it is, before the first estimate.
    bool converged = false;
    std::uint32_t revision = 0;
};

}  // namespace cheval::fitting

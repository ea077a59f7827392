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

/// Why the measurements say nothing about a size (yet).
enum class MeasurementDoubt : std::uint8_t {
    none,
    measuring,     ///< Not seen well for long enough yet.
    child,         ///< A child: the charts are for grown-ups.
    seated,        ///< Sits: girths of who sits are not those of who stands.
    looseClothes,  ///< Clothes so wide that the body in them cannot be told.
    partlySeen,    ///< Only the upper body, or not the whole trunk, is in the picture.
    crowded,       ///< Somebody else is too near to tell two people's outlines apart.
    tiltUnknown,   ///< The sensor does not know where the floor is.
};

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
    MeasurementDoubt doubt = MeasurementDoubt::measuring;

    Measurement& operator[](Dimension dimension) { return dimensions[static_cast<std::size_t>(dimension)]; }
    const Measurement& operator[](Dimension dimension) const { return dimensions[static_cast<std::size_t>(dimension)]; }
};

/// What the body model can be told: the first eight are those of Dimension. Each is the change against the mannequin in
/// metres, and +1 of one changes that dimension by a metre and none of the other lengths and girths, to first order.
/// `masculine` has no unit: −1 a woman's build, +1 a man's, at the same lengths and girths.
enum class ShapeParameter : std::uint8_t {
    stature,
    chestGirth,
    waistGirth,
    hipGirth,
    neckGirth,
    shoulderBreadth,
    armLength,
    insideLeg,
    headHeight,  ///< Chin to crown.
    chestDepth,  ///< Front to back at the bust points.
    waistDepth,  ///< Front to back at the waist: the belly.
    hipDepth,    ///< Front to back at the hips: the seat.
    thighGirth,  ///< All limbs grow with it.
    waistRise,   ///< Of the natural waist above its usual place between crotch and neck.
    bust,        ///< How far the breasts stand out.
    masculine,
    chestSquareness,  ///< How far flanks and shoulder blades stand out of an oval chest.
    ribs,             ///< Girth between waist and chest …
    flanks,           ///< … and between hips and waist, more than comes of those three.
};
inline constexpr std::size_t kShapeParameterCount = 19;
/// Names as the body's asset and config/anthropometry have them.
inline constexpr std::array<std::string_view, kShapeParameterCount> kShapeParameterNames = {
    "stature",    "chest_girth", "waist_girth",      "hip_girth",   "neck_girth", "shoulder_breadth", "arm_length",
    "inside_leg", "head_height", "chest_depth",      "waist_depth", "hip_depth",  "thigh_girth",      "waist_rise",
    "bust",       "masculine",   "chest_squareness", "ribs",        "flanks"};
using ShapeParameters = Eigen::Matrix<float, static_cast<int>(kShapeParameterCount), 1>;

constexpr std::size_t index(ShapeParameter parameter) {
    return static_cast<std::size_t>(parameter);
}

/// What shapes the body mesh, its cage and its capsules: at first the mannequin scaled along its axes (D12: x breadth,
/// y height, z depth = mean of both), then the body model's parameters, and between them a mixture of both. `revision`
/// rises by one whenever the shape changes, so that whoever follows it knows.
struct BodyShape {
    Eigen::Vector3f scale = Eigen::Vector3f::Ones();
    ShapeParameters parameters = ShapeParameters::Zero();
    float fitted = 0.0F;    ///< 0: scaled by `scale` alone; 1: the body model with its parameters alone.
    bool measured = false;  ///< A shopper shaped it; false: the mannequin as it is, before the first estimate.
    bool converged = false;
    std::uint32_t revision = 0;
};

}  // namespace cheval::fitting

// The bare body's cross-sections, which skin and clothes are lofted through and which the true girths are cut from.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "hal/sim/loft.h"
#include "hal/sim/rig.h"
#include "hal/sim/shopper.h"

namespace cheval::hal::sim {

/// A smooth step from 0 to 1 while `value` goes from `from` to `to`, which may be the smaller one.
float smoothStep(float from, float to, float value);
Hold heldBy(std::size_t first);
Hold heldBy(std::size_t first, std::size_t second, float share);

/// A level of the trunk: height as a share of the way from crotch (0) to neck base (1), half sizes as shares of the
/// stature for an average build, and what build adds.
struct Level {
    float height, width, front, back;
    float widthByBuild, frontByBuild;
};
inline constexpr std::size_t kTrunkLevelCount = 19;
extern const std::array<Level, kTrunkLevelCount> kTrunkLevels;
inline constexpr int kTrunkSegments = 40;
/// The skull's top lies this share of the head's height below the crown that the head was drawn to.
inline constexpr float kCrownBelow = 0.008F;
// Where tapes lie: nipples, and the waist between the lowest rib and the hip bone.
inline constexpr float kBustHeight = 0.67F;
inline constexpr float kWaistHeight = 0.42F;

/// The trunk's sections, all horizontal, in the rest pose.
struct Trunk {
    const Shopper& shopper;
    const Rig& rig;
    float crotch, neckBase;  ///< Metres above the floor.

    Trunk(const Shopper& theShopper, const Rig& theRig);
    [[nodiscard]] Ring at(const Level& level, float ease, const Eigen::Vector3f& colour) const;
    [[nodiscard]] static Hold hold(float height);
    /// The bare section at any height, on the skin between two of the table's levels.
    [[nodiscard]] Ring section(float height, const Eigen::Vector3f& colour) const;
};

float neckRadius(const Shopper& shopper);
inline constexpr std::size_t kNeckRingCount = 7;
inline constexpr int kNeckSegments = 28;
/// From below the collar up into the head; horizontal about an axis that leans forward.
std::array<Ring, kNeckRingCount> neckRings(const Shopper& shopper, const Rig& rig);

/// A section of a limb.
struct Station {
    float along;   ///< 0 at the limb's first joint, 1 at the second, 2 at the third.
    float radius;  ///< Share of the stature.
    float byBuild;
};

/// A limb of two bones through three joints.
struct Limb {
    Eigen::Vector3f begin, middle, end;
    std::size_t root, upper, lower, tip;  ///< Bones: what it grows from, its two, what it ends in.
    float joint;                          ///< Half length of the bend, as a share of a bone.
    float rise;                           ///< How steeply its root climbs towards the middle of the body.

    [[nodiscard]] Eigen::Vector3f at(float along) const;
    [[nodiscard]] Hold hold(float along) const;
};

inline constexpr std::size_t kLegRingCount = 18;
inline constexpr int kLegSegments = 24;
Limb legOf(const Rig& rig, fitting::Side side);
/// A leg's sections, all horizontal; `ease` is what cloth adds at the thigh, and more towards the ankle.
std::array<Ring, kLegRingCount> legRings(const Shopper& shopper, const Rig& rig, fitting::Side side, float ease);

}  // namespace cheval::hal::sim

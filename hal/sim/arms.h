// How arms are held and how they move from one attitude to the next.
#pragma once

#include <cstdint>
#include <span>

#include "hal/sim/rig.h"

namespace cheval::hal::sim {

/// Minimum-jerk ease from 0 to 1 while u goes from 0 to 1: how people move a hand from rest to rest (Flash & Hogan,
/// J. Neurosci. 5(7), 1985). Held at its ends outside.
float ease(float u);
/// The same while `time` goes from `from` to `to`.
float ease(double from, double to, double time);

enum class ArmPose : std::uint8_t { hanging, aPose, raised, outward, inward };
ArmAttitude attitude(ArmPose pose);

/// What holds an arm whose palm is somewhere: lengths are shares of the stature, axes those of ArmAttitude.
struct Reach {
    Eigen::Vector3f palm = Eigen::Vector3f::Zero();  ///< Centre of the palm as seen from the shoulder joint.
    Eigen::Vector3f elbow = {0.6F, -0.8F, -0.2F};    ///< The side to which the elbow gives way.
    Eigen::Vector3f fingers = {0.0F, 0.9F, 0.4F};    ///< As in ArmAttitude.
    Eigen::Vector3f facing = {0.0F, -0.2F, 1.0F};    ///< ArmAttitude::palm, made square to the fingers.
    float curl = 0.05F;
};
/// The attitude that puts the palm there, or as near as the arm is long.
ArmAttitude reaching(const Rig& rig, const Reach& reach);

/// The attitude `share` of the way from one to the other; directions go along great circles.
ArmAttitude blend(const ArmAttitude& from, const ArmAttitude& to, float share);

/// From `start` to `end` the arm moves to `pose`; before, it holds what came before.
struct ArmMove {
    double start = 0.0, end = 0.0;
    ArmAttitude pose;
};
/// Where the moves, ordered by their starts, have brought an arm that hung before the first.
ArmAttitude armAt(std::span<const ArmMove> moves, double time);

}  // namespace cheval::hal::sim

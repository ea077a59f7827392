// What one person does in a visit, written down: walks, turns, arms and glances.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "hal/sim/arms.h"
#include "hal/sim/bounded_list.h"
#include "hal/sim/gait.h"
#include "hal/sim/rig.h"

namespace cheval::hal::sim {

inline constexpr std::size_t kMaximumArmMoves = 112;

/// The head looks aside from `start` to `end` and back; radians against the chest.
struct Glance {
    double start = 0.0, end = 0.0;  ///< Seconds.
    float pitch = 0.0F;             ///< Positive: down.
    float yaw = 0.0F;               ///< Positive: to the person's left.
};

/// Each list is ordered by its starts, and no walk or turn begins before the one before it has ended. Seconds of the
/// visit. A person stands where the last walk brought them, at first at `begin`.
struct Part {
    double enters = 0.0, leaves = 1e9;  ///< In the room between the two.
    Place begin;
    float sway = 1.0F;   ///< 0: stands like a post.
    float stoop = 0.0F;  ///< As BodyShares::stoop.
    BoundedList<Walk, 12> walks;
    BoundedList<Turn, 24> turns;
    std::array<BoundedList<ArmMove, kMaximumArmMoves>, fitting::kSideCount> arms;
    BoundedList<Glance, 24> glances;
};

/// The posture at `time`. Who sits in a wheelchair rolls where others walk.
Posture postureAt(const Part& part, const Rig& rig, bool seated, double time);

/// Where a seated person's hip joints are above the floor, and their ankles ahead of them and above it: shares of the
/// stature. The wheelchair is built to them.
inline constexpr float kSeatedHip = 0.325F;
inline constexpr float kSeatedAnkleAhead = 0.245F;
inline constexpr float kSeatedAnkleHeight = 0.115F;

}  // namespace cheval::hal::sim

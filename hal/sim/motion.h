// The script of a visit: what the shopper does at each moment, as a pure function of time.
#pragma once

#include <array>

#include "hal/sim/rig.h"
#include "hal/sim/shopper.h"
#include "hal/sim/world.h"

namespace cheval::hal::sim {

/// The script is written for a visit of this length and stretched to any other. All times below are its seconds.
inline constexpr double kScriptSeconds = 20.0;
/// Where the shopper stops, metres from the glass: a tall adult's crown and toes are both in view from there.
inline constexpr float kStandDepth = 2.78F;
/// Button presses of each visit, while the shopper wears something.
inline constexpr std::array<double, 2> kNextPresses = {9.4, 14.45};
inline constexpr double kPressSeconds = 0.15;

/// Span during which the shopper stands in the A-pose.
inline constexpr double kAPoseFrom = 3.95;
inline constexpr double kAPoseTo = 5.95;

/// What the shopper means by it: the gestures of a visit and the ways between.
extern const std::array<MeantGesture, 13> kMeantInVisit;

/// The posture at `time`, 0 … kScriptSeconds after the visit began.
Posture postureAt(const Shopper& shopper, const Rig& rig, double time);

}  // namespace cheval::hal::sim

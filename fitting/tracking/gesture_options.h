// What counts as a gesture: the part of TrackerOptions that gestures.h works by.
#pragma once

namespace cheval::fitting {

/// Thresholds of gestures. Lengths and speeds are in shares of the stature, so that a child and an adult, near or far,
/// swipe alike; durations are in seconds.
struct GestureOptions {
    float swipeStartSpeed = 0.45F;   ///< Statures a second sideways that begin a stroke,
    float swipeEndSpeed = 0.25F;     ///< … and end it; at most swipeStartSpeed,
    float swipePeakSpeed = 0.65F;    ///< … and must be reached in between; at least swipeStartSpeed.
    float swipeDistance = 0.16F;     ///< Statures sideways at least.
    float swipeSteepest = 0.75F;     ///< Most up or down, as a share of sideways.
    float swipeLongest = 0.9F;       ///< Seconds.
    float grabOpenBefore = 0.12F;    ///< Seconds a raised hand is open first,
    float grabClosedLeast = 0.20F;   ///< … then closed at least,
    float grabClosedLongest = 3.0F;  ///< … and at most, before it opens again; more than grabClosedLeast.
    float grabLowest = -0.15F;       ///< Statures above the neck at least, when it opens.
    float raiseHold = 0.20F;         ///< Seconds above the shoulder.
    float raiseRest = 0.30F;         ///< Seconds below it before another raise counts.
    float holdTime = 1.2F;           ///< Seconds an open, raised hand is kept still to confirm,
    float holdMovement = 0.04F;      ///< … no farther than this from where it came to rest, statures.
    float holdAway = 0.10F;          ///< Statures it must go from where it gestured before it can hold again,
    float holdRest = 0.30F;          ///< … or seconds that it must be down.
    float walkingSpeed = 0.30F;      ///< Statures a second of the neck: who walks does not gesture.
};

}  // namespace cheval::fitting

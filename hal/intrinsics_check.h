// Whether intrinsics can be those of a depth sensor at all.
#pragma once

#include "hal/expected.h"
#include "hal/frame.h"

namespace cheval::hal {

/// No depth sensor that sees a whole person sees less or more than this, across or up, degrees.
inline constexpr float kNarrowestViewDeg = 30.0F;
inline constexpr float kWidestViewDeg = 120.0F;

/// Errors: invalidInput, with the field at fault ("width", "height", "fx", "fy", "cx", "cy") as its key: a picture
/// without pixels, a field of view beyond the above (the calibration of another resolution, or one in millimetres), a
/// principal point outside the picture, a number that is none.
Expected<void> checkIntrinsics(const Intrinsics& intrinsics);

}  // namespace cheval::hal

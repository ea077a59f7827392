// What a hand's depth says about its fingers: a flat hand is wide and thin, a fist is neither.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "fitting/tracking/binary_image.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Measures of a hand's surface in space, millimetres.
struct HandRelief {
    bool valid = false;
    float breadth = 0.0F;    ///< Standard deviation along the second of its principal axes,
    float thickness = 0.0F;  ///< … and along the third: how far it is from flat.
    float spread = 0.0F;     ///< Within this of the surface's mean lie 19 of 20 points,
    float reach = 0.0F;      ///< … and within this of the palm.
};

/// Measures the surface under a hand's outline. Invalid without a picture, a mask and a positive surface.
struct HandReliefJob {
    hal::ImageView<const std::uint16_t> depth;
    hal::Intrinsics intrinsics;
    const HandMask* mask = nullptr;                    ///< The hand's one component, as HandShapeJob leaves it.
    Eigen::Vector2f centre = Eigen::Vector2f::Zero();  ///< The pixel at the mask's middle.
    float pixelsPerCell = 1.0F;
    float surface = 0.0F;                            ///< As HandRegionJob gives it, millimetres.
    Eigen::Vector3f palm = Eigen::Vector3f::Zero();  ///< On the surface; sensor frame, millimetres.

    HandRelief relief;  ///< Out.

    [[nodiscard]] bool isValid() const {
        return !depth.empty() && mask != nullptr && surface > 0.0F && pixelsPerCell > 0.0F;
    }
    void run();
};

}  // namespace cheval::fitting::tracking

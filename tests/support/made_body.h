// A body and garments of tubes, for tests that must not depend on baked assets: symmetric, exact, quick to make.
#pragma once

#include "fitting/body/body.h"
#include "fitting/garment/garment.h"
#include "fitting/skeleton.h"

namespace cheval::test {

/// A person of tubes, 1.75 m, in A-pose: trunk, head, two arms, two legs, each tube with a UV seam down its back. The
/// mesh lies 5 mm within the outer cage; left and right are exact mirror images.
fitting::Body makeBody();

struct MadeGarment {
    float gap = 0.004F;       ///< From the body's outer cage to the cloth, metres.
    float thickness = 0.02F;  ///< From inner to outer cage.
    bool legs = false;        ///< Trousers instead of a top with half sleeves.
};
/// A garment for that body. Its inner cage is the body's outer cage.
fitting::Garment makeGarment(const fitting::Body& body, const MadeGarment& made = {});

/// The body's own pose, seen with full confidence: half a turn about Y (facing the glass), then moved.
fitting::Skeleton restSkeleton(const fitting::Body& body, const Eigen::Vector3f& moved = Eigen::Vector3f::Zero());
/// Every joint moved rigidly on top of restSkeleton's half turn.
fitting::Skeleton movedSkeleton(const fitting::Body& body, const Eigen::Isometry3f& motion);

}  // namespace cheval::test

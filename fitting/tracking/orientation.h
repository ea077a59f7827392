// From joint positions to joint orientations.
#pragma once

#include <Eigen/Core>

#include "fitting/skeleton.h"

namespace cheval::fitting::tracking {

/// Sets every joint's orientation (fitting/skeleton.h: from rest-pose axes, A-pose with arms 45° down, to tracked ones)
/// from the positions and the trunk's axes (columns: left, up, forward). Head, neck and torso take the trunk's axes. A
/// limb's joint takes its parent's orientation, swung by the smallest turn that brings the rest direction of its bone
/// onto the tracked one; a limb's last joint keeps the orientation of the one before. Twist about a bone cannot be seen
/// and is not invented.
void orientJoints(const Eigen::Matrix3f& axes, Skeleton& skeleton);

}  // namespace cheval::fitting::tracking

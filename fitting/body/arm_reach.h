// Which points of a shopper are their arms', and so say nothing about the trunk.
#pragma once

#include <Eigen/Core>

#include "fitting/skeleton.h"

namespace cheval::fitting {

/// Whether a point (mirror frame, metres) lies on an arm below the shoulder, as far as its joints are seen.
bool onArm(const Skeleton& skeleton, const Eigen::Vector3f& point);

}  // namespace cheval::fitting

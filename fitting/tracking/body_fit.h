// The whole body at once, fitted to the depth by least squares from a pose that is nearly right.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "fitting/tracking/articulated_body.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/silhouette.h"

namespace cheval::fitting::tracking {

/// Who goes sideways by this many metres a second or more walks, and looks where they go or at the glass.
inline constexpr float kWalking = 0.35F;

/// Refines a pose: Gauss-Newton with damping over trunk, head, limbs and the person's sizes. Each depth point pulls the
/// nearest part's surface (robustly: Geman and McClure), bones outside the outline or in the air before the surface are
/// pushed back, and what bodies usually do holds what nothing shows. After Ganapathi, Plagemann, Koller, Thrun
/// (ECCV 2012) and Tagliasacchi et al. (SGP 2015), with round cones as the surface. Invalid without cloud, silhouette
/// and points.
struct BodyFitJob {
    const Cloud* cloud = nullptr;
    const Silhouette* silhouette = nullptr;
    std::span<const Eigen::Vector3f> points;         ///< Of the person's surface, evenly thinned; mirror frame, metres.
    Eigen::Vector3f head = Eigen::Vector3f::Zero();  ///< Its centre, as seen; used where headSeen.
    bool headSeen = false;
    bool floorKnown = true;
    bool seated = false;    ///< On a chair: the legs lie before the trunk, and nothing is known of the feet's floor.
    float sideways = 0.0F;  ///< Speed of the whole person along the mirror frame's x, metres a second.
    ArticulatedPose start;
    const ArticulatedPose* previous = nullptr;  ///< Of the frame before, or null.
    BodyLengths usual{};                        ///< What is usual for the stature,
    BodyLengths spread{};                       ///< … and how far people are from it: one standard deviation each.
    const BodyLengths* learnt = nullptr;        ///< The person's own as found in the frames before, or null.
    int rounds = 6;
    float toBeat = 1e9F;  ///< The cost of a pose that is known already: far above it the search ends early.

    ArticulatedPose pose;  ///< Out.
    float cost = 0.0F;     ///< Out: without what ties it to the frame before.

    [[nodiscard]] bool isValid() const { return cloud != nullptr && silhouette != nullptr && !points.empty(); }
    void run();
};

}  // namespace cheval::fitting::tracking

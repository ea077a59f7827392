// Where the limbs are in one frame, without a pose that is nearly right: what starts and re-starts the fit of the body.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "fitting/tracking/articulated_body.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/limb_fit.h"
#include "fitting/tracking/silhouette.h"
#include "fitting/tracking/torso_fit.h"

namespace cheval::fitting::tracking {

/// Sorts a person's points into limbs and searches each limb's two directions. Thread-bound; takes no memory after
/// construction.
class BodyDetector {
  public:
    BodyDetector();
    void reset() { generator_ = {}; }

    /// The detected pose with the person's `size`. `before` is the pose of the frame before, one of the search's
    /// starts, or null.
    ArticulatedPose detect(const Cloud& cloud, const Silhouette& silhouette, const TorsoPose& torso,
                           const BodyLengths& size, const ArticulatedPose* before);

  private:
    static constexpr std::size_t kMostPoints = 180;
    /// A limb's depth points, and how far each is from what other parts of the body explain.
    struct LimbPoints {
        std::vector<Eigen::Vector3f> points;
        std::vector<float> explained;
    };
    struct View {
        const Cloud& cloud;
        const Silhouette& silhouette;
        const TorsoPose& torso;
    };
    using Limbs = std::array<LimbPose, kSideCount>;

    void collectPoints(const View& view);
    /// Twice each side, so that either knows what the other explains.
    static void fitLimbs(const View& view, const LimbModel& model, const std::array<Eigen::Vector3f, kSideCount>& roots,
                         const Limbs& before, int evaluations, Generator& generator, LimbPoints& points, Limbs& limbs);

    LimbPoints armPoints_, legPoints_;
    Generator generator_;  ///< Goes on from frame to frame: what one search misses the next may find.
};

}  // namespace cheval::fitting::tracking

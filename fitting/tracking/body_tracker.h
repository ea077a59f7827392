// The active user's joints over time.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fitting/skeleton.h"
#include "fitting/tracking/limb_fit.h"
#include "fitting/tracking/silhouette.h"
#include "fitting/tracking/smoothing.h"
#include "fitting/tracking/torso_fit.h"
#include "fitting/users.h"

namespace cheval::fitting::tracking {

/// Follows one person: trunk first, then legs, then arms, then filters. Thread-bound; takes no memory after
/// construction.
class BodyTracker {
  public:
    BodyTracker();
    void reset();

    /// Fills joints, time and user of `skeleton`. Somebody new is started afresh. Nothing found: skeleton.userId = 0.
    void update(const Cloud& cloud, std::span<const std::uint8_t> labels, const User& user, bool floorKnown,
                hal::TimePoint time, Skeleton& skeleton);

    [[nodiscard]] const TorsoPose& torso() const { return torso_; }
    [[nodiscard]] const Silhouette& silhouette() const { return silhouette_; }
    /// The stature that proportions are taken of, metres.
    [[nodiscard]] float stature() const { return stature_; }

  private:
    static constexpr std::size_t kMostPoints = 180;
    static constexpr float kUsualHalfDepth = 0.066F;
    /// A limb's depth points, and how far each is from what other parts of the body explain.
    struct LimbPoints {
        std::vector<Eigen::Vector3f> points;
        std::vector<float> explained;
    };

    void learnStature(bool floorKnown);
    void learnHalfDepth();
    void collectPoints(const Cloud& cloud);
    void fitLegs(const Cloud& cloud);
    void fitArms(const Cloud& cloud);
    void fitLimb(const Cloud& cloud, Side side, const LimbModel& model, const Eigen::Vector3f& root, LimbPose& pose,
                 LimbPoints& points, int evaluations);
    [[nodiscard]] float confidenceOf(const Cloud& cloud, const Eigen::Vector3f& position, float depthAllowed) const;
    void fillSkeleton(const Cloud& cloud, hal::TimePoint time, Skeleton& skeleton);

    Silhouette silhouette_;
    TorsoPose torso_;
    std::array<LimbPose, kSideCount> arms_{}, legs_{}, previousArms_{}, previousLegs_{};
    LimbPoints armPoints_, legPoints_;
    std::array<PointFilter, kJointCount> filters_{};
    std::uint32_t userId_ = 0;
    float stature_ = 0.0F;
    int statureFrames_ = 0;
    float halfDepth_ = kUsualHalfDepth;  ///< Of the trunk, in shares of the stature.
    hal::TimePoint lastTime_{};
};

}  // namespace cheval::fitting::tracking

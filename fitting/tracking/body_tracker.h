// The active user's joints over time.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fitting/skeleton.h"
#include "fitting/tracking/articulated_body.h"
#include "fitting/tracking/body_detector.h"
#include "fitting/tracking/body_fit.h"
#include "fitting/tracking/hem.h"
#include "fitting/tracking/silhouette.h"
#include "fitting/tracking/smoothing.h"
#include "fitting/tracking/torso_fit.h"
#include "fitting/users.h"

namespace cheval::fitting::tracking {

/// Follows one person: the body of the frame before and the body detected in this frame are both fitted to it, and the
/// better fit counts. Thread-bound; takes no memory after construction.
class BodyTracker {
  public:
    BodyTracker();
    void reset();

    /// Fills joints, time and user of `skeleton`. Somebody new is started afresh. Nothing found: skeleton.userId = 0.
    void update(const Cloud& cloud, std::span<const std::uint8_t> labels, const User& user, bool floorKnown,
                hal::TimePoint time, Skeleton& skeleton);

    /// The stature that proportions are taken of, metres.
    [[nodiscard]] float stature() const { return stature_; }

  private:
    static constexpr std::size_t kMostPoints = 420;

    /// Whether the person sits: the knees then lie well before the trunk, as seen from above.
    void findSeat(const Cloud& cloud, bool floorKnown, float elapsed);
    /// Of somebody whose crown is so high above the floor, metres.
    [[nodiscard]] float statureOf(float crown) const;
    void learnStature(bool floorKnown);
    void learnHalfDepth();
    void learnSize();
    void collectPoints(const Cloud& cloud);
    /// False where nothing fits.
    bool fitBody(const Cloud& cloud, const User& user, bool floorKnown, float elapsed);
    struct Fit {
        ArticulatedPose pose;
        float cost = 0.0F;
    };
    /// What is known of the pose that is followed.
    struct Standing {
        bool isNew = false;  ///< The person has only just been found.
        bool sound = false;  ///< It costs no more than it usually does.
    };
    /// All of these fit from other starts and keep what costs less than `cost`.
    void lookAfresh(const Cloud& cloud, const User& user, Standing standing, BodyFitJob& job, Fit& best, float& cost);
    static void tryArm(Side side, BodyFitJob& job, Fit& best, float& cost);
    static void tryFrom(const ArticulatedPose& start, BodyFitJob& job, Fit& best, float& cost);
    [[nodiscard]] bool atRest() const;
    [[nodiscard]] float confidenceOf(const Cloud& cloud, const Eigen::Vector3f& position, float depthAllowed) const;
    void fillSkeleton(const Cloud& cloud, hal::TimePoint time, float elapsed, Skeleton& skeleton);

    Silhouette silhouette_;
    TorsoPose torso_;
    BodyDetector detector_;
    std::vector<Eigen::Vector3f> points_;
    ArticulatedPose body_;
    bool known_ = false;   ///< body_ is of the frame before.
    int foundFrames_ = 0;  ///< In a row.
    BodyLengths size_{};   ///< The person's own, as learnt so far.
    int sizeFrames_ = 0;
    float usualCost_ = 0.0F;  ///< Of the frames before.
    int soundFrames_ = 0;     ///< In a row that cost no more.
    HemFinder hem_;
    std::array<PointFilter, kJointCount> filters_{};
    std::uint32_t userId_ = 0;
    bool seated_ = false;
    float seatedShare_ = 0.0F;  ///< Of the frames of late that looked like it; negative: none yet.
    float stature_ = 0.0F;
    int statureFrames_ = 0, lowerFrames_ = 0;
    float halfDepth_ = 0.0F;  ///< Of the trunk, in shares of the stature.
    hal::TimePoint lastTime_{};
};

}  // namespace cheval::fitting::tracking

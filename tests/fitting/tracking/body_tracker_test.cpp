#include "fitting/tracking/body_tracker.h"

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/fitting/tracking/drawn_body.h"

namespace cheval::fitting::tracking {
namespace {

TEST(BodyTracker, WhoeverBendsDownDoesNotSit) {
    BodyTracker tracker;
    int frame = 0;
    const auto show = [&](const ArticulatedPose& pose, int frames) {
        const test::DrawnBody body(pose);
        std::vector<std::uint8_t> labels(kCloudCells);
        for (std::size_t i = 0; i < kCloudCells; ++i) {
            labels[i] = body.cloud.depth[i] > 0.0F ? 1 : 0;
        }
        Skeleton skeleton;
        for (int i = 0; i < frames; ++i, ++frame) {
            tracker.update(body.cloud, labels, User{.id = 1, .centroid = pose.middle, .label = 1}, true,
                           hal::TimePoint(hal::fromSeconds(frame / 30.0)), skeleton);
        }
    };
    ArticulatedPose bent = test::aPose();
    const Eigen::Vector3f hips = bent.hipMiddle();
    const Eigen::Matrix3f lean = Eigen::AngleAxisf(1.0F, bent.left()).toRotationMatrix();
    bent.axes = lean * bent.axes;
    bent.headDirection = lean * bent.headDirection;
    bent.middle = hips + 0.5F * bent.length(BodyLength::trunk) * bent.up();
    bent.arms = {};
    ASSERT_LT(bent.middle.z(), hips.z()) << "bends towards the glass";

    show(test::aPose(), 25);
    const float stature = tracker.stature();
    ASSERT_NEAR(stature, test::kStature, 0.06F);
    show(bent, 20);
    EXPECT_NEAR(tracker.stature(), stature, 0.03F);
}

}  // namespace
}  // namespace cheval::fitting::tracking

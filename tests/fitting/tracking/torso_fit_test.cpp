#include "fitting/tracking/torso_fit.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/fitting/tracking/drawn_body.h"

namespace cheval::fitting::tracking {
namespace {

TorsoPose fitted(const ArticulatedPose& pose) {
    const test::DrawnBody body(pose);
    TorsoFitJob job{.cloud = &body.cloud, .silhouette = &body.silhouette};
    job.run();
    return job.pose;
}

TEST(TorsoFit, FindsHeadAndTrunkOfATurnedBody) {
    for (const float turn : {-0.5F, 0.0F, 0.5F}) {
        ArticulatedPose pose = test::aPose();
        pose.axes = Eigen::AngleAxisf(turn, Eigen::Vector3f::UnitY()) * pose.axes;
        pose.headDirection = Eigen::AngleAxisf(turn, Eigen::Vector3f::UnitY()) * pose.headDirection;
        const TorsoPose torso = fitted(pose);
        ASSERT_TRUE(torso.found);
        EXPECT_LT((torso.head - pose.head()).norm(), 0.05F) << turn;
        EXPECT_LT((torso.neck - pose.neck()).norm(), 0.08F) << turn;
        EXPECT_NEAR(torso.stature, test::kStature, 0.06F) << turn;
    }
}

TEST(TorsoFit, ATurnedTrunkKeepsItsLengthsAndTurnsToItsRight) {
    const TorsoPose torso = fitted(test::aPose());
    ASSERT_TRUE(torso.found);
    for (const float angle : {-1.3F, 0.6F, 1.3F}) {
        const TorsoPose turned = torso.turned(angle);
        const auto breadth = [](const TorsoPose& of) { return (of.shoulders[0] - of.shoulders[1]).norm(); };
        EXPECT_NEAR(breadth(turned), breadth(torso), 1e-5F);
        EXPECT_NEAR(turned.left.dot(turned.up), 0.0F, 1e-5F);
        EXPECT_LT((turned.left.cross(turned.up) - turned.forward).norm(), 1e-5F);
        EXPECT_NEAR(turned.forward.dot(torso.forward), std::cos(angle), 1e-4F);
        EXPECT_LT((turned.up - torso.up).norm(), 1e-5F) << "who leans goes on leaning along the same line";
        const Eigen::Vector3f right = -torso.left;
        EXPECT_GT(turned.forward.dot(right) * angle, 0.0F) << "to the person's right where positive";
        EXPECT_GE(turned.shoulders[0].z() + turned.shoulders[1].z(), torso.shoulders[0].z() + torso.shoulders[1].z());
    }
}

}  // namespace
}  // namespace cheval::fitting::tracking

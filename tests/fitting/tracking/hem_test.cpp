#include "fitting/tracking/hem.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/fitting/tracking/drawn_body.h"

namespace cheval::fitting::tracking {
namespace {

using test::aPose;
using test::DrawnBody;

/// Hangs a cloth before both legs, from the hips down to `hem` metres above the floor.
void hangCloth(DrawnBody& drawn, float hem) {
    Cloud& cloud = drawn.cloud;
    std::vector<std::uint8_t> labels(kCloudCells);
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const Eigen::Vector3f along =
            cloud.placement.rotation * unproject(cloud.intrinsics, 2.0F * static_cast<float>(cellColumn(i)) + 0.5F,
                                                 2.0F * static_cast<float>(cellRow(i)) + 0.5F, 1.0F);
        constexpr float kDepth = 2.27F;
        const Eigen::Vector3f point = cloud.placement.translation + kDepth * along;
        if (point.y() < 0.90F && point.y() > hem && std::abs(point.x()) < 0.24F) {
            cloud.depth[i] = kDepth;
            cloud.x[i] = point.x();
            cloud.y[i] = point.y();
            cloud.z[i] = point.z();
        }
        labels[i] = cloud.depth[i] > 0.0F ? 1 : 0;
    }
    SilhouetteJob outline{.cloud = &cloud, .labels = labels, .label = 1, .silhouette = &drawn.silhouette};
    outline.run();
}

void look(HemFinder& finder, const DrawnBody& drawn, const ArticulatedPose& pose, int frames = 15) {
    for (int i = 0; i < frames; ++i) {
        finder.look(drawn.cloud, drawn.silhouette, pose);
    }
}

TEST(HemFinder, TwoLegsBesideEachOtherAreNotCovered) {
    HemFinder finder;
    look(finder, DrawnBody(aPose()), aPose());
    EXPECT_FALSE(finder.covered());
}

TEST(HemFinder, FindsWhereASkirtEnds) {
    for (const float hem : {0.15F, 0.35F, 0.5F}) {
        DrawnBody drawn(aPose());
        hangCloth(drawn, hem);
        HemFinder finder;
        look(finder, drawn, aPose());
        ASSERT_TRUE(finder.covered()) << hem;
        const float hip = aPose().hipMiddle().y();
        const float ankle = aPose().foot(Side::left).y();
        EXPECT_NEAR(hip - finder.hem() * (hip - ankle), hem, 0.10F);
    }
}

TEST(HemFinder, OneFrameDoesNotDecide) {
    DrawnBody drawn(aPose());
    hangCloth(drawn, 0.2F);
    HemFinder finder;
    look(finder, drawn, aPose(), 1);
    EXPECT_FALSE(finder.covered());
}

TEST(HemFinder, AShirtIsNoSkirt) {
    DrawnBody drawn(aPose());
    hangCloth(drawn, 0.74F);
    HemFinder finder;
    look(finder, drawn, aPose());
    EXPECT_FALSE(finder.covered());
}

}  // namespace
}  // namespace cheval::fitting::tracking

#include "hal/sim/figure.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace cheval::hal::sim {
namespace {

class EveryShopper : public testing::TestWithParam<std::uint32_t> {
  protected:
    EveryShopper() : shopper_(makeShopper(9, GetParam())), rig_(makeRig(shopper_)) {
        buildFigure(shopper_, rig_, mesh_);
    }
    Shopper shopper_;
    Rig rig_;
    Mesh mesh_;
};

TEST_P(EveryShopper, FitsWhatIsReserved) {
    EXPECT_LE(mesh_.positions.size(), kMaximumFigureVertices);
    EXPECT_LE(mesh_.triangles.size(), kMaximumFigureTriangles);
    EXPECT_EQ(mesh_.positions.size(), mesh_.normals.size());
    EXPECT_EQ(mesh_.positions.size(), mesh_.holds.size());
    EXPECT_EQ(mesh_.triangles.size(), mesh_.materials.size());
}

TEST_P(EveryShopper, StandsOnTheFloorAndReachesTheStature) {
    float lowest = 9.0F;
    float highest = 0.0F;
    for (const Eigen::Vector3f& p : mesh_.positions) {
        ASSERT_TRUE(p.allFinite());
        lowest = std::min(lowest, p.y());
        highest = std::max(highest, p.y());
    }
    EXPECT_NEAR(lowest, 0.0F, 0.004F);
    // Hair stands off the crown by some centimetres.
    EXPECT_GT(highest, shopper_.stature - 0.005F);
    EXPECT_LT(highest, shopper_.stature + 0.04F);
}

TEST_P(EveryShopper, IsWoundOutwardsAndHasUnitNormals) {
    double volume = 0.0;
    for (const auto& [a, b, c] : mesh_.triangles) {
        volume += static_cast<double>(mesh_.positions[a].dot(mesh_.positions[b].cross(mesh_.positions[c]))) / 6.0;
    }
    // Parts overlap and clothes are counted with what is below them, so this is more than the body's own.
    const double cube = static_cast<double>(shopper_.stature) * shopper_.stature * shopper_.stature;
    EXPECT_GT(volume, 0.008 * cube);
    EXPECT_LT(volume, 0.045 * cube);
    for (const Eigen::Vector3f& normal : mesh_.normals)
        EXPECT_NEAR(normal.norm(), 1.0F, 1e-3F);
}

TEST_P(EveryShopper, HasLeftAndRightAlike) {
    double left = 0.0;
    double right = 0.0;
    for (const Eigen::Vector3f& p : mesh_.positions)
        (p.x() > 0.0F ? left : right) += std::abs(p.x());
    EXPECT_NEAR(left / right, 1.0, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Shoppers, EveryShopper, testing::Range(0U, 12U));

TEST(Figure, ClosesTheHandToAFistHalfAsLong) {
    const Shopper shopper = makeShopper(1, 0);
    const Rig rig = makeRig(shopper);
    const auto reach = [&](float curl) {
        Posture posture;
        for (ArmAttitude& arm : posture.arms) {
            arm = {.upper = {0.5F, -0.8F, 0.3F},
                   .forearm = {0.2F, 0.9F, 0.4F},
                   .fingers = {0.0F, 1.0F, 0.1F},
                   .palm = {0.0F, -0.1F, 1.0F},
                   .curl = curl};
        }
        const Pose pose = solvePose(rig, posture);
        const std::size_t wrist = bone(fitting::Side::right, SideBone::hand);
        float longest = 0.0F;
        for (std::size_t finger = 1; finger < kFingerCount; ++finger) {
            const std::size_t tip = phalanx(fitting::Side::right, finger, kPhalanxCount - 1);
            longest = std::max(longest, (pose.position[tip] - pose.position[wrist]).norm());
        }
        return longest;
    };
    EXPECT_GT(reach(0.0F), 0.80F * rig.handLength);
    EXPECT_LT(reach(1.0F), 0.62F * rig.handLength);
}

}  // namespace
}  // namespace cheval::hal::sim

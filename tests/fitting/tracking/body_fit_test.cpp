#include "fitting/tracking/body_fit.h"

#include <array>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/fitting/tracking/drawn_body.h"
#include "tests/support/allocation_counter.h"

namespace cheval::fitting::tracking {
namespace {

using test::aPose;
using test::DrawnBody;
using test::kStature;

BodyFitJob jobFor(const DrawnBody& drawn, const ArticulatedPose& start) {
    return {.cloud = &drawn.cloud,
            .silhouette = &drawn.silhouette,
            .points = drawn.points,
            .start = start,
            .usual = usualLengths(kStature),
            .spread = lengthSpread(kStature, true),
            .rounds = 12};
}

std::array<Eigen::Vector3f, kJointCount> jointsOf(const ArticulatedPose& pose) {
    return {pose.head(),
            pose.neck(),
            pose.middle,
            pose.shoulder(Side::left),
            pose.shoulder(Side::right),
            pose.elbow(Side::left),
            pose.elbow(Side::right),
            pose.hand(Side::left),
            pose.hand(Side::right),
            pose.hip(Side::left),
            pose.hip(Side::right),
            pose.knee(Side::left),
            pose.knee(Side::right),
            pose.foot(Side::left),
            pose.foot(Side::right)};
}

float worstError(const ArticulatedPose& found, const ArticulatedPose& truth) {
    float worst = 0.0F;
    const auto a = jointsOf(found);
    const auto b = jointsOf(truth);
    for (std::size_t i = 0; i < a.size(); ++i) {
        worst = std::max(worst, (a[i] - b[i]).norm());
    }
    return worst;
}

/// Everything a little wrong: place, turn and all limbs.
ArticulatedPose disturbed(ArticulatedPose pose, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> offset(-1.0F, 1.0F);
    const auto vector = [&] { return Eigen::Vector3f(offset(random), offset(random), offset(random)); };
    pose.middle += 0.06F * vector();
    pose.axes = Eigen::AngleAxisf(0.25F * offset(random), Eigen::Vector3f::UnitY()) * pose.axes;
    for (auto* limbs : {&pose.arms, &pose.legs}) {
        for (LimbDirections& limb : *limbs) {
            limb.upper = (limb.upper + 0.25F * vector()).normalized();
            limb.lower = (limb.lower + 0.25F * vector()).normalized();
        }
    }
    return pose;
}

ArticulatedPose mirrored(ArticulatedPose pose) {
    const auto flip = [](Eigen::Vector3f v) { return Eigen::Vector3f(-v.x(), v.y(), v.z()); };
    pose.middle = flip(pose.middle);
    pose.headDirection = flip(pose.headDirection);
    pose.axes.col(0) = -flip(pose.axes.col(0));
    pose.axes.col(1) = flip(pose.axes.col(1));
    pose.axes.col(2) = flip(pose.axes.col(2));
    std::swap(pose.arms[0], pose.arms[1]);
    std::swap(pose.legs[0], pose.legs[1]);
    for (auto* limbs : {&pose.arms, &pose.legs}) {
        for (LimbDirections& limb : *limbs) {
            limb = {flip(limb.upper), flip(limb.lower)};
        }
    }
    return pose;
}

TEST(ArticulatedPose, TurnedRoundIsTheSameOutlineWithItsSidesExchanged) {
    const ArticulatedPose pose = aPose();
    const ArticulatedPose turned = pose.turnedRound();
    EXPECT_LT((turned.forward() + pose.forward()).norm(), 1e-6F);
    EXPECT_NEAR(turned.axes.determinant(), 1.0F, 1e-5F);
    for (const Side side : {Side::left, Side::right}) {
        const Side other = side == Side::left ? Side::right : Side::left;
        EXPECT_LT((turned.shoulder(side) - pose.shoulder(other)).norm(), 1e-5F);
        EXPECT_LT((turned.hand(side) - pose.hand(other)).norm(), 1e-5F);
        EXPECT_LT((turned.knee(side) - pose.knee(other)).norm(), 1e-5F);
        EXPECT_LT((turned.foot(side) - pose.foot(other)).norm(), 1e-5F);
    }
    const ArticulatedPose again = turned.turnedRound();
    EXPECT_TRUE(again.axes.isApprox(pose.axes));
    EXPECT_LT((again.hand(Side::left) - pose.hand(Side::left)).norm(), 1e-5F);
}

TEST(ArticulatedPose, CrossedLegsThatAreExchangedStandOnTheirOwnSides) {
    const ArticulatedPose straight = aPose();
    EXPECT_FALSE(straight.legsCrossed());
    const ArticulatedPose crossed = straight.withLegsExchanged();
    EXPECT_TRUE(crossed.legsCrossed());
    // Each foot comes near the place of the other; bones keep their lengths.
    for (const Side side : {Side::left, Side::right}) {
        const Side other = side == Side::left ? Side::right : Side::left;
        EXPECT_LT((crossed.foot(side) - straight.foot(other)).norm(), 0.08F);
    }
    EXPECT_FALSE(crossed.withLegsExchanged().legsCrossed());
}

TEST(BodyFit, IsInvalidWithoutCloudOutlineOrPoints) {
    const DrawnBody drawn(aPose());
    BodyFitJob job = jobFor(drawn, aPose());
    EXPECT_TRUE(job.isValid());
    job.points = {};
    EXPECT_FALSE(job.isValid());
    job = jobFor(drawn, aPose());
    job.cloud = nullptr;
    EXPECT_FALSE(job.isValid());
    job = jobFor(drawn, aPose());
    job.silhouette = nullptr;
    EXPECT_FALSE(job.isValid());
}

TEST(BodyFit, ABodyThatIsRightStaysWhereItIs) {
    const DrawnBody drawn(aPose());
    BodyFitJob job = jobFor(drawn, aPose());
    job.run();
    EXPECT_LT(worstError(job.pose, aPose()), 0.03F);
}

TEST(BodyFit, FindsTheBodyFromNearbyPoses) {
    const DrawnBody drawn(aPose());
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        BodyFitJob job = jobFor(drawn, disturbed(aPose(), seed));
        const float before = worstError(job.start, aPose());
        job.run();
        EXPECT_LT(worstError(job.pose, aPose()), 0.05F) << "seed " << seed << ", began " << before << " m away";
        EXPECT_LT(worstError(job.pose, aPose()), before) << "seed " << seed;
    }
}

TEST(BodyFit, FollowsATurnToEitherSide) {
    for (const float angle : {-0.8F, -0.4F, 0.4F, 0.8F}) {
        ArticulatedPose truth = aPose();
        const Eigen::AngleAxisf turn(angle, Eigen::Vector3f::UnitY());
        truth.axes = turn * truth.axes;
        truth.headDirection = turn * truth.headDirection;
        for (auto* limbs : {&truth.arms, &truth.legs}) {
            for (LimbDirections& limb : *limbs) {
                limb = {turn * limb.upper, turn * limb.lower};
            }
        }
        const DrawnBody drawn(truth);
        ArticulatedPose start = truth;
        start.axes = Eigen::AngleAxisf(-0.35F * (angle > 0.0F ? 1.0F : -1.0F), Eigen::Vector3f::UnitY()) * start.axes;
        BodyFitJob job = jobFor(drawn, start);
        job.run();
        EXPECT_GT(job.pose.forward().dot(truth.forward()), 0.97F) << angle;
        EXPECT_LT(worstError(job.pose, truth), 0.07F) << angle;
    }
}

TEST(BodyFit, AMirroredBodyIsFoundMirrored) {
    ArticulatedPose pose = aPose();
    pose.arms[0].lower = Eigen::Vector3f(-0.3F, 0.9F, -0.3F).normalized();
    pose.axes = Eigen::AngleAxisf(0.3F, Eigen::Vector3f::UnitY()) * pose.axes;
    const DrawnBody drawn(pose, 1);
    const DrawnBody flipped(mirrored(pose), 1);
    BodyFitJob job = jobFor(drawn, disturbed(pose, 3));
    BodyFitJob other = jobFor(flipped, mirrored(job.start));
    job.run();
    other.run();
    EXPECT_LT(worstError(other.pose, mirrored(job.pose)), 0.01F);
    EXPECT_NEAR(other.cost, job.cost, 0.05F * job.cost + 2.0F);
}

TEST(BodyFit, LearnsThatArmsAreLongerThanUsual) {
    ArticulatedPose truth = aPose();
    truth.size[index(BodyLength::forearm)] += 0.02F;
    // Bent elbows tell the two bones apart.
    truth.arms[0].lower = Eigen::Vector3f(-0.1F, 0.98F, -0.15F).normalized();
    truth.arms[1].lower = Eigen::Vector3f(0.1F, 0.98F, -0.15F).normalized();
    const DrawnBody drawn(truth, 3);
    ArticulatedPose start = truth;
    start.size = usualLengths(kStature);
    BodyFitJob job = jobFor(drawn, start);
    job.run();
    EXPECT_GT(job.pose.length(BodyLength::forearm), usualLengths(kStature)[index(BodyLength::forearm)] + 0.006F);
}

TEST(BodyFit, ATenthOfWildPointsChangesLittle) {
    DrawnBody drawn(aPose());
    std::mt19937 random(5);
    std::uniform_real_distribution<float> offset(-0.6F, 0.6F);
    for (std::size_t i = 0; i < drawn.points.size(); i += 10) {
        drawn.points[i] += Eigen::Vector3f(offset(random), offset(random), offset(random));
    }
    BodyFitJob job = jobFor(drawn, disturbed(aPose(), 2));
    job.run();
    EXPECT_LT(worstError(job.pose, aPose()), 0.06F);
}

TEST(BodyFit, SizesStayWithinWhatPeopleAre) {
    ArticulatedPose giant = aPose();
    for (float& metres : giant.size) {
        metres *= 1.5F;
    }
    const DrawnBody drawn(giant);
    BodyFitJob job = jobFor(drawn, aPose());
    job.run();
    for (std::size_t i = 0; i < kBodyLengthCount; ++i) {
        EXPECT_LE(std::abs(job.pose.size[i] - job.usual[i]), 2.5F * job.spread[i] + 1e-5F);
    }
}

TEST(BodyFit, TheTrunksAxesStayOrthonormal) {
    const DrawnBody drawn(aPose());
    BodyFitJob job = jobFor(drawn, disturbed(aPose(), 9));
    job.run();
    EXPECT_TRUE((job.pose.axes.transpose() * job.pose.axes).isIdentity(1e-4F));
    EXPECT_NEAR(job.pose.axes.determinant(), 1.0F, 1e-4F);
}

TEST(BodyFit, TakesNoMemory) {
    const DrawnBody drawn(aPose());
    BodyFitJob job = jobFor(drawn, disturbed(aPose(), 1));
    const cheval::test::AllocationCounter counter;
    job.run();
    EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace cheval::fitting::tracking

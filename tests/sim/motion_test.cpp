#include "hal/sim/motion.h"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hal/sim/world.h"
#include "tests/sim/sim_fixtures.h"

namespace cheval::hal::sim {
namespace {

using Eigen::Vector3f;
using fitting::Joint;
using fitting::Skeleton;
using test::kKindsOfPeople;
using test::worldTime;

Skeleton skeletonAt(const World& world, std::uint32_t visit, double scriptTime) {
    return truthAt(world, worldTime(world.options(), visit, scriptTime)).skeleton;
}

/// People: a hand that swipes is fast, a foot in mid-swing too, a trunk is not.
float fastest(Joint joint) {
    switch (joint) {
        case Joint::leftHand:
        case Joint::rightHand:
            return 5.0F;
        case Joint::leftFoot:
        case Joint::rightFoot:
            return 4.5F;
        case Joint::leftElbow:
        case Joint::rightElbow:
        case Joint::leftKnee:
        case Joint::rightKnee:
            return 3.5F;
        default:
            return 2.5F;
    }
}

TEST(Motion, NeverTeleportsAJoint) {
    const World world(WorldOptions{.seed = 2});
    constexpr double kStep = 1.0 / 120.0;
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        Skeleton before = skeletonAt(world, visit, 0.0);
        for (double t = kStep; t < kScriptSeconds; t += kStep) {
            const Skeleton now = skeletonAt(world, visit, t);
            for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
                const float speed =
                    (now.joints[i].position - before.joints[i].position).norm() / static_cast<float>(kStep);
                ASSERT_LT(speed, fastest(static_cast<Joint>(i)))
                    << fitting::kJointNames[i] << " of visit " << visit << " at " << t;
                const float turn = now.joints[i].orientation.angularDistance(before.joints[i].orientation);
                ASSERT_LT(turn / static_cast<float>(kStep), 22.0F)
                    << fitting::kJointNames[i] << " of visit " << visit << " turns at " << t;
            }
            before = now;
        }
    }
}

TEST(Motion, KeepsTheLengthsOfBones) {
    const World world(WorldOptions{});
    constexpr std::array<std::pair<Joint, Joint>, 8> kBones = {{{Joint::leftShoulder, Joint::leftElbow},
                                                                {Joint::rightShoulder, Joint::rightElbow},
                                                                {Joint::leftElbow, Joint::leftHand},
                                                                {Joint::leftHip, Joint::leftKnee},
                                                                {Joint::rightHip, Joint::rightKnee},
                                                                {Joint::leftKnee, Joint::leftFoot},
                                                                {Joint::rightKnee, Joint::rightFoot},
                                                                {Joint::leftHip, Joint::rightHip}}};
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        const Skeleton still = skeletonAt(world, visit, 5.0);
        for (double t = 0.5; t < kScriptSeconds; t += 0.25) {
            const Skeleton now = skeletonAt(world, visit, t);
            for (const auto& [from, to] : kBones) {
                const float length = (now[from].position - now[to].position).norm();
                const float expected = (still[from].position - still[to].position).norm();
                // The wrist bends between elbow and palm.
                const float tolerance = from == Joint::leftElbow ? 0.05F : 0.002F;
                ASSERT_NEAR(length, expected, tolerance) << fitting::kJointNames[index(from)] << " at " << t;
            }
        }
    }
}

TEST(Motion, OrientationsTurnTheRestPoseIntoThePose) {
    const World world(WorldOptions{});
    const Vector3f leftArm = Vector3f(1.0F, -1.0F, 0.0F).normalized();
    const Vector3f rightArm = Vector3f(-1.0F, -1.0F, 0.0F).normalized();
    struct Link {
        Joint from, to;
        Vector3f rest;
    };
    const std::array<Link, 6> links = {{{Joint::leftShoulder, Joint::leftElbow, leftArm},
                                        {Joint::rightShoulder, Joint::rightElbow, rightArm},
                                        {Joint::leftHip, Joint::leftKnee, -Vector3f::UnitY()},
                                        {Joint::rightHip, Joint::rightKnee, -Vector3f::UnitY()},
                                        {Joint::leftKnee, Joint::leftFoot, -Vector3f::UnitY()},
                                        {Joint::rightKnee, Joint::rightFoot, -Vector3f::UnitY()}}};
    for (double t = 0.5; t < kScriptSeconds; t += 0.37) {
        const Skeleton skeleton = skeletonAt(world, 1, t);
        for (const Link& link : links) {
            const Vector3f along = (skeleton[link.to].position - skeleton[link.from].position).normalized();
            const Vector3f turned = skeleton[link.from].orientation * link.rest;
            // Shin and thigh hang a few degrees off the vertical in rest.
            EXPECT_GT(turned.dot(along), 0.995F) << fitting::kJointNames[index(link.from)] << " at " << t;
        }
    }
}

TEST(Motion, FacesTheGlassInTheAPose) {
    const World world(WorldOptions{});
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        const Skeleton skeleton = skeletonAt(world, visit, 0.5 * (kAPoseFrom + kAPoseTo));
        // Facing +Z in rest, towards −Z here; the left hand at −X.
        EXPECT_LT((skeleton[Joint::torso].orientation * Vector3f::UnitZ()).z(), -0.99F);
        EXPECT_LT((skeleton[Joint::head].orientation * Vector3f::UnitZ()).z(), -0.95F);
        EXPECT_LT(skeleton[Joint::leftHand].position.x(), -0.3F);
        EXPECT_GT(skeleton[Joint::rightHand].position.x(), 0.3F);
        for (const Joint shoulder : {Joint::leftShoulder, Joint::rightShoulder}) {
            const Joint hand = shoulder == Joint::leftShoulder ? Joint::leftHand : Joint::rightHand;
            const Vector3f arm = skeleton[hand].position - skeleton[shoulder].position;
            EXPECT_NEAR(std::atan2(-arm.y(), std::abs(arm.x())), std::numbers::pi_v<float> / 4.0F, 0.08F);
        }
    }
}

TEST(Motion, TurnsFortyDegreesEitherWay) {
    const World world(WorldOptions{});
    const auto facing = [&](double t) {
        const Vector3f ahead = skeletonAt(world, 0, t)[Joint::torso].orientation * Vector3f::UnitZ();
        return std::atan2(-ahead.x(), -ahead.z()) * 180.0F / std::numbers::pi_v<float>;
    };
    EXPECT_NEAR(facing(7.65), 40.0F, 4.0F);
    EXPECT_NEAR(facing(9.05), -40.0F, 4.0F);
    EXPECT_NEAR(facing(10.0), 0.0F, 4.0F);
}

TEST(Motion, StandsWithStillFeetAndNeverBelowTheFloor) {
    const World world(WorldOptions{});
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        const Skeleton first = skeletonAt(world, visit, 3.4);
        for (double t = 3.4; t < 6.6; t += 0.1) {
            const Skeleton now = skeletonAt(world, visit, t);
            for (const Joint foot : {Joint::leftFoot, Joint::rightFoot}) {
                EXPECT_LT((now[foot].position - first[foot].position).norm(), 0.004F) << "at " << t;
            }
        }
        for (double t = 0.0; t < kScriptSeconds; t += 0.05) {
            const Skeleton now = skeletonAt(world, visit, t);
            for (const Joint foot : {Joint::leftFoot, Joint::rightFoot}) {
                EXPECT_GT(now[foot].position.y(),
                          0.035F * truthAt(world, worldTime(world.options(), visit, t)).statureMetres);
            }
        }
    }
}

/// Swipes as the script has them: the hand, its stroke, and the way it goes as the shopper sees it.
TEST(Motion, SwipesBothWaysWithEitherHand) {
    const World world(WorldOptions{});
    struct Stroke {
        Joint hand;
        double from, to;
        float sign;  ///< Of x in the mirror frame: positive is the shopper's right.
    };
    constexpr std::array<Stroke, 4> kStrokes = {{{Joint::rightHand, 13.0, 13.45, -1.0F},
                                                 {Joint::rightHand, 13.7, 14.15, 1.0F},
                                                 {Joint::leftHand, 15.5, 15.95, 1.0F},
                                                 {Joint::leftHand, 16.2, 16.65, -1.0F}}};
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        const float stature = truthAt(world, worldTime(world.options(), visit, 5.0)).statureMetres;
        for (const Stroke& stroke : kStrokes) {
            const Vector3f way = skeletonAt(world, visit, stroke.to)[stroke.hand].position -
                                 skeletonAt(world, visit, stroke.from)[stroke.hand].position;
            EXPECT_GT(stroke.sign * way.x(), 0.25F * stature);
            EXPECT_LT(std::abs(way.y()), 0.5F * std::abs(way.x()));
        }
    }
}

}  // namespace
}  // namespace cheval::hal::sim

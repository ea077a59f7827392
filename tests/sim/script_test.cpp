// What each script of the simulated kiosk promises.
#include "hal/sim/script.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hal/sim/view.h"
#include "hal/sim/world.h"
#include "tests/support/allocation_counter.h"

namespace cheval::hal::sim {
namespace {

using Eigen::Vector3f;
using fitting::HandState;
using fitting::Joint;
using fitting::Side;
using fitting::Skeleton;
using fitting::SwipeDirection;

constexpr std::uint32_t kSeeds = 7;

WorldOptions optionsFor(Script script, std::uint32_t seed, double seconds = 16.0) {
    return {.seed = seed, .colour = false, .script = script, .visitSeconds = seconds};
}

Joint handOf(Side side) {
    return side == Side::left ? Joint::leftHand : Joint::rightHand;
}

std::vector<MeantGesture> meantBy(const World& world) {
    std::vector<MeantGesture> gestures(kMaximumMeant);
    gestures.resize(gesturesOf(world, 0.0, world.options().visitSeconds, gestures));
    return gestures;
}

float yawOf(const Skeleton& skeleton) {
    const Vector3f ahead = skeleton[Joint::torso].orientation * Vector3f::UnitZ();
    return std::atan2(-ahead.x(), -ahead.z()) * 180.0F / std::numbers::pi_v<float>;
}

class EveryScript : public testing::TestWithParam<Script> {};

TEST_P(EveryScript, GivesTheSameBytesWhateverWasRenderedBefore) {
    World first(optionsFor(GetParam(), 3));
    World second(optionsFor(GetParam(), 3));
    Image<std::uint16_t> depth, other;
    Image<Rgb8> none;
    for (const std::uint64_t frame : {700U, 20U, 150U})
        renderFrame(first, frame, depth, none);
    renderFrame(second, 150, other, none);
    EXPECT_EQ(depth.pixels, other.pixels);
    World another(optionsFor(GetParam(), 4));
    renderFrame(another, 150, other, none);
    EXPECT_NE(depth.pixels, other.pixels);
}

TEST_P(EveryScript, TakesNoMemoryOnceWarm) {
    World world(optionsFor(GetParam(), 5));
    Image<std::uint16_t> depth;
    Image<Rgb8> none;
    renderFrame(world, 0, depth, none);
    const cheval::test::AllocationCounter counter;
    // Across a pause and into the visits of others.
    for (std::uint64_t frame = 1; frame < 1500; frame += 61) {
        renderFrame(world, frame, depth, none);
        static_cast<void>(truthAt(world, world.timeOf(frame)));
    }
    EXPECT_EQ(counter.count(), 0U);
}

TEST_P(EveryScript, NeverTeleportsAJointInView) {
    constexpr double kStep = 1.0 / 60.0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const World world(optionsFor(GetParam(), seed));
        WorldTruth before = truthAt(world, 0.0);
        for (double t = kStep; t < world.options().visitSeconds; t += kStep) {
            const WorldTruth now = truthAt(world, t);
            ASSERT_EQ(now.figureCount, before.figureCount);
            for (std::size_t i = 0; i < now.figureCount; ++i) {
                if (!now.figures[i].whollyInView || !before.figures[i].whollyInView) continue;
                for (std::size_t joint = 0; joint < fitting::kJointCount; ++joint) {
                    const Vector3f way = now.figures[i].skeleton.joints[joint].position -
                                         before.figures[i].skeleton.joints[joint].position;
                    ASSERT_LT(way.norm() / kStep, 6.0)
                        << fitting::kJointNames[joint] << " of figure " << i << ", seed " << seed << " at " << t;
                }
            }
            before = now;
        }
    }
}

TEST_P(EveryScript, DrawsEveryFigureWhereTheTruthHasIt) {
    World world(optionsFor(GetParam(), 7));
    Image<std::uint16_t> depth;
    Image<Rgb8> none;
    const View view(Intrinsics{}, world.options().mount);
    for (std::uint64_t frame = 0; frame < 480; frame += 24) {
        renderFrame(world, frame, depth, none);
        const ExactView exact = exactView(world);
        const WorldTruth truth = truthAt(world, world.timeOf(frame));
        std::array<int, kMaximumFigures + 1> pixels{};
        for (int y = 0; y < exact.owner.height; ++y) {
            for (int x = 0; x < exact.owner.width; ++x) {
                ASSERT_LE(exact.owner.at(x, y), truth.figureCount);
                ++pixels[exact.owner.at(x, y)];
            }
        }
        for (std::size_t i = 0; i < truth.figureCount; ++i) {
            const FigureTruth& figure = truth.figures[i];
            if (!figure.inRoom) {
                EXPECT_EQ(pixels[i + 1], 0) << "figure " << i << " in frame " << frame;
            }
            if (!figure.whollyInView) continue;
            const auto at = view.project(view.toSensor(figure.skeleton[Joint::torso].position));
            const auto owner = exact.owner.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
            // Nobody else may be before one's own place but who is really nearer.
            if (owner == i + 1) continue;
            ASSERT_NE(owner, 0) << "figure " << i << " in frame " << frame;
            EXPECT_LT(truth.figures[owner - 1U].skeleton[Joint::torso].position.z(),
                      figure.skeleton[Joint::torso].position.z());
        }
    }
}

std::string nameOf(const testing::TestParamInfo<Script>& info) {
    constexpr std::array<const char*, kScriptCount> kNames = {"visit",     "resting",   "pacing",    "gestures",
                                                              "fidgeting", "passersBy", "occlusion", "mannequin",
                                                              "dog",       "measuring"};
    return kNames[static_cast<std::size_t>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(Scripts, EveryScript,
                         testing::Values(Script::resting, Script::pacing, Script::gestures, Script::fidgeting,
                                         Script::passersBy, Script::occlusion, Script::mannequin, Script::dog,
                                         Script::measuring),
                         nameOf);

TEST(Script, RestsWithoutTheLeastMotion) {
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const World world(optionsFor(Script::resting, seed));
        const Skeleton first = truthAt(world, 5.0).skeleton;
        EXPECT_NEAR(first[Joint::leftHip].position.z(), 2.5F, 0.12F);
        for (double t = 5.0; t < 15.0; t += 0.5) {
            const Skeleton now = truthAt(world, t).skeleton;
            for (std::size_t joint = 0; joint < fitting::kJointCount; ++joint)
                EXPECT_EQ(now.joints[joint].position, first.joints[joint].position) << fitting::kJointNames[joint];
        }
    }
}

TEST(Script, PacesAtOneMetreASecondFacingTheGlassOrTheWay) {
    int facing = 0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const World world(optionsFor(Script::pacing, seed));
        int steady = 0, toLeft = 0, toRight = 0, ahead = 0, aside = 0;
        for (double t = 4.0; t < 15.0; t += 0.05) {
            const Skeleton now = truthAt(world, t).skeleton;
            const Skeleton next = truthAt(world, t + 0.05).skeleton;
            const float speed = (next[Joint::neck].position - now[Joint::neck].position).x() / 0.05F;
            if (std::abs(std::abs(speed) - 1.0F) > 0.12F) continue;
            ++steady;
            ++(speed > 0.0F ? toRight : toLeft);
            const float yaw = std::abs(yawOf(now));
            ++(yaw < 15.0F ? ahead : aside);
            if (yaw >= 15.0F) {
                EXPECT_NEAR(yaw, 90.0F, 15.0F);
            }
        }
        EXPECT_GT(steady, 70) << "seed " << seed;
        EXPECT_GT(std::min(toLeft, toRight), 20);
        EXPECT_EQ(std::min(ahead, aside), 0);
        facing += ahead > 0 ? 1 : 0;
    }
    EXPECT_GT(facing, 0);
    EXPECT_LT(facing, static_cast<int>(kSeeds));
}

TEST(Script, SwipesTheWayTheShopperSeesIt) {
    int left = 0, right = 0, leftHand = 0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const World world(optionsFor(Script::gestures, seed, 30.0));
        for (const MeantGesture& gesture : meantBy(world)) {
            if (gesture.kind != MeantKind::swipe) continue;
            const WorldTruth from = truthAt(world, gesture.start);
            const WorldTruth to = truthAt(world, gesture.end);
            const auto at = [&](const WorldTruth& truth) -> Vector3f {
                // In the shopper's own axes: x to their left.
                const Vector3f hand = truth.skeleton[handOf(gesture.hand)].position;
                return truth.skeleton[Joint::torso].orientation.inverse() *
                       (hand - truth.skeleton[Joint::torso].position) / truth.statureMetres;
            };
            const Vector3f way = at(to) - at(from);
            EXPECT_GT(std::abs(way.x()), 0.15F) << "seed " << seed << " at " << gesture.start;
            EXPECT_LT(std::abs(way.y()), 0.4F * std::abs(way.x())) << "seed " << seed << " at " << gesture.start;
            EXPECT_EQ(way.x() > 0.0F, gesture.direction == SwipeDirection::left);
            // Facing the glass, the shopper's left is the mirror frame's −x.
            EXPECT_EQ(
                (to.skeleton[handOf(gesture.hand)].position - from.skeleton[handOf(gesture.hand)].position).x() < 0,
                gesture.direction == SwipeDirection::left);
            ++(gesture.direction == SwipeDirection::left ? left : right);
            leftHand += gesture.hand == Side::left ? 1 : 0;
            // One stroke, not two.
            float before = 0.0F;
            for (double t = gesture.start; t <= gesture.end; t += 0.02) {
                const float gone = std::abs((at(truthAt(world, t)) - at(from)).x());
                EXPECT_GT(gone, before - 0.01F);
                before = gone;
            }
        }
    }
    EXPECT_GT(std::min(left, right), 8);
    EXPECT_GT(std::min(leftHand, left + right - leftHand), 8);
}

TEST(Script, GrabsWithAHandThatIsOpenClosedAndOpenAgain) {
    int grabs = 0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const World world(optionsFor(Script::gestures, seed, 30.0));
        for (const MeantGesture& gesture : meantBy(world)) {
            if (gesture.kind != MeantKind::grab) continue;
            ++grabs;
            const auto stateAt = [&](double t) { return truthAt(world, t).hands[fitting::index(gesture.hand)]; };
            EXPECT_EQ(stateAt(gesture.start - 0.35), HandState::open) << "seed " << seed << " at " << gesture.start;
            EXPECT_EQ(stateAt(gesture.end + 0.35), HandState::open) << "seed " << seed << " at " << gesture.end;
            for (double t = gesture.start + 0.01; t < gesture.end - 0.01; t += 0.03)
                EXPECT_EQ(stateAt(t), HandState::closed) << "seed " << seed << " at " << t;
            const Skeleton skeleton = truthAt(world, gesture.start).skeleton;
            const Joint elbow = gesture.hand == Side::left ? Joint::leftElbow : Joint::rightElbow;
            EXPECT_GT(skeleton[handOf(gesture.hand)].position.y(), skeleton[elbow].position.y());
        }
    }
    EXPECT_GT(grabs, 10);
}

TEST(Script, MeansTheGesturesOfTheVisitAsItsHandsMove) {
    const World world(WorldOptions{.visitSeconds = 30.0});
    int swipes = 0, grabs = 0;
    for (const MeantGesture& gesture : meantBy(world)) {
        const WorldTruth from = truthAt(world, gesture.start);
        const WorldTruth to = truthAt(world, gesture.end);
        if (gesture.kind == MeantKind::swipe) {
            ++swipes;
            const float way =
                (to.skeleton[handOf(gesture.hand)].position - from.skeleton[handOf(gesture.hand)].position).x();
            EXPECT_GT(std::abs(way), 0.3F);
            EXPECT_EQ(way < 0.0F, gesture.direction == SwipeDirection::left);
        } else if (gesture.kind == MeantKind::grab) {
            ++grabs;
            EXPECT_EQ(truthAt(world, gesture.start + 0.01).hands[fitting::index(gesture.hand)], HandState::closed);
            EXPECT_EQ(truthAt(world, gesture.end - 0.01).hands[fitting::index(gesture.hand)], HandState::closed);
            EXPECT_NE(truthAt(world, gesture.start - 0.03).hands[fitting::index(gesture.hand)], HandState::closed);
            EXPECT_NE(truthAt(world, gesture.end + 0.03).hands[fitting::index(gesture.hand)], HandState::closed);
        }
    }
    EXPECT_EQ(swipes, 4);
    EXPECT_EQ(grabs, 1);
}

TEST(Script, FindsTheGesturesOfASpanInAnyVisit) {
    const World world(WorldOptions{});
    std::array<MeantGesture, 4> few;
    // The third visit's grab, and nothing else.
    ASSERT_EQ(gesturesOf(world, 48.0 + 11.5, 48.0 + 11.6, few), 1U);
    EXPECT_EQ(few[0].kind, MeantKind::grab);
    EXPECT_GT(few[0].start, 48.0);
    EXPECT_EQ(gesturesOf(world, 0.0, 100.0, few), few.size());
    EXPECT_EQ(gesturesOf(world, 21.0, 23.0, few), 0U);
}

TEST(Script, FidgetsInEveryWayAndMeansNothing) {
    float mostTurned = 0.0F, highestHand = -9.0F;
    bool crossed = false;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const World world(optionsFor(Script::fidgeting, seed, 30.0));
        EXPECT_TRUE(meantBy(world).empty());
        for (double t = 5.0; t < 30.0; t += 0.1) {
            const Skeleton now = truthAt(world, t).skeleton;
            mostTurned = std::max(mostTurned, std::abs(yawOf(now)));
            highestHand = std::max(highestHand, now[Joint::rightHand].position.y() - now[Joint::neck].position.y());
            const auto across = [&](Joint hand) -> float {
                return (now[Joint::torso].orientation.inverse() * (now[hand].position - now[Joint::torso].position))
                    .x();
            };
            crossed |= across(Joint::leftHand) < -0.05F && across(Joint::rightHand) > 0.05F;
        }
    }
    EXPECT_NEAR(mostTurned, 60.0F, 8.0F);
    EXPECT_GT(highestHand, 0.05F);
    EXPECT_TRUE(crossed);
}

TEST(Script, OthersPassBeforeBehindAndBeside) {
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const World world(optionsFor(Script::passersBy, seed, 20.0));
        float before = 0.0F, behind = 0.0F;
        bool beside = false;
        for (double t = 4.0; t < 20.0; t += 0.05) {
            const WorldTruth truth = truthAt(world, t);
            ASSERT_EQ(truth.figureCount, 3U);
            EXPECT_TRUE(truth.figures[0].inRoom);
            const Vector3f shopper = truth.skeleton[Joint::torso].position;
            for (std::size_t i = 1; i < 3; ++i) {
                if (!truth.figures[i].inRoom) continue;
                const Vector3f way = truth.figures[i].skeleton[Joint::torso].position - shopper;
                if (std::abs(way.x()) < 0.2F) {
                    before = std::min(before, way.z());
                    behind = std::max(behind, way.z());
                    EXPECT_GT(std::abs(way.z()), 0.45F) << "through the shopper, seed " << seed << " at " << t;
                }
                beside |= std::abs(way.x()) < 0.95F && std::abs(way.z()) < 0.3F;
            }
        }
        EXPECT_GT(before, -1.15F) << "seed " << seed;
        EXPECT_LT(before, -0.5F) << "seed " << seed;
        EXPECT_GT(behind, 0.5F) << "seed " << seed;
        EXPECT_TRUE(beside) << "seed " << seed;
    }
}

TEST(Script, HidesEveryJointOfTheShopperForASecond) {
    const View view(Intrinsics{}, WorldOptions{}.mount);
    double sum = 0.0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        WorldOptions options = optionsFor(Script::occlusion, seed);
        options.sensorNoise = false;
        World world(options);
        Image<std::uint16_t> depth;
        Image<Rgb8> none;
        int hidden = 0;
        for (std::uint64_t frame = 0; frame < 360; ++frame) {
            // Only a figure that stands before the shopper can hide them.
            const WorldTruth truth = truthAt(world, world.timeOf(frame));
            const Vector3f other = truth.figures[1].skeleton[Joint::torso].position;
            if (!truth.figures[1].inRoom || std::abs(other.x()) > 0.6F) continue;
            renderFrame(world, frame, depth, none);
            const ImageView<const std::uint8_t> owner = exactView(world).owner;
            const auto shows = [&](const fitting::JointState& joint) {
                const auto at = view.project(view.toSensor(joint.position));
                return owner.at(static_cast<int>(at.x()), static_cast<int>(at.y())) != 2;
            };
            hidden += std::none_of(truth.skeleton.joints.begin(), truth.skeleton.joints.end(), shows) ? 1 : 0;
        }
        EXPECT_GE(hidden, 21) << "seed " << seed;
        EXPECT_LE(hidden, 42) << "seed " << seed;
        sum += hidden / 30.0;
    }
    EXPECT_NEAR(sum / kSeeds, 1.0, 0.2);
}

TEST(Script, NeverMovesTheMannequin) {
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        WorldOptions options = optionsFor(Script::mannequin, seed);
        const World world(options);
        const auto mannequinAt = [&](double t) {
            const WorldTruth truth = truthAt(world, t);
            EXPECT_EQ(truth.figures[1].kind, FigureKind::mannequin);
            EXPECT_TRUE(truth.figures[1].inRoom);
            return truth.figures[1].skeleton;
        };
        const Skeleton first = mannequinAt(0.0);
        EXPECT_LT(std::abs(first[Joint::torso].position.x()), 1.3F);
        bool came = false, left = false;
        // Into the next visit, across the pause.
        for (double t = 0.0; t < 30.0; t += 0.25) {
            const Skeleton now = mannequinAt(t);
            for (std::size_t joint = 0; joint < fitting::kJointCount; ++joint)
                EXPECT_EQ(now.joints[joint].position, first.joints[joint].position) << "at " << t;
            if (t > options.visitSeconds) continue;
            came |= truthAt(world, t).present;
            left |= came && !truthAt(world, t).skeleton.present();
        }
        EXPECT_TRUE(came);
        EXPECT_TRUE(left);
    }
}

TEST(Script, LetsADogThroughAndNobodyElse) {
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        World world(optionsFor(Script::dog, seed, 8.0));
        Image<std::uint16_t> depth;
        Image<Rgb8> none;
        int most = 0;
        for (std::uint64_t frame = 0; frame < 240; frame += 10) {
            const WorldTruth truth = truthAt(world, world.timeOf(frame));
            EXPECT_FALSE(truth.present);
            EXPECT_FALSE(truth.skeleton.present());
            ASSERT_EQ(truth.figureCount, 1U);
            EXPECT_EQ(truth.figures[0].kind, FigureKind::dog);
            renderFrame(world, frame, depth, none);
            const ImageView<const std::uint8_t> owner = exactView(world).owner;
            int seen = 0;
            for (int y = 0; y < owner.height; ++y)
                seen += static_cast<int>(std::count(owner.row(y), owner.row(y) + owner.width, std::uint8_t{1}));
            most = std::max(most, seen);
        }
        EXPECT_GT(most, 1500) << "seed " << seed;
    }
}

TEST(Script, BringsChildrenAndWheelchairUsers) {
    int children = 0, wheelchairs = 0;
    Cast cast;
    for (std::uint32_t seed = 1; seed <= 300; ++seed) {
        castVisit(optionsFor(Script::gestures, seed), 0, cast);
        const Performer& shopper = cast.performers.view().front();
        children += shopper.shopper.stature < 1.4F ? 1 : 0;
        if (!shopper.shopper.wheelchair) continue;
        ++wheelchairs;
        const World world(optionsFor(Script::gestures, seed));
        EXPECT_TRUE(truthAt(world, 6.0).figures[0].wheelchair);
        const Skeleton skeleton = truthAt(world, 6.0).skeleton;
        // Thighs lie, shins hang, and the hips are at a seat's height.
        EXPECT_LT(std::abs(skeleton[Joint::leftHip].position.y() - skeleton[Joint::leftKnee].position.y()), 0.12F);
        EXPECT_GT(skeleton[Joint::leftKnee].position.y() - skeleton[Joint::leftFoot].position.y(), 0.3F);
        EXPECT_NEAR(skeleton[Joint::leftHip].position.y(), 0.56F, 0.1F);
    }
    EXPECT_GT(children, 25);
    EXPECT_GT(wheelchairs, 4);
}

}  // namespace
}  // namespace cheval::hal::sim

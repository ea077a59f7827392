// Whole visits of the simulated kiosk, whose people and sensor are not of the tracker's making.
#include <chrono>
#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "fitting/tracking/tracker.h"
#include "hal/sim/world.h"

namespace cheval::fitting {
namespace {

constexpr double kFramesPerSecond = 15.0;

class Visit : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Visit, IsFollowedFromWalkInToWalkOut) {
    hal::VirtualClock clock;
    const auto world = hal::sim::makeWorld(
        {.seed = GetParam(), .framesPerSecond = kFramesPerSecond, .colour = false, .visitSeconds = 16.0});
    const auto camera = hal::sim::makeSimulatedCamera(world, clock);
    ASSERT_TRUE(camera->open().hasValue());
    Tracker tracker(TrackerOptions{.mount = camera->info().mount});

    int present = 0, found = 0, joints = 0, near = 0, states = 0, right = 0, changes = 0, grabs = 0;
    double sum = 0.0;
    std::uint32_t user = 0;
    for (int i = 0; i < static_cast<int>(17 * kFramesPerSecond); ++i) {
        hal::DepthFrame frame;
        ASSERT_EQ(camera->waitFrame(std::chrono::seconds(1), frame), hal::FrameStatus::frame);
        tracker.track(frame);
        tracker.readHands(frame);
        for (std::size_t k = 0; k < tracker.hands().gestureCount; ++k) {
            grabs += tracker.hands().gestures[k].kind == GestureKind::grab ? 1 : 0;
        }
        const hal::sim::WorldTruth truth = hal::sim::truthAt(*world, i / kFramesPerSecond);
        if (!truth.present) continue;
        ++present;
        const Skeleton& skeleton = tracker.skeleton();
        if (!skeleton.present()) continue;
        ++found;
        if (user != 0 && user != skeleton.userId) ++changes;
        user = skeleton.userId;
        // Of people in profile one side is hidden.
        const auto forward = [](const Skeleton& s) -> Eigen::Vector3f {
            return s[Joint::torso].orientation * Eigen::Vector3f::UnitZ();
        };
        if (forward(truth.skeleton).z() > -0.85F) continue;
        EXPECT_GT(forward(skeleton).dot(forward(truth.skeleton)), 0.75F) << "frame " << i;
        for (std::size_t joint = 0; joint < kJointCount; ++joint) {
            const float error = (skeleton.joints[joint].position - truth.skeleton.joints[joint].position).norm();
            sum += error;
            ++joints;
            near += error <= 0.1F ? 1 : 0;
        }
        for (const Side side : {Side::left, Side::right}) {
            if (truth.hands[index(side)] == HandState::unknown) continue;
            ++states;
            right += tracker.hands()[side].state == truth.hands[index(side)] ? 1 : 0;
        }
    }
    ASSERT_GT(present, 100);
    EXPECT_GT(found, present * 95 / 100);
    EXPECT_EQ(changes, 0);
    ASSERT_GT(joints, 1000);
    EXPECT_LT(sum / joints, 0.040);
    EXPECT_GT(near, joints * 97 / 100);
    ASSERT_GT(states, 20);
    EXPECT_GT(right, states * 80 / 100);
    EXPECT_EQ(grabs, 1);
    RecordProperty("mean_mm", std::to_string(sum / joints * 1e3));
}

INSTANTIATE_TEST_SUITE_P(Seeds, Visit, testing::Values(1U, 2U, 4U));

TEST(Visit, NobodyIsSeenBeforeTheVisitAndNobodyAfter) {
    hal::VirtualClock clock;
    const auto world = hal::sim::makeWorld({.seed = 5, .framesPerSecond = 5.0, .colour = false, .visitSeconds = 12.0});
    const auto camera = hal::sim::makeSimulatedCamera(world, clock);
    ASSERT_TRUE(camera->open().hasValue());
    Tracker tracker(TrackerOptions{.mount = camera->info().mount});
    hal::DepthFrame frame;
    ASSERT_EQ(camera->waitFrame(std::chrono::seconds(1), frame), hal::FrameStatus::frame);
    tracker.track(frame);
    tracker.readHands(frame);
    EXPECT_FALSE(tracker.skeleton().present());
    bool came = false;
    while (camera->waitFrame(std::chrono::seconds(1), frame) == hal::FrameStatus::frame && frame.sequence < 74) {
        tracker.track(frame);
        tracker.readHands(frame);
        came |= tracker.skeleton().present();
    }
    EXPECT_TRUE(came);
    EXPECT_FALSE(tracker.skeleton().present());
}

/// Plays a script of the simulated kiosk and looks at the tracker after each frame.
template <typename Look>
void play(hal::sim::Script script, std::uint32_t seed, double seconds, const Look& look) {
    hal::VirtualClock clock;
    const auto world = hal::sim::makeWorld({.seed = seed,
                                            .framesPerSecond = kFramesPerSecond,
                                            .colour = false,
                                            .script = script,
                                            .visitSeconds = seconds});
    const auto camera = hal::sim::makeSimulatedCamera(world, clock);
    ASSERT_TRUE(camera->open().hasValue());
    Tracker tracker(TrackerOptions{.mount = camera->info().mount});
    for (int i = 0; i < static_cast<int>(seconds * kFramesPerSecond); ++i) {
        hal::DepthFrame frame;
        ASSERT_EQ(camera->waitFrame(std::chrono::seconds(1), frame), hal::FrameStatus::frame);
        tracker.track(frame);
        look(tracker, hal::sim::truthAt(*world, i / kFramesPerSecond), i / kFramesPerSecond);
    }
}

TEST(Visit, AMannequinIsNobodyButTheShopperBesideItIsSomebody) {
    int wrong = 0, nobody = 0, shopper = 0, present = 0;
    play(hal::sim::Script::mannequin, 8001, 6.0, [&](const Tracker& tracker, const auto& truth, double time) {
        const User* active = tracker.users().active();
        if (time < 1.1) return;  // It was there first: it has a second to stir.
        const hal::sim::FigureTruth& person = truth.figures[0];
        if (!person.inRoom) {
            wrong += active != nullptr ? 1 : 0;
            ++nobody;
        } else if (person.whollyInView) {
            ++present;
            const float away =
                active == nullptr ? 1e3F : std::abs(active->centroid.x() - person.skeleton[Joint::torso].position.x());
            shopper += away < 0.3F ? 1 : 0;
        }
    });
    EXPECT_EQ(wrong, 0);
    ASSERT_GT(nobody, 4);
    ASSERT_GT(present, 20);
    EXPECT_GT(shopper, present * 9 / 10);
}

TEST(Visit, ADogIsNobody) {
    int active = 0;
    play(hal::sim::Script::dog, 9001, 6.0,
         [&](const Tracker& tracker, const auto&, double) { active += tracker.users().active() != nullptr ? 1 : 0; });
    EXPECT_EQ(active, 0);
}

TEST(Visit, WhoeverWalksInSidewaysLooksWhereTheyGo) {
    int walking = 0, right = 0;
    play(hal::sim::Script::resting, 2022, 3.0, [&](const Tracker& tracker, const auto& truth, double) {
        const User* active = tracker.users().active();
        if (!truth.present || active == nullptr || !tracker.skeleton().present()) return;
        const auto forward = [](const Skeleton& s) -> Eigen::Vector3f {
            return s[Joint::torso].orientation * Eigen::Vector3f::UnitZ();
        };
        if (std::abs(forward(truth.skeleton).x()) < 0.85F) return;
        ++walking;
        right += forward(tracker.skeleton()).dot(forward(truth.skeleton)) > 0.5F ? 1 : 0;
    });
    ASSERT_GT(walking, 5);
    EXPECT_EQ(right, walking);
}

TEST(Visit, WhoeverSitsInAWheelchairHasTheirKneesBeforeThem) {
    double off = 0.0;
    int frames = 0, before = 0;
    play(hal::sim::Script::resting, 2011, 5.5, [&](const Tracker& tracker, const auto& truth, double time) {
        if (time < 2.8 || time > 4.0 || !truth.figures[0].inRoom) return;
        ASSERT_TRUE(truth.figures[0].wheelchair);
        ++frames;
        const Skeleton& seen = tracker.skeleton();
        if (!seen.present()) return;
        for (const Joint joint : {Joint::leftKnee, Joint::rightKnee}) {
            off += static_cast<double>((seen[joint].position - truth.skeleton[joint].position).norm()) / 2.0;
            before += seen[joint].position.z() < seen[Joint::torso].position.z() - 0.2F ? 1 : 0;
        }
    });
    ASSERT_GT(frames, 10);
    EXPECT_EQ(before, 2 * frames);
    EXPECT_LT(off / frames, 0.10) << "metres, of the knees";
}

}  // namespace
}  // namespace cheval::fitting

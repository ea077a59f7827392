// The judge of the tracker, held against recordings whose figures are known: the truth itself, and the truth spoilt in
// one way at a time.
#include "tests/fitting/tracking/visit_figures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

namespace cheval::fitting::test {
namespace {

using hal::sim::MeantGesture;
using hal::sim::MeantKind;
using hal::sim::Script;

/// The truth of a visit as if it had been tracked, without drawing a frame: every joint in view is visible.
VisitRecording perfect(Script script, std::uint32_t seed, double seconds) {
    const auto world = hal::sim::makeWorld({.seed = seed,
                                            .framesPerSecond = kVisitFramesPerSecond,
                                            .colour = false,
                                            .script = script,
                                            .visitSeconds = seconds});
    VisitRecording recording{.script = script, .seed = seed};
    recording.meant.resize(128);
    recording.meant.resize(hal::sim::gesturesOf(*world, 0.0, seconds, recording.meant));
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(seconds * kVisitFramesPerSecond); ++i) {
        SeenFrame frame;
        frame.time = world->timeOf(i);
        const hal::sim::WorldTruth truth = hal::sim::truthAt(*world, frame.time);
        frame.inRoom = truth.skeleton.present();
        frame.whollyInView = truth.present;
        // Near the glass, toes alone are out of the picture.
        const bool tracked = std::abs(truth.skeleton[Joint::torso].position.x()) < 1.6F && frame.inRoom;
        frame.torsoInPicture = tracked;
        frame.truth = frame.tracked = truth.skeleton;
        frame.visible.fill(tracked);
        frame.trueHands = truth.hands;
        for (const Side side : {Side::left, Side::right})
            frame.hands[side].state = truth.hands[index(side)];
        frame.activeId = tracked ? 1 : 0;
        frame.activeFigure = tracked ? 0 : kNobody;
        recording.frames.push_back(frame);
    }
    for (const MeantGesture& meant : recording.meant) {
        if (meant.kind == MeantKind::transition) continue;
        const auto at = static_cast<std::size_t>(meant.end * kVisitFramesPerSecond) + 1;
        Hands& hands = recording.frames.at(at).hands;
        hands.gestures.at(hands.gestureCount++) = {
            .kind = meant.kind == MeantKind::swipe ? GestureKind::swipe : GestureKind::grab,
            .hand = meant.hand,
            .direction = meant.direction,
            .start = hal::TimePoint(hal::fromSeconds(meant.start)),
            .end = hal::TimePoint(hal::fromSeconds(meant.end))};
    }
    return recording;
}

TEST(VisitFigures, FindNothingWrongWithTheTruth) {
    const VisitFigures figures = figuresOf(perfect(Script::gestures, 3, 20.0));
    EXPECT_EQ(figures.firstFull, std::vector<double>{0.0});
    EXPECT_GT(figures.swipes.count + figures.grabs.count, 3);
    EXPECT_EQ(figures.swipes.hits, figures.swipes.count);
    EXPECT_EQ(figures.grabs.hits, figures.grabs.count);
    EXPECT_EQ(figures.strayGestures, 0);
    EXPECT_EQ(figures.swaps.hits, 0);
    EXPECT_GT(figures.swaps.count, 300);
    EXPECT_EQ(figures.allErrors().meanMm(), 0.0);
    EXPECT_EQ(figures.allErrors().missed, 0);
    EXPECT_EQ(figures.openHands.hits, figures.openHands.count);
    EXPECT_TRUE(figures.misses.empty());
}

TEST(VisitFigures, MeasureHowLongTheFirstSkeletonTakes) {
    VisitRecording recording = perfect(Script::resting, 3, 8.0);
    const auto entry = std::find_if(recording.frames.begin(), recording.frames.end(),
                                    [](const SeenFrame& frame) { return frame.whollyInView; });
    // A second late, and for half of that with a knee out of place.
    for (auto frame = entry; frame < entry + 15; ++frame) {
        frame->tracked = {};
        frame->activeFigure = kNobody;
    }
    for (auto frame = entry + 15; frame < entry + 30; ++frame)
        frame->tracked[Joint::leftKnee].position.x() += 0.2F;
    const VisitFigures figures = figuresOf(recording);
    ASSERT_EQ(figures.firstFull.size(), 1U);
    EXPECT_NEAR(figures.firstFull[0], 1.0, 1e-6);
    EXPECT_EQ(figures.misses.size(), 2U);
}

TEST(VisitFigures, CountOtherPeoplesAndExchangedLimbs) {
    VisitRecording recording = perfect(Script::resting, 3, 8.0);
    for (std::size_t i = 180; i < 210; ++i)
        std::swap(recording.frames[i].tracked[Joint::leftHand], recording.frames[i].tracked[Joint::rightHand]);
    // A hand alone is no limb; with the elbow it is one.
    EXPECT_EQ(figuresOf(recording).swaps.hits, 0);
    for (std::size_t i = 180; i < 210; ++i)
        std::swap(recording.frames[i].tracked[Joint::leftElbow], recording.frames[i].tracked[Joint::rightElbow]);
    EXPECT_EQ(figuresOf(recording).swaps.hits, 30);
    for (std::size_t i = 215; i < 225; ++i)
        recording.frames[i].activeFigure = 1;
    EXPECT_EQ(figuresOf(recording).allErrors().missed, 150);
}

TEST(VisitFigures, MeasureJitterAboutEachJointsOwnMean) {
    VisitRecording recording = perfect(Script::resting, 3, 8.0);
    for (std::size_t i = 0; i < recording.frames.size(); ++i) {
        // A constant offset is no jitter.
        Eigen::Vector3f& hand = recording.frames[i].tracked[Joint::leftHand].position;
        hand.y() += 0.05F;
        hand.z() += i % 2 == 0 ? 0.006F : -0.006F;
    }
    const VisitFigures figures = figuresOf(recording);
    const auto rms = [&](Joint joint) {
        return 1e3 *
               std::sqrt(figures.restSquares[index(joint)] / static_cast<double>(figures.restFrames[index(joint)]));
    };
    EXPECT_NEAR(rms(Joint::leftHand), 6.0, 0.01);
    EXPECT_NEAR(rms(Joint::rightHand), 0.0, 1e-3);
}

TEST(VisitFigures, MeasureTheLagOfEachJoint) {
    for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
        VisitRecording recording = perfect(Script::pacing, seed, 9.0);
        const VisitRecording truth = recording;
        // Two frames late.
        for (std::size_t i = 2; i < recording.frames.size(); ++i) {
            const bool tracked = recording.frames[i].tracked.present();
            if (!tracked || !truth.frames[i - 2].truth.present()) continue;
            Skeleton& late = recording.frames[i].tracked;
            late = truth.frames[i - 2].truth;
            // All too far ahead, which turns with the body and is no lag.
            const Eigen::Vector3f ahead = late[Joint::torso].orientation * Eigen::Vector3f(0.0F, 0.0F, 0.04F);
            for (JointState& joint : late.joints)
                joint.position += ahead;
        }
        const VisitFigures figures = figuresOf(recording);
        for (const auto* curves : {&figures.lagFacing, &figures.lagAside}) {
            for (const LagCurve& curve : *curves) {
                if (curve.frames == 0) continue;
                EXPECT_NEAR(curve.bestMs(), 2e3 / kVisitFramesPerSecond, 3.0);
            }
        }
        EXPECT_GT(figures.lagFacing[0].frames + figures.lagAside[0].frames, 90);
    }
}

TEST(VisitFigures, MatchGesturesByKindHandAndDirection) {
    VisitRecording recording = perfect(Script::gestures, 3, 20.0);
    const VisitFigures before = figuresOf(recording);
    long turned = 0;
    for (SeenFrame& frame : recording.frames) {
        for (std::size_t i = 0; i < frame.hands.gestureCount; ++i) {
            GestureEvent& event = frame.hands.gestures[i];
            if (event.kind != GestureKind::swipe) continue;
            event.hand = event.hand == Side::left ? Side::right : Side::left;
            ++turned;
        }
    }
    ASSERT_GT(turned, 0);
    const VisitFigures after = figuresOf(recording);
    EXPECT_EQ(after.swipes.count, before.swipes.count);
    EXPECT_EQ(after.swipes.hits, 0);
    EXPECT_EQ(after.strayGestures, turned);
    EXPECT_EQ(after.grabs.hits, before.grabs.hits);
}

TEST(VisitFigures, CountEveryEventOfAFidgetAsFalse) {
    VisitRecording recording = perfect(Script::fidgeting, 3, 15.0);
    Hands& hands = recording.frames[300].hands;
    hands.gestures[hands.gestureCount++] = {.kind = GestureKind::grab, .hand = Side::left};
    hands.gestures[hands.gestureCount++] = {.kind = GestureKind::hold, .hand = Side::left};
    // To wake the mirror is no false event.
    hands.gestures[hands.gestureCount++] = {.kind = GestureKind::raise, .hand = Side::left};
    const VisitFigures figures = figuresOf(recording);
    EXPECT_EQ(figures.falseEvents, 2);
    EXPECT_NEAR(figures.fidgetSeconds, 14.0, 1.0);
}

TEST(VisitStatistics, BoundsAreThoseOfTheLiterature) {
    // Newcombe, Statistics in Medicine 17 (1998), table I, Wilson without continuity correction.
    const auto [low, high] = Rate{81, 263}.bounds();
    EXPECT_NEAR(low, 0.2553, 5e-5);
    EXPECT_NEAR(high, 0.3662, 5e-5);
    EXPECT_NEAR((Rate{0, 20}.bounds().second), 0.1611, 5e-5);
    // Garwood's exact bounds of 10 events: 4.80 to 18.39.
    EXPECT_NEAR(poissonBounds(10).first, 4.80, 0.02);
    EXPECT_NEAR(poissonBounds(10).second, 18.39, 0.02);
    EXPECT_EQ(poissonBounds(0).first, 0.0);
    EXPECT_NEAR(poissonBounds(0).second, 3.69, 0.1);
    EXPECT_NEAR(quantile({3.0, 1.0, 2.0}, 0.5), 2.0, 1e-12);
    EXPECT_NEAR(quantile({0.0, 1.0}, 0.95), 0.95, 1e-12);
}

}  // namespace
}  // namespace cheval::fitting::test

// The state machines of gestures, by scripts of hands.
#include "fitting/tracking/gestures.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::fitting::tracking {
namespace {

constexpr float kFrameSeconds = 1.0F / 30.0F;

/// A shopper of some stature at some place, whose right hand follows a script.
struct Script {
    float stature = 1.7F;
    float seconds = 2.0F;
    /// Right hand about the neck, in statures: right of the shopper, up, towards the glass.
    std::function<Eigen::Vector3f(float)> at;
    std::function<HandState(float)> state = [](float) { return HandState::open; };
    float confidence = 0.9F;  ///< Of the state.
    std::function<bool(float)> raised = [](float) { return true; };
    /// Where they stand on the floor.
    std::function<Eigen::Vector3f(float)> walk = [](float) { return Eigen::Vector3f(0.0F, 0.0F, 2.2F); };
    std::function<bool(float)> dropped = [](float) { return false; };  ///< Frames that do not come.
};

/// All events; `progress`, if any, gets Hand::holding of each frame.
std::vector<GestureEvent> play(const Script& script, const GestureOptions& options = {},
                               std::vector<float>* progress = nullptr) {
    GestureReader reader(options);
    std::vector<GestureEvent> events;
    for (int i = 0; static_cast<float>(i) * kFrameSeconds < script.seconds; ++i) {
        const float time = static_cast<float>(i) * kFrameSeconds;
        if (script.dropped(time)) continue;
        const Eigen::Vector3f place = script.walk(time);
        hal::DepthFrame frame;
        frame.sourceIndex = static_cast<std::uint64_t>(i);
        frame.captureTime = hal::TimePoint(hal::Duration(static_cast<std::int64_t>(1e9) * i / 30));
        Skeleton skeleton;
        skeleton.userId = 1;
        skeleton[Joint::neck].position = place + Eigen::Vector3f(0.0F, 0.85F * script.stature, 0.0F);
        skeleton[Joint::rightShoulder].position = place + Eigen::Vector3f(0.1F, 0.79F, 0.0F) * script.stature;
        skeleton[Joint::leftShoulder].position = place + Eigen::Vector3f(-0.1F, 0.79F, 0.0F) * script.stature;
        Hands hands;
        Hand& hand = hands[Side::right];
        const Eigen::Vector3f at = script.at(time);
        hand.position = skeleton[Joint::neck].position + script.stature * Eigen::Vector3f(at.x(), at.y(), -at.z());
        hand.state = script.state(time);
        hand.confidence = script.confidence;
        hand.raised = script.raised(time);
        hands[Side::left].position = place + Eigen::Vector3f(-0.2F, 0.5F, 0.0F) * script.stature;
        reader.update(frame, skeleton, script.stature, hands);
        if (progress != nullptr) progress->push_back(hands[Side::right].holding);
        events.insert(events.end(), hands.gestures.begin(),
                      hands.gestures.begin() + static_cast<std::ptrdiff_t>(hands.gestureCount));
    }
    return events;
}

/// What play() tells of one kind.
std::vector<GestureEvent> played(GestureKind kind, const Script& script, const GestureOptions& options = {}) {
    std::vector<GestureEvent> events = play(script, options);
    std::erase_if(events, [kind](const GestureEvent& event) { return event.kind != kind; });
    return events;
}

/// From `a` to `b` between two times, smoothly; still before and after.
std::function<Eigen::Vector3f(float)> move(const Eigen::Vector3f& a, const Eigen::Vector3f& b, float from, float to) {
    return [=](float time) -> Eigen::Vector3f {
        const float t = std::clamp((time - from) / (to - from), 0.0F, 1.0F);
        return a + (b - a) * (t * t * (3.0F - 2.0F * t));
    };
}

const Eigen::Vector3f kRightSide(0.25F, -0.12F, 0.2F);
const Eigen::Vector3f kLeftSide(-0.10F, -0.12F, 0.2F);

// The analyzer loses sight of who owns the functions in these plays.
// NOLINTBEGIN(clang-analyzer-cplusplus.NewDeleteLeaks)

TEST(Swipe, IsReportedOnceWithItsDirectionWhateverTheSizeAndPlace) {
    for (const float stature : {1.0F, 1.5F, 1.95F}) {
        for (const float away : {1.0F, 2.5F, 4.0F}) {
            const auto left =
                play({.stature = stature, .at = move(kRightSide, kLeftSide, 0.5F, 0.95F), .walk = [away](float) {
                          return Eigen::Vector3f(0.4F, 0.0F, away);
                      }});
            ASSERT_EQ(left.size(), 1U);
            EXPECT_EQ(left[0].kind, GestureKind::swipe);
            EXPECT_EQ(left[0].hand, Side::right);
            EXPECT_EQ(left[0].direction, SwipeDirection::left);
            EXPECT_LT(left[0].startFrame, left[0].endFrame);
            const auto right =
                play({.stature = stature, .at = move(kLeftSide, kRightSide, 0.5F, 0.95F), .walk = [away](float) {
                          return Eigen::Vector3f(0.4F, 0.0F, away);
                      }});
            ASSERT_EQ(right.size(), 1U);
            EXPECT_EQ(right[0].direction, SwipeDirection::right);
        }
    }
}

TEST(Swipe, IsNotMadeOfSlowMovesShortMovesOrMovesUpAndDown) {
    EXPECT_TRUE(played(GestureKind::swipe, {.at = move(kRightSide, kLeftSide, 0.2F, 1.8F)}).empty());
    EXPECT_TRUE(played(GestureKind::swipe, {.at = move(kRightSide, 0.75F * kRightSide + 0.25F * kLeftSide, 0.5F, 0.6F)})
                    .empty());
    EXPECT_TRUE(
        played(GestureKind::swipe, {.at = move(kRightSide, kLeftSide - Eigen::Vector3f(0.0F, 0.5F, 0.0F), 0.5F, 0.95F)})
            .empty());
}

TEST(Swipe, IsNotMadeByAHandThatHangs) {
    EXPECT_TRUE(played(GestureKind::swipe,
                       {.at = move(kRightSide, kLeftSide, 0.5F, 0.95F), .raised = [](float) { return false; }})
                    .empty());
}

TEST(Swipe, IsNotMadeByWalking) {
    // The hand keeps its place about the body, or stays behind in the shop, while the body goes sideways.
    const auto walk = [](float t) -> Eigen::Vector3f { return {0.8F * t, 0.0F, 2.2F}; };
    EXPECT_TRUE(played(GestureKind::swipe, {.at = [](float) { return kRightSide; }, .walk = walk}).empty());
    const auto leftBehind = [](float t) -> Eigen::Vector3f {
        return kRightSide - Eigen::Vector3f(0.8F / 1.7F * t, 0.0F, 0.0F);
    };
    EXPECT_TRUE(played(GestureKind::swipe, {.seconds = 1.0F, .at = leftBehind, .walk = walk}).empty());
}

HandState closedBetween(float time, float from, float to) {
    return time >= from && time < to ? HandState::closed : HandState::open;
}

TEST(Grab, IsClosedThenOpenOfARaisedHand) {
    const auto events = play(
        {.at = [](float) { return kRightSide; }, .state = [](float time) { return closedBetween(time, 0.5F, 1.0F); }});
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].kind, GestureKind::grab);
    EXPECT_NEAR(static_cast<double>(events[0].startFrame), 15.0, 1.0);
    EXPECT_NEAR(static_cast<double>(events[0].endFrame), 30.0, 1.0);
}

TEST(Grab, IsNotAFlickerAFistThatStaysOrALowHand) {
    const auto still = [](float) { return kRightSide; };
    EXPECT_TRUE(played(GestureKind::grab, {.at = still, .state = [](float t) { return closedBetween(t, 0.5F, 0.55F); }})
                    .empty());
    EXPECT_TRUE(played(GestureKind::grab, {.at = still, .state = [](float t) { return closedBetween(t, 0.5F, 9.0F); }})
                    .empty());
    EXPECT_TRUE(played(GestureKind::grab,
                       {.seconds = 6.0F, .at = still, .state = [](float t) { return closedBetween(t, 0.5F, 5.0F); }})
                    .empty());
    EXPECT_TRUE(played(GestureKind::grab, {.at = still,
                                           .state = [](float t) { return closedBetween(t, 0.5F, 1.0F); },
                                           .raised = [](float) { return false; }})
                    .empty());
    // Lowered while closed.
    EXPECT_TRUE(played(GestureKind::grab, {.at = still,
                                           .state = [](float t) { return closedBetween(t, 0.5F, 1.0F); },
                                           .raised = [](float t) { return t < 0.8F; }})
                    .empty());
}

TEST(Grab, IsNotAHandThatTalks) {
    const auto opensAgain = [](float t) { return closedBetween(t, 0.5F, 1.0F); };
    const auto beforeTheChest = [](float) -> Eigen::Vector3f { return kRightSide - Eigen::Vector3f(0.0F, 0.1F, 0.0F); };
    EXPECT_TRUE(play({.at = beforeTheChest, .state = opensAgain}).empty());
    const auto still = [](float) { return kRightSide; };
    EXPECT_TRUE(play({.at = still, .state = opensAgain, .confidence = 0.4F}).empty()) << "half closed";
    EXPECT_EQ(play({.at = still, .state = opensAgain, .confidence = 0.8F}).size(), 1U);
}

TEST(Raise, CountsOnceUntilTheHandWasDown) {
    const Eigen::Vector3f low(0.2F, -0.3F, 0.1F);
    const Eigen::Vector3f high(0.2F, 0.1F, 0.1F);
    const auto once =
        played(GestureKind::raise, {.at = move(low, high, 0.3F, 0.8F), .raised = [](float) { return true; }});
    ASSERT_EQ(once.size(), 1U);
    EXPECT_EQ(once[0].kind, GestureKind::raise);
    const auto twice = played(GestureKind::raise, {.seconds = 4.0F, .at = [&](float time) {
                                                       return time < 0.5F || (time > 1.5F && time < 2.5F) ? low : high;
                                                   }});
    EXPECT_EQ(twice.size(), 2U);
}

std::vector<GestureEvent> holds(const Script& script, const GestureOptions& options = {}) {
    return played(GestureKind::hold, script, options);
}

Eigen::Vector3f still(float) {
    return kRightSide;
}

TEST(Hold, IsToldOnceByAnOpenHandKeptStillWhateverTheSizeAndPlace) {
    for (const float stature : {1.0F, 1.5F, 1.95F}) {
        for (const float away : {1.0F, 2.5F, 4.0F}) {
            // Up in half a second; then it trembles, but stays where it is.
            const auto up = move({0.2F, -0.5F, 0.0F}, kRightSide, 0.5F, 1.0F);
            const auto events =
                play({.stature = stature,
                      .seconds = 10.0F,
                      .at = [&](float time) -> Eigen::Vector3f {
                          return up(time) + 0.006F * Eigen::Vector3f(std::sin(31.0F * time), std::sin(23.0F * time),
                                                                     std::sin(17.0F * time));
                      },
                      .raised = [](float time) { return time > 0.75F; },
                      .walk = [away](float) { return Eigen::Vector3f(0.4F, 0.0F, away); }});
            ASSERT_EQ(events.size(), 1U);
            EXPECT_EQ(events[0].kind, GestureKind::hold);
            EXPECT_EQ(events[0].hand, Side::right);
            EXPECT_NEAR(hal::seconds(events[0].end - events[0].start), GestureOptions{}.holdTime, 0.05);
            EXPECT_NEAR(static_cast<double>(events[0].startFrame), 29.0, 3.0);
        }
    }
}

struct NoHold {
    const char* name;
    Script script;
};

TEST(Hold, IsNotMadeByATableOfWhatHandsDo) {
    const auto slowly = [](float time) -> Eigen::Vector3f {
        return kRightSide + Eigen::Vector3f(0.04F * time, 0.0F, 0.0F);
    };
    const auto toAndFro = [](float time) -> Eigen::Vector3f {
        return kRightSide + Eigen::Vector3f(0.0F, 0.05F * std::sin(4.0F * time), 0.0F);
    };
    const std::vector<NoHold> table = {
        {"a hand that hangs", {.at = still, .raised = [](float) { return false; }}},
        {"a fist", {.at = still, .state = [](float) { return HandState::closed; }}},
        {"a hand that cannot be read", {.at = still, .state = [](float) { return HandState::unknown; }}},
        {"a hand that may be a fist", {.seconds = 4.0F, .at = still, .confidence = 0.4F}},
        {"too short", {.seconds = 1.1F, .at = still}},
        {"lowered for a moment",
         {.seconds = 2.2F, .at = still, .raised = [](float t) { return t < 1.0F || t > 1.1F; }}},
        {"a slow hand", {.seconds = 4.0F, .at = slowly}},
        {"a hand that goes to and fro", {.seconds = 6.0F, .at = toAndFro}},
        {"nearer and farther",
         {.seconds = 6.0F,
          .at = [&](float t) -> Eigen::Vector3f {
              return {0.2F, 0.0F, 0.15F + 0.05F * std::sin(4.0F * t)};
          }}},
        {"a hand that stays where it has swiped", {.seconds = 8.0F, .at = move(kRightSide, kLeftSide, 0.5F, 0.95F)}},
        {"a hand that stays where it has grabbed",
         {.seconds = 8.0F, .at = still, .state = [](float t) { return closedBetween(t, 0.5F, 1.0F); }}},
        {"walking",
         {.seconds = 4.0F, .at = still, .walk = [](float t) { return Eigen::Vector3f(0.0F, 0.0F, 2.2F - 0.8F * t); }}}};
    for (const NoHold& row : table)
        EXPECT_TRUE(holds(row.script).empty()) << row.name;
}

TEST(Hold, CountsAgainOnlyWhenTheHandWasAwayOrDown) {
    EXPECT_EQ(holds({.seconds = 12.0F, .at = still}).size(), 1U);
    const auto away = [](float size) {
        return [size](float time) -> Eigen::Vector3f {
            const bool there = time > 3.0F && time < 3.6F;
            return kRightSide + Eigen::Vector3f(0.0F, there ? -size : 0.0F, 0.0F);
        };
    };
    EXPECT_EQ(holds({.seconds = 6.0F, .at = away(0.08F)}).size(), 1U) << "not far enough";
    EXPECT_EQ(holds({.seconds = 6.0F, .at = away(0.12F)}).size(), 2U);
    const auto down = [](float seconds) {
        return [seconds](float time) { return time < 3.0F || time > 3.0F + seconds; };
    };
    EXPECT_EQ(holds({.seconds = 6.0F, .at = still, .raised = down(0.2F)}).size(), 1U) << "not long enough";
    EXPECT_EQ(holds({.seconds = 6.0F, .at = still, .raised = down(0.4F)}).size(), 2U);
    // After a swipe, elsewhere.
    EXPECT_EQ(holds({.seconds = 6.0F,
                     .at = [](float time) -> Eigen::Vector3f {
                         if (time < 2.0F) return move(kRightSide, kLeftSide, 0.5F, 0.95F)(time);
                         return move(kLeftSide, kRightSide + Eigen::Vector3f(0.0F, 0.05F, 0.0F), 2.0F, 4.0F)(time);
                     }})
                  .size(),
              1U);
}

TEST(Hold, IsCountedAcrossADroppedFrameButNotAcrossAGap) {
    EXPECT_EQ(holds({.at = still, .dropped = [](float t) { return t > 0.5F && t < 0.8F; }}).size(), 1U);
    EXPECT_TRUE(holds({.at = still, .dropped = [](float t) { return t > 0.5F && t < 1.2F; }}).empty());
}

TEST(Hold, TellsHowFarItIs) {
    std::vector<float> progress;
    play({.seconds = 4.0F, .at = still, .raised = [](float t) { return t < 3.0F; }}, {}, &progress);
    for (std::size_t i = 1; i < progress.size(); ++i) {
        const float time = static_cast<float>(i) * kFrameSeconds;
        const float expected = time < 3.0F ? std::min(1.0F, (time - kFrameSeconds) / GestureOptions{}.holdTime)
                               : time < 3.0F + GestureOptions{}.holdRest ? 1.0F
                                                                         : 0.0F;
        EXPECT_NEAR(progress[i], expected, 0.06F) << time;
    }
}

TEST(Hold, FollowsItsThresholds) {
    GestureOptions options;
    options.holdTime = 3.0F;
    EXPECT_TRUE(holds({.seconds = 2.9F, .at = still}, options).empty());
    EXPECT_EQ(holds({.seconds = 3.3F, .at = still}, options).size(), 1U);
}

// NOLINTEND(clang-analyzer-cplusplus.NewDeleteLeaks)

}  // namespace
}  // namespace cheval::fitting::tracking

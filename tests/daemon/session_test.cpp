#include "daemon/session.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::daemon {
namespace {

using fitting::GestureEvent;
using fitting::GestureKind;
using fitting::SwipeDirection;
using hal::Button;
using hal::ButtonAction;
using hal::ButtonEvent;

constexpr SessionOptions kOptions{.approach = hal::fromSeconds(0.3),
                                  .acquire = hal::fromSeconds(0.3),
                                  .acquireLimit = hal::fromSeconds(2.0),
                                  .leave = hal::fromSeconds(1.0),
                                  .gone = hal::fromSeconds(3.0),
                                  .outfitCount = 3,
                                  .startOutfit = 1};

/// A stretch of time in which the same is seen, ten times a second.
struct Stretch {
    double seconds;
    std::uint32_t userId;
    bool jointsSeen = true;
    bool measured = true;
};

/// Plays stretches and writes down every change of state.
class Player {
  public:
    explicit Player(const SessionOptions& options = kOptions) : session(options), chain_(1, session.state()) {}

    void play(const Stretch& stretch) {
        const int frames = static_cast<int>(std::lround(stretch.seconds * 10.0));
        for (int i = 0; i < frames; ++i)
            frame(stretch.userId, stretch.jointsSeen, stretch.measured);
    }
    void frame(std::uint32_t userId, bool jointsSeen = true, bool measured = true,
               std::span<const ButtonEvent> buttons = {}, std::span<const GestureEvent> gestures = {}) {
        time_ += std::chrono::milliseconds(100);
        session.update({.time = time_,
                        .userId = userId,
                        .jointsSeen = jointsSeen,
                        .measured = measured,
                        .buttons = buttons,
                        .gestures = gestures});
        if (session.state() != chain_.back()) chain_.push_back(session.state());
    }
    void press(Button button, std::uint32_t userId = 1, ButtonAction action = ButtonAction::pressed) {
        const std::array<ButtonEvent, 1> events = {{{.button = button, .action = action, .time = time_}}};
        frame(userId, true, true, events);
    }
    void gesture(GestureKind kind, SwipeDirection direction = SwipeDirection::left) {
        const std::array<GestureEvent, 1> events = {{{.kind = kind, .direction = direction}}};
        frame(1, true, true, {}, events);
    }
    void swipe(SwipeDirection direction) { gesture(GestureKind::swipe, direction); }
    void dress() { play({.seconds = 2.0, .userId = 1}); }
    [[nodiscard]] std::string chain() const {
        std::string text;
        for (const SessionState state : chain_)
            text += (text.empty() ? "" : " ") + std::string(name(state));
        return text;
    }

    Session session;

  private:
    std::vector<SessionState> chain_;
    hal::TimePoint time_{};
};

struct Chain {
    const char* name;
    std::vector<Stretch> stretches;
    const char* chain;
};
void PrintTo(const Chain& chain, std::ostream* stream) {
    *stream << chain.name;
}

class SessionChain : public testing::TestWithParam<Chain> {};

TEST_P(SessionChain, isExactlyThis) {
    Player player;
    for (const Stretch& stretch : GetParam().stretches)
        player.play(stretch);
    EXPECT_EQ(player.chain(), GetParam().chain);
}

INSTANTIATE_TEST_SUITE_P(
    Session, SessionChain,
    testing::Values(
        Chain{"nobody", {{60, 0}}, "idle"},
        Chain{"aWholeVisit", {{1, 0}, {5, 1}, {10, 0}}, "idle approaching acquiring wearing leaving idle"},
        Chain{"walksBy", {{0.2, 1}, {1, 0}}, "idle approaching idle"},
        Chain{"walksByTwice", {{0.2, 1}, {1, 0}, {0.2, 2}, {1, 0}}, "idle approaching idle approaching idle"},
        Chain{"standsButIsNotRecognised", {{10, 1, false}}, "idle approaching acquiring"},
        Chain{"isRecognisedButNotMeasured", {{1.5, 1, true, false}}, "idle approaching acquiring"},
        Chain{"isDressedUnmeasuredAtTheLimit", {{3.0, 1, true, false}}, "idle approaching acquiring wearing"},
        Chain{"jointsFlicker",
              {{0.4, 1}, {0.2, 1, false}, {0.2, 1}, {0.2, 1, false}, {0.2, 1}},
              "idle approaching acquiring"},
        Chain{"goesWhileAcquiring", {{0.5, 1, false}, {2, 0}}, "idle approaching acquiring idle"},
        Chain{"flickersWhileAcquiring", {{0.5, 1, false}, {0.5, 0}, {2, 1}}, "idle approaching acquiring wearing"},
        Chain{"isHiddenForAMoment", {{3, 1}, {0.8, 0}, {3, 1}}, "idle approaching acquiring wearing"},
        Chain{"comesBackInTime", {{3, 1}, {2, 0}, {3, 1}}, "idle approaching acquiring wearing leaving wearing"},
        Chain{"losesJointsWhileWearing", {{3, 1}, {5, 1, false}}, "idle approaching acquiring wearing"},
        Chain{"isLostAndFoundUnderANewNumber",
              {{3, 1}, {0.2, 0}, {3, 2}},
              "idle approaching acquiring wearing acquiring wearing"},
        Chain{"comesBackUnderANewNumber",
              {{3, 1}, {2, 0}, {3, 2}},
              "idle approaching acquiring wearing leaving acquiring wearing"},
        Chain{"anotherVisit",
              {{3, 1}, {6, 0}, {3, 2}},
              "idle approaching acquiring wearing leaving idle approaching acquiring wearing"}),
    [](const testing::TestParamInfo<Chain>& parameter) { return parameter.param.name; });

TEST(Session, dwellsOfZeroPassAtOnce) {
    SessionOptions options = kOptions;
    options.approach = {};
    options.acquire = {};
    Player player(options);
    player.frame(1);
    EXPECT_EQ(player.session.state(), SessionState::acquiring);
    player.frame(1);
    EXPECT_EQ(player.session.state(), SessionState::wearing);
}

TEST(Session, buttonsStepThroughTheOutfitsAndAround) {
    Player player;
    player.dress();
    EXPECT_EQ(player.session.outfit(), 1U);
    player.press(Button::next);
    EXPECT_EQ(player.session.outfit(), 2U);
    player.press(Button::next);
    EXPECT_EQ(player.session.outfit(), 0U);
    player.press(Button::previous);
    EXPECT_EQ(player.session.outfit(), 2U);
    player.press(Button::next, 1, ButtonAction::released);
    player.press(Button::next, 1, ButtonAction::longPressed);
    EXPECT_EQ(player.session.outfit(), 2U);
}

TEST(Session, aButtonWorksEvenWhenNobodyIsSeen) {
    Player player;
    player.press(Button::next, 0);
    EXPECT_EQ(player.session.outfit(), 2U);
    player.dress();
    EXPECT_EQ(player.session.outfit(), 2U);
}

TEST(Session, aSwipeMovesTheCarouselWithTheHand) {
    Player player;
    player.dress();
    player.swipe(SwipeDirection::left);
    EXPECT_EQ(player.session.outfit(), 2U);
    player.swipe(SwipeDirection::right);
    EXPECT_EQ(player.session.outfit(), 1U);
}

TEST(Session, aSwipeCanMeanAnArrow) {
    SessionOptions options = kOptions;
    options.swipeLeftIsNext = false;
    Player player(options);
    player.dress();
    player.swipe(SwipeDirection::left);
    EXPECT_EQ(player.session.outfit(), 0U);
}

TEST(Session, onlySwipesOfTheDressedCount) {
    Player player;
    for (int i = 0; i < 5; ++i)
        player.swipe(SwipeDirection::left);
    ASSERT_NE(player.session.state(), SessionState::wearing);
    EXPECT_EQ(player.session.outfit(), 1U);
    player.dress();
    player.gesture(GestureKind::grab);
    player.gesture(GestureKind::raise);
    player.gesture(GestureKind::hold);
    EXPECT_EQ(player.session.outfit(), 1U);
}

TEST(Session, aHoldIsTheViewButtonOfTheDressed) {
    Player player;
    for (int i = 0; i < 5; ++i)
        player.gesture(GestureKind::hold);
    ASSERT_NE(player.session.state(), SessionState::wearing);
    EXPECT_FALSE(player.session.avatarView()) << "whoever walks in chooses nothing";
    player.dress();
    player.gesture(GestureKind::hold);
    EXPECT_TRUE(player.session.avatarView());
    EXPECT_EQ(player.session.outfit(), 1U);
    player.press(Button::view);
    EXPECT_FALSE(player.session.avatarView()) << "the button and the hand change one and the same view";
    player.gesture(GestureKind::hold);
    player.gesture(GestureKind::hold);
    EXPECT_FALSE(player.session.avatarView());
    player.gesture(GestureKind::hold);
    player.play({.seconds = 6.0, .userId = 0});
    EXPECT_FALSE(player.session.avatarView()) << "the next visit starts as the first did";
}

TEST(Session, aHoldCanMeanNothing) {
    SessionOptions options = kOptions;
    options.holdChangesView = false;
    Player player(options);
    player.dress();
    player.gesture(GestureKind::hold);
    EXPECT_FALSE(player.session.avatarView());
}

TEST(Session, theViewButtonTogglesAndTheNextVisitStartsAfresh) {
    Player player;
    player.dress();
    player.press(Button::view);
    player.press(Button::next);
    EXPECT_TRUE(player.session.avatarView());
    player.play({.seconds = 6.0, .userId = 0});
    EXPECT_EQ(player.session.state(), SessionState::idle);
    EXPECT_FALSE(player.session.avatarView());
    EXPECT_EQ(player.session.outfit(), 1U);
}

TEST(Session, theChoiceSurvivesBeingLostAndFound) {
    Player player;
    player.dress();
    player.press(Button::next);
    player.play({.seconds = 2.0, .userId = 0});
    ASSERT_EQ(player.session.state(), SessionState::leaving);
    player.play({.seconds = 2.0, .userId = 7});
    EXPECT_EQ(player.session.state(), SessionState::wearing);
    EXPECT_EQ(player.session.outfit(), 2U);
    EXPECT_EQ(player.session.visits(), 1U);
}

TEST(Session, countsVisits) {
    Player player;
    for (std::uint32_t user = 1; user <= 3; ++user) {
        player.play({.seconds = 3.0, .userId = user});
        player.play({.seconds = 6.0, .userId = 0});
    }
    EXPECT_EQ(player.session.visits(), 3U);
}

TEST(Session, theServiceButtonTogglesItsScreenAndWakeLeavesIt) {
    Player player;
    player.press(Button::service, 0);
    EXPECT_TRUE(player.session.serviceScreen());
    player.press(Button::service, 0);
    EXPECT_FALSE(player.session.serviceScreen());
    player.press(Button::service, 0);
    player.press(Button::wake, 0);
    EXPECT_FALSE(player.session.serviceScreen());
}

TEST(Session, resetStartsFromNothingEvenWhenTimeStartsAgain) {
    Player player;
    player.dress();
    player.session.reset();
    EXPECT_EQ(player.session.state(), SessionState::idle);
    Session& session = player.session;
    for (int i = 0; i < 20; ++i)
        session.update({.time = hal::TimePoint(std::chrono::milliseconds(100 * i)),
                        .userId = 1,
                        .jointsSeen = true,
                        .measured = true});
    EXPECT_EQ(session.state(), SessionState::wearing);
}

TEST(Session, timeThatRunsBackwardsCountsAsNone) {
    Session session(kOptions);
    session.update(
        {.time = hal::TimePoint(std::chrono::seconds(100)), .userId = 1, .jointsSeen = true, .measured = true});
    session.update(
        {.time = hal::TimePoint(std::chrono::seconds(1)), .userId = 1, .jointsSeen = true, .measured = true});
    EXPECT_EQ(session.state(), SessionState::approaching);
}

TEST(Session, withoutOutfitsNothingIsChosen) {
    SessionOptions options = kOptions;
    options.outfitCount = 0;
    Player player(options);
    player.dress();
    player.press(Button::next);
    EXPECT_EQ(player.session.outfit(), 0U);
}

TEST(Session, wishesOfOtherProgramsWorkAtAnyTimeInTheirOrder) {
    using Kind = RemoteCommand::Kind;
    Session session(kOptions);
    const auto wish = [&session](std::span<const RemoteCommand> commands) {
        session.update({.time = hal::TimePoint(std::chrono::seconds(1)), .commands = commands});
    };
    EXPECT_EQ(session.outfit(), 1U);
    wish(std::array<RemoteCommand, 2>{{{.kind = Kind::choose, .outfit = 0}, {.kind = Kind::next}}});
    EXPECT_EQ(session.outfit(), 1U);
    wish(std::array<RemoteCommand, 2>{{{.kind = Kind::next}, {.kind = Kind::choose, .outfit = 0}}});
    EXPECT_EQ(session.outfit(), 0U);
    wish(std::array<RemoteCommand, 1>{{{.kind = Kind::previous}}});
    EXPECT_EQ(session.outfit(), 2U);
    wish(std::array<RemoteCommand, 1>{{{.kind = Kind::choose, .outfit = 3}}});
    EXPECT_EQ(session.outfit(), 2U) << "there is no such outfit";
    wish(std::array<RemoteCommand, 2>{{{.kind = Kind::avatarView}, {.kind = Kind::avatarView}}});
    EXPECT_TRUE(session.avatarView()) << "asked for twice is not taken back";
    wish(std::array<RemoteCommand, 1>{{{.kind = Kind::mirrorView}}});
    EXPECT_FALSE(session.avatarView());
}

TEST(Session, takesNoMemory) {
    Session session(kOptions);
    const std::array<ButtonEvent, 1> buttons = {{{.button = Button::next}}};
    const test::AllocationCounter counter;
    for (int i = 0; i < 1000; ++i) {
        session.update({.time = hal::TimePoint(std::chrono::milliseconds(33 * i)),
                        .userId = i % 300 < 200 ? 1U : 0U,
                        .jointsSeen = true,
                        .measured = true,
                        .buttons = buttons});
    }
    EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace cheval::daemon

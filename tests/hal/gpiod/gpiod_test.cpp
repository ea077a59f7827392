#include <array>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/gpiod/gpiod_buttons.h"
#include "hal/gpiod/power_line.h"
#include "tests/hal/gpiod/fake_lines.h"

namespace cheval::hal {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::FakeChip;
using test::FakeLines;

class GpiodButtonsTest : public testing::Test {
  protected:
    void SetUp() override {
        buttons_ = makeGpiodButtons({.wirings = {{.button = Button::next, .line = {.line = "NEXT"}},
                                                 {.button = Button::service, .line = {.line = "SERVICE"}}}},
                                    std::make_unique<FakeLines>(chip_, clock_), clock_);
    }
    /// Polls now; the events as "next+", "next-", "next!" (a long press) with their times in milliseconds.
    std::string poll() {
        std::array<ButtonEvent, 16> events;
        std::string text;
        while (true) {
            const Expected<std::size_t> count = buttons_->poll(events);
            fault_ = count ? "" : count.error().message();
            if (!count || *count == 0) return text;
            for (std::size_t i = 0; i < *count; ++i) {
                if (!text.empty()) text += ' ';
                text += events.at(i).button == Button::next ? "next" : "service";
                text += events.at(i).action == ButtonAction::pressed    ? '+'
                        : events.at(i).action == ButtonAction::released ? '-'
                                                                        : '!';
                text += std::to_string(
                    std::chrono::duration_cast<milliseconds>(events.at(i).time.time_since_epoch()).count());
            }
        }
    }
    std::string pollAt(int time) {
        clock_.advance(TimePoint(milliseconds(time)) - clock_.now());
        return poll();
    }
    void edge(const char* line, bool active, int time) { chip_->edge(line, active, TimePoint(milliseconds(time))); }

    VirtualClock clock_;
    std::shared_ptr<FakeChip> chip_ = std::make_shared<FakeChip>();
    std::unique_ptr<GpiodButtons> buttons_;
    std::string fault_;
};

TEST_F(GpiodButtonsTest, aPressIsToldWithTheTimeOfItsEdge) {
    EXPECT_EQ(poll(), "");
    edge("NEXT", true, 100);
    EXPECT_EQ(pollAt(110), "") << "it may be bounce yet";
    EXPECT_EQ(pollAt(121), "next+100");
    edge("NEXT", false, 300);
    EXPECT_EQ(pollAt(333), "next-300");
}

TEST_F(GpiodButtonsTest, bounceIsNoPress) {
    poll();
    for (int i = 0; i < 20; ++i)
        edge("NEXT", i % 2 == 0, 100 + i);
    EXPECT_EQ(pollAt(133), "");
    edge("NEXT", true, 200);
    for (int i = 1; i < 11; ++i)
        edge("NEXT", i % 2 == 0, 200 + i);
    EXPECT_EQ(pollAt(260), "next+210") << "from when it rested";
}

TEST_F(GpiodButtonsTest, aPressBetweenTwoPollsIsNotLost) {
    poll();
    edge("NEXT", true, 100);
    edge("NEXT", false, 160);
    EXPECT_EQ(pollAt(500), "next+100 next-160");
}

TEST_F(GpiodButtonsTest, theOrderIsThatOfTheTimesWhateverTheLine) {
    poll();
    edge("SERVICE", true, 100);
    edge("NEXT", true, 150);
    edge("SERVICE", false, 200);
    edge("NEXT", false, 250);
    EXPECT_EQ(pollAt(500), "service+100 next+150 service-200 next-250");
}

TEST_F(GpiodButtonsTest, heldLongIsALongPressOnce) {
    poll();
    edge("NEXT", true, 100);
    EXPECT_EQ(pollAt(500), "next+100");
    EXPECT_EQ(pollAt(950), "next!900");
    EXPECT_EQ(pollAt(2000), "");
    edge("NEXT", false, 2100);
    EXPECT_EQ(pollAt(2200), "next-2100");
    // The same, all between two polls.
    edge("NEXT", true, 3000);
    edge("NEXT", false, 4000);
    EXPECT_EQ(pollAt(5000), "next+3000 next!3800 next-4000");
}

TEST_F(GpiodButtonsTest, aStuckButtonIsToldAndTheOthersWorkOn) {
    poll();
    edge("NEXT", true, 100);
    pollAt(1000);
    EXPECT_FALSE(buttons_->stuck(Button::next));
    pollAt(40'000);
    EXPECT_TRUE(buttons_->stuck(Button::next));
    EXPECT_THAT(fault_, testing::HasSubstr("next is stuck"));
    EXPECT_THAT(fault_, testing::HasSubstr("Mend"));
    edge("SERVICE", true, 40'100);
    EXPECT_EQ(pollAt(40'200), "service+40100");
    edge("NEXT", false, 41'000);
    EXPECT_EQ(pollAt(41'100), "service!40900 next-41000");
    EXPECT_FALSE(buttons_->stuck(Button::next));
    EXPECT_EQ(pollAt(41'200), "");
    EXPECT_EQ(fault_, "");
}

TEST_F(GpiodButtonsTest, aStuckButtonWhoseLineIsLostIsNoLongerCalledStuck) {
    poll();
    edge("NEXT", true, 100);
    pollAt(40'000);
    ASSERT_TRUE(buttons_->stuck(Button::next));
    chip_->gone = true;
    chip_->fault = "there is no such chip";
    EXPECT_EQ(pollAt(40'100), "next-40100");
    EXPECT_FALSE(buttons_->stuck(Button::next));
    EXPECT_THAT(fault_, testing::Not(testing::HasSubstr("stuck")));
}

TEST_F(GpiodButtonsTest, heldFromBeforeTheStartIsNoPressAndMayBeStuck) {
    chip_->levels["NEXT"] = true;
    EXPECT_EQ(poll(), "");
    EXPECT_EQ(pollAt(5000), "");
    EXPECT_EQ(pollAt(31'000), "");
    EXPECT_TRUE(buttons_->stuck(Button::next));
    edge("NEXT", false, 32'000);
    EXPECT_EQ(pollAt(32'100), "") << "a release of what was never pressed";
    edge("NEXT", true, 33'000);
    EXPECT_EQ(pollAt(33'100), "next+33000");
}

TEST_F(GpiodButtonsTest, anAbsentChipIsAskedForAgainWithGrowingPauses) {
    chip_->fault = "there is no such chip";
    std::vector<std::int64_t> asked;
    for (int time = 0; time < 120'000; time += 33) {
        const int before = chip_->requests;
        pollAt(time);
        EXPECT_THAT(fault_, testing::HasSubstr("there is no such chip"));
        if (chip_->requests != before) asked.push_back(time);
    }
    EXPECT_LE(asked.size(), 10U);
    EXPECT_GE(asked.size(), 8U);
    EXPECT_EQ(chip_->held, 0);
    chip_->fault.clear();
    pollAt(160'000);
    EXPECT_EQ(fault_, "");
    EXPECT_EQ(chip_->held, 2);
}

TEST_F(GpiodButtonsTest, aBusyLineNamesItsButton) {
    chip_->fault = "the GPIO line \"NEXT\" is held by \"gpiomon\"";
    poll();
    EXPECT_THAT(fault_, testing::HasSubstr("button next"));
    EXPECT_THAT(fault_, testing::HasSubstr("gpiomon"));
}

TEST_F(GpiodButtonsTest, aChipThatVanishesAndReturnsIsTakenUpAgain) {
    poll();
    edge("NEXT", true, 100);
    EXPECT_EQ(pollAt(200), "next+100");
    chip_->gone = true;
    chip_->fault = "there is no such chip";
    EXPECT_EQ(pollAt(300), "next-300") << "what was told as pressed is told as released";
    EXPECT_THAT(fault_, testing::HasSubstr("button next"));
    EXPECT_THAT(fault_, testing::HasSubstr("gone"));
    EXPECT_EQ(chip_->held, 0);
    EXPECT_EQ(pollAt(1000), "") << "once, however often it is asked for in vain";
    EXPECT_THAT(fault_, testing::HasSubstr("there is no such chip"));
    chip_->fault.clear();
    chip_->levels["NEXT"] = false;
    pollAt(5000);
    EXPECT_EQ(fault_, "");
    edge("NEXT", true, 6000);
    EXPECT_EQ(pollAt(6100), "next+6000");
}

TEST_F(GpiodButtonsTest, aReleaseThatTheKernelHadNoRoomForLeavesNoButtonPressed) {
    chip_->room = 16;
    poll();
    for (int i = 0; i < 17; ++i)
        edge("NEXT", i % 2 == 1, 100 + i);
    EXPECT_EQ(pollAt(120), "");
    EXPECT_EQ(pollAt(1200), "") << "nobody holds it";
    edge("NEXT", true, 2000);
    EXPECT_EQ(pollAt(2100), "next+2000");
}

TEST_F(GpiodButtonsTest, aPressThatTheKernelHadNoRoomForIsToldFromWhenItIsSeen) {
    chip_->room = 16;
    poll();
    for (int i = 0; i < 17; ++i)
        edge("NEXT", i % 2 == 0, 100 + i);
    EXPECT_EQ(pollAt(120), "");
    EXPECT_EQ(pollAt(150), "next+120");
}

TEST_F(GpiodButtonsTest, whatIsToldLaterIsNotOlder) {
    poll();
    edge("SERVICE", true, 100);
    EXPECT_EQ(pollAt(200), "service+100");
    edge("NEXT", true, 895);
    EXPECT_EQ(pollAt(910), "service!900") << "the other may be bounce yet";
    EXPECT_EQ(pollAt(920), "next+900");
    EXPECT_EQ(pollAt(930), "");
}

TEST_F(GpiodButtonsTest, theLineThatIsRefusedCostsNoOther) {
    chip_->faults["NEXT"] = "held by gpiomon";
    poll();
    EXPECT_THAT(fault_, testing::HasSubstr("button next"));
    EXPECT_EQ(chip_->held, 1);
    edge("SERVICE", true, 100);
    EXPECT_EQ(pollAt(200), "service+100");
    EXPECT_THAT(fault_, testing::HasSubstr("held by gpiomon")) << "it is still so";
    chip_->faults.clear();
    edge("SERVICE", false, 300);
    EXPECT_EQ(pollAt(1000), "service-300") << "nothing is lost while the other is taken up";
    EXPECT_EQ(fault_, "");
    EXPECT_EQ(chip_->held, 2);
}

TEST_F(GpiodButtonsTest, anyEdgesGivePressesAndReleasesInTurnAndInOrder) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        std::mt19937 random(seed);
        VirtualClock clock;
        auto chip = std::make_shared<FakeChip>();
        const ButtonTimes times{};
        const auto buttons =
            makeGpiodButtons({.wirings = {{.button = Button::next, .line = {.line = "NEXT"}}}, .times = times},
                             std::make_unique<FakeLines>(chip, clock), clock);
        std::array<ButtonEvent, 16> events;
        ASSERT_TRUE(buttons->poll(events));
        TimePoint edgeTime{};
        TimePoint last{};
        TimePoint pressedAt{};
        bool pressed = false;
        bool longPressed = false;
        for (int turn = 0; turn < 300; ++turn) {
            clock.advance(milliseconds(1 + random() % 60));
            while (edgeTime + milliseconds(40) < clock.now()) {
                edgeTime += std::chrono::microseconds(1 + random() % (random() % 3 == 0 ? 40'000 : 3'000));
                chip->edge("NEXT", random() % 2 == 0, std::min(edgeTime, clock.now()));
            }
            const Expected<std::size_t> count = buttons->poll(events);
            if (!count) continue;
            for (std::size_t i = 0; i < *count; ++i) {
                const ButtonEvent& event = events.at(i);
                ASSERT_GE(event.time, last);
                if (event.action == ButtonAction::longPressed) {
                    ASSERT_TRUE(pressed && !longPressed);
                    longPressed = true;
                } else {
                    ASSERT_EQ(event.action == ButtonAction::pressed, !pressed);
                    // Between a press and its release lies at least the debounce.
                    if (pressed) {
                        ASSERT_GE(event.time - pressedAt, times.debounce);
                    }
                    pressed = !pressed;
                    pressedAt = event.time;
                    longPressed = false;
                }
                last = event.time;
            }
        }
    }
}

TEST_F(GpiodButtonsTest, anyEdgesOfSeveralLinesOnAChipThatComesAndGoesAreToldInTurnAndInOrder) {
    constexpr std::array<const char*, 2> kNames = {"NEXT", "SERVICE"};
    std::size_t told = 0;
    for (unsigned seed = 0; seed < 200; ++seed) {
        std::mt19937 random(seed);
        VirtualClock clock;
        auto chip = std::make_shared<FakeChip>();
        chip->room = 16;
        const auto buttons = makeGpiodButtons({.wirings = {{.button = Button::next, .line = {.line = "NEXT"}},
                                                           {.button = Button::service, .line = {.line = "SERVICE"}}}},
                                              std::make_unique<FakeLines>(chip, clock), clock);
        std::array<ButtonEvent, 3> events;
        std::array<bool, 2> pressed{};
        TimePoint last{};
        for (int turn = 0; turn < 600; ++turn) {
            clock.advance(milliseconds(1 + random() % 60));
            if (random() % 100 == 0) chip->gone = true;
            for (const char* name : kNames) {
                const std::size_t count = random() % 4 == 0 ? random() % 24 : 0;
                for (std::size_t i = 0; i < count; ++i)
                    chip->edge(name, random() % 2 == 0, clock.now() - std::chrono::microseconds((count - i) * 40));
            }
            const Expected<std::size_t> count = buttons->poll(events);
            if (!count) continue;
            for (std::size_t i = 0; i < *count; ++i) {
                const ButtonEvent& event = events.at(i);
                ASSERT_GE(event.time, last) << "seed " << seed << ", turn " << turn;
                ASSERT_LE(event.time, clock.now());
                bool& held = pressed.at(event.button == Button::next ? 0 : 1);
                ASSERT_EQ(event.action != ButtonAction::pressed, held) << "seed " << seed << ", turn " << turn;
                held = event.action != ButtonAction::released;
                last = event.time;
                ++told;
            }
        }
        // Left alone, each button is in the end what its line is.
        chip->gone = false;
        for (int turn = 0; turn < 100; ++turn) {
            clock.advance(seconds(1));
            const Expected<std::size_t> count = buttons->poll(events);
            for (std::size_t i = 0; count && i < *count; ++i)
                pressed.at(events.at(i).button == Button::next ? 0 : 1) = events.at(i).action != ButtonAction::released;
        }
        for (std::size_t i = 0; i < kNames.size(); ++i)
            ASSERT_TRUE(chip->levels[kNames.at(i)] || !pressed.at(i)) << kNames.at(i) << ", seed " << seed;
        EXPECT_EQ(buttons->dropped(), 0U);
    }
    EXPECT_GT(told, 1000U);
}

TEST(GpiodLines, anAbsentChipAndAnUnknownNameAreRefusedWithWords) {
    const auto lines = makeGpiodLines();
    for (const LineWiring& wiring :
         {LineWiring{.chip = "no-such-chip", .line = "3"}, LineWiring{.line = "NO_SUCH_LINE_ANYWHERE"}}) {
        const auto refused = lines->input(wiring);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::notFound);
        EXPECT_THAT(refused.error().cause, testing::HasSubstr(wiring.line));
        EXPECT_THAT(refused.error().mend, testing::HasSubstr("gpioinfo"));
        EXPECT_FALSE(lines->output(wiring, true));
    }
}

class PowerLineTest : public testing::Test {
  protected:
    std::vector<bool> levels() {
        std::vector<bool> all;
        for (const auto& [time, level] : chip_->driven["POWER"])
            all.push_back(level);
        return all;
    }
    VirtualClock clock_;
    std::shared_ptr<FakeChip> chip_ = std::make_shared<FakeChip>();
    std::unique_ptr<PowerLine> power_ =
        std::make_unique<PowerLine>(PowerLineOptions{.line = {.line = "POWER"}, .off = seconds(3)},
                                    std::make_unique<FakeLines>(chip_, clock_), clock_);
};

TEST_F(PowerLineTest, switchesOffForItsTimeAndOnAgainWithoutWaiting) {
    ASSERT_TRUE(power_->hold());
    EXPECT_EQ(levels(), (std::vector<bool>{true}));
    Expected<void> cycled = power_->cycle();
    int calls = 0;
    const TimePoint start = clock_.now();
    while (!cycled && cycled.error().code == ErrorCode::timedOut) {
        clock_.advance(milliseconds(100));
        cycled = power_->cycle();
        ++calls;
    }
    EXPECT_TRUE(cycled);
    EXPECT_EQ(clock_.now() - start, seconds(3));
    EXPECT_EQ(levels(), (std::vector<bool>{true, false, true}));
    EXPECT_EQ(calls, 30);
}

TEST_F(PowerLineTest, aMirrorThatEndsInTheMiddleLeavesThePowerOn) {
    ASSERT_FALSE(power_->cycle());
    power_.reset();
    EXPECT_EQ(levels(), (std::vector<bool>{true, false, true}));
}

TEST_F(PowerLineTest, aLineThatIsNotThereSaysWhoseItIs) {
    chip_->fault = "there is no such line";
    const Expected<void> held = power_->hold();
    ASSERT_FALSE(held);
    EXPECT_THAT(held.error().cause, testing::HasSubstr("the sensor's power"));
    chip_->fault.clear();
    EXPECT_TRUE(power_->hold());
}

}  // namespace
}  // namespace cheval::hal

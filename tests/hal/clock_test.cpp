#include "hal/clock.h"

#include <thread>

#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

using namespace std::chrono_literals;

TEST(VirtualClockTest, WaitingMovesTimeToTheDeadlineAtOnce) {
    VirtualClock clock;
    Interrupt interrupt;
    EXPECT_TRUE(clock.waitUntil(TimePoint(24h), interrupt));
    EXPECT_EQ(clock.now(), TimePoint(24h));
}

TEST(VirtualClockTest, TimeNeverRunsBackwards) {
    VirtualClock clock;
    Interrupt interrupt;
    clock.advance(10s);
    EXPECT_TRUE(clock.waitUntil(TimePoint(5s), interrupt));
    EXPECT_EQ(clock.now(), TimePoint(10s));
}

TEST(VirtualClockTest, ARaisedInterruptEndsTheWaitAndTimeStands) {
    VirtualClock clock;
    Interrupt interrupt;
    interrupt.raise();
    EXPECT_FALSE(clock.waitUntil(TimePoint(5s), interrupt));
    EXPECT_EQ(clock.now(), TimePoint{});
    interrupt.clear();
    EXPECT_TRUE(clock.waitUntil(TimePoint(5s), interrupt));
}

TEST(SteadyClockTest, AnInterruptFromAnotherThreadEndsTheWait) {
    SteadyClock clock;
    Interrupt interrupt;
    std::thread other([&] { interrupt.raise(); });
    EXPECT_FALSE(clock.waitUntil(clock.now() + 1h, interrupt));
    other.join();
}

TEST(SteadyClockTest, ADeadlineInThePastIsReachedAtOnce) {
    SteadyClock clock;
    Interrupt interrupt;
    EXPECT_TRUE(clock.waitUntil(clock.now() - 1s, interrupt));
}

}  // namespace
}  // namespace cheval::hal

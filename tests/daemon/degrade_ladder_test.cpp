#include "daemon/degrade_ladder.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::daemon {
namespace {

/// Feeds one load for some frames and returns the levels passed through.
std::vector<std::size_t> feed(DegradeLadder& ladder, double load, int frames) {
    std::vector<std::size_t> levels;
    for (int i = 0; i < frames; ++i) {
        if (ladder.update(load)) levels.push_back(ladder.level());
    }
    return levels;
}

constexpr LadderOptions kEverything{.haveCloth = true, .haveLevelsOfDetail = true};

TEST(DegradeLadder, stepsDownInTheAgreedOrderWhileFramesAreLate) {
    DegradeLadder ladder(kEverything);
    EXPECT_EQ(feed(ladder, 1.5, 200), (std::vector<std::size_t>{1, 2, 3, 4, 5, 6}));
    EXPECT_DOUBLE_EQ(ladder.rung().rateShare, 0.5);
}

TEST(DegradeLadder, eachRungIsNoDearerThanTheOneAbove) {
    const auto rungs = DegradeLadder::rungs();
    for (std::size_t i = 1; i < rungs.size(); ++i) {
        EXPECT_LE(rungs[i].clothIterations, rungs[i - 1].clothIterations);
        EXPECT_LE(rungs[i].renderScale, rungs[i - 1].renderScale);
        EXPECT_GE(rungs[i].levelOfDetail, rungs[i - 1].levelOfDetail);
        EXPECT_LE(rungs[i].rateShare, rungs[i - 1].rateShare);
    }
}

TEST(DegradeLadder, stepsOverRungsThatWouldChangeNothing) {
    DegradeLadder ladder({});
    EXPECT_EQ(feed(ladder, 1.5, 200), (std::vector<std::size_t>{2, 3, 5, 6}));
    // At half the rate a light load fills the long period even less; back by the same rungs.
    std::vector<std::size_t> up = feed(ladder, 0.2, 4000);
    EXPECT_EQ(up, (std::vector<std::size_t>{5, 3, 2, 0}));
}

TEST(DegradeLadder, ignoresASingleHitch) {
    DegradeLadder ladder({});
    for (int i = 0; i < 1000; ++i) {
        EXPECT_FALSE(ladder.update(5.0));
        for (int j = 0; j < 3; ++j)
            EXPECT_FALSE(ladder.update(0.5));
    }
    EXPECT_EQ(ladder.level(), 0U);
}

TEST(DegradeLadder, staysWhereItIsWhenTheLoadIsBetweenBothBounds) {
    DegradeLadder ladder({});
    feed(ladder, 1.5, 10);
    ASSERT_EQ(ladder.level(), 2U);
    EXPECT_TRUE(feed(ladder, 0.9, 10'000).empty());
}

TEST(DegradeLadder, predictsTheLoadOfAFasterRateBeforeSteppingUp) {
    DegradeLadder ladder({});
    feed(ladder, 1.5, 40);
    ASSERT_EQ(ladder.level(), 6U);
    // 0.6 of a period of 66 ms is 0.8 of one of 50 ms: no room.
    EXPECT_TRUE(feed(ladder, 0.6, 1000).empty());
    // 0.5 is 0.67 there: room.
    EXPECT_EQ(feed(ladder, 0.5, 95), (std::vector<std::size_t>{5}));
}

TEST(DegradeLadder, waitsLongerAfterAStepUpThatDidNotHold) {
    DegradeLadder ladder({});
    feed(ladder, 1.5, 10);
    int previous = 0;
    for (int round = 0; round < 4; ++round) {
        int frames = 0;
        while (!ladder.update(0.5))
            ++frames;
        EXPECT_GT(frames, previous * 3 / 2);
        previous = frames;
        while (!ladder.update(1.5)) {
        }
    }
    EXPECT_GE(previous, 700);
}

TEST(DegradeLadder, neverMovesWhenSwitchedOff) {
    DegradeLadder ladder({.enabled = false});
    EXPECT_TRUE(feed(ladder, 10.0, 1000).empty());
}

TEST(DegradeLadder, takesNoMemory) {
    DegradeLadder ladder(kEverything);
    const test::AllocationCounter counter;
    for (int i = 0; i < 2000; ++i)
        ladder.update(i < 1000 ? 2.0 : 0.1);
    EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace cheval::daemon

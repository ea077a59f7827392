#include "daemon/scheduler.h"

#include <array>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::daemon {
namespace {

using std::chrono::milliseconds;

/// Tasks that take what a script says, on virtual clocks.
struct Scripted {
    hal::VirtualClock time;
    std::array<hal::Duration, 4> cost{};
    bool wanted = true;
    std::string ran;  ///< One letter a task.

    template <std::size_t Index>
    static void work(void* context) {
        auto& self = *static_cast<Scripted*>(context);
        self.ran += static_cast<char>('a' + Index);
        self.time.advance(self.cost[Index]);
    }
    static bool isWanted(const void* context) { return static_cast<const Scripted*>(context)->wanted; }
};

constexpr std::array<Task, 4> kTable = {{
    {.name = "first", .budget = milliseconds(10), .priority = 1, .skip = SkipPolicy::never, .work = &Scripted::work<0>},
    {.name = "second",
     .budget = milliseconds(10),
     .priority = 2,
     .skip = SkipPolicy::whenLate,
     .work = &Scripted::work<1>},
    {.name = "small",
     .budget = milliseconds(2),
     .priority = 3,
     .skip = SkipPolicy::whenLate,
     .work = &Scripted::work<2>},
    {.name = "last", .budget = milliseconds(5), .priority = 4, .skip = SkipPolicy::never, .work = &Scripted::work<3>},
}};

struct Case {
    const char* name;
    std::array<int, 4> costMs;
    int lateMs;  ///< The frame is this old when it is begun.
    const char* ran;
    std::array<std::uint64_t, 4> skips;
    std::array<std::uint64_t, 4> overruns;
};
void PrintTo(const Case& scripted, std::ostream* stream) {
    *stream << scripted.name;
}

class Admission : public testing::TestWithParam<Case> {};

TEST_P(Admission, runsWhatFitsAndCountsTheRest) {
    const Case& scripted = GetParam();
    Scripted script;
    Expected<Scheduler> scheduler = Scheduler::create(kTable, {}, script.time, script.time);
    ASSERT_TRUE(scheduler);
    for (std::size_t i = 0; i < 4; ++i)
        script.cost[i] = milliseconds(scripted.costMs[i]);
    const hal::TimePoint started = script.time.now();
    script.time.advance(milliseconds(scripted.lateMs));
    scheduler->runFrame(started, &script);
    EXPECT_EQ(script.ran, scripted.ran);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(scheduler->statistics(i).skips, scripted.skips[i]) << i;
        EXPECT_EQ(scheduler->statistics(i).overruns, scripted.overruns[i]) << i;
    }
}

// The period is 33.3 ms; second needs 10 + 5 for last, small needs 2 + 5.
INSTANTIATE_TEST_SUITE_P(
    Scheduler, Admission,
    testing::Values(Case{"inTime", {9, 9, 1, 4}, 0, "abcd", {0, 0, 0, 0}, {0, 0, 0, 0}},
                    Case{"justInTime", {18, 10, 2, 5}, 0, "abd", {0, 0, 1, 0}, {1, 0, 0, 0}},
                    Case{"overrunOfTheFirst", {20, 9, 1, 4}, 0, "acd", {0, 1, 0, 0}, {1, 0, 0, 0}},
                    Case{"onlyTheSmallFits", {9, 9, 1, 4}, 12, "acd", {0, 1, 0, 0}, {0, 0, 0, 0}},
                    Case{"nothingFitsButNeverMeansNever", {30, 9, 1, 9}, 0, "ad", {0, 1, 1, 0}, {1, 0, 0, 1}},
                    Case{"lateFromTheStart", {9, 9, 1, 4}, 100, "ad", {0, 1, 1, 0}, {0, 0, 0, 0}},
                    Case{"overrunOfTheSecondCostsTheSmall", {9, 19, 1, 4}, 0, "abd", {0, 0, 1, 0}, {0, 1, 0, 0}}),
    [](const testing::TestParamInfo<Case>& parameter) { return parameter.param.name; });

TEST(Scheduler, shedsNothingWhenTheAdmissionClockStandsStill) {
    hal::VirtualClock admission;
    Scripted script;
    script.cost = {milliseconds(500), milliseconds(500), milliseconds(500), milliseconds(500)};
    Expected<Scheduler> scheduler = Scheduler::create(kTable, {}, admission, script.time);
    ASSERT_TRUE(scheduler);
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(scheduler->runFrame(admission.now(), &script), milliseconds(2000));
    EXPECT_EQ(script.ran, "abcdabcdabcd");
    EXPECT_EQ(scheduler->statistics(1).skips, 0U);
    EXPECT_EQ(scheduler->statistics(1).overruns, 3U);
    EXPECT_EQ(scheduler->frameStatistics().overruns, 3U);
}

TEST(Scheduler, scalesBudgetsWithTheFramePeriodAndTheScale) {
    Scripted script;
    Expected<Scheduler> scheduler =
        Scheduler::create(kTable, {.framePeriod = milliseconds(50), .budgetScale = 2.0}, script.time, script.time);
    ASSERT_TRUE(scheduler);
    EXPECT_NEAR(hal::seconds(scheduler->statistics(0).budget), 0.030, 1e-6);
    scheduler->setFramePeriod(kReferencePeriod);
    EXPECT_NEAR(hal::seconds(scheduler->statistics(0).budget), 0.020, 1e-6);
    // What fits must follow: 18 ms of 33.3 would put `second` off at scale 1 (10 + 5 of 15.3), at 50 ms it fits.
    Expected<Scheduler> slow = Scheduler::create(kTable, {.framePeriod = milliseconds(66)}, script.time, script.time);
    ASSERT_TRUE(slow);
    script.cost = {milliseconds(30), milliseconds(1), milliseconds(1), milliseconds(1)};
    slow->runFrame(script.time.now(), &script);
    EXPECT_EQ(script.ran, "abcd");
}

TEST(Scheduler, runsSlowTasksAtTheirRateAndLateOnesAgainTheNextFrame) {
    constexpr std::array<Task, 2> kSlow = {{
        {.name = "each", .budget = milliseconds(1), .priority = 1, .work = &Scripted::work<0>},
        {.name = "tenth",
         .rateHz = 10.0,
         .budget = milliseconds(5),
         .priority = 2,
         .skip = SkipPolicy::whenLate,
         .work = &Scripted::work<1>},
    }};
    Scripted script;
    Expected<Scheduler> scheduler = Scheduler::create(kSlow, {}, script.time, script.time);
    ASSERT_TRUE(scheduler);
    for (int i = 0; i < 7; ++i)
        scheduler->runFrame(script.time.now(), &script);
    EXPECT_EQ(script.ran, "abaaabaaab");
    script.ran.clear();
    script.cost[0] = milliseconds(30);
    for (int i = 0; i < 4; ++i)
        scheduler->runFrame(script.time.now(), &script);
    EXPECT_EQ(script.ran, "aaaa");
    EXPECT_EQ(scheduler->statistics(1).skips, 2U);
    script.cost[0] = milliseconds(1);
    scheduler->runFrame(script.time.now(), &script);
    EXPECT_EQ(script.ran, "aaaaab");
}

TEST(Scheduler, leavesOutWhatIsNotWanted) {
    std::array<Task, 4> table = kTable;
    table[1].wanted = &Scripted::isWanted;
    Scripted script;
    Expected<Scheduler> scheduler = Scheduler::create(table, {}, script.time, script.time);
    ASSERT_TRUE(scheduler);
    script.wanted = false;
    scheduler->runFrame(script.time.now(), &script);
    script.wanted = true;
    scheduler->runFrame(script.time.now(), &script);
    EXPECT_EQ(script.ran, "acdabcd");
    EXPECT_EQ(scheduler->statistics(1).skips, 0U);
}

TEST(Scheduler, tellsMinimumMeanPercentileAndMaximum) {
    Scripted script;
    Expected<Scheduler> scheduler = Scheduler::create(kTable, {}, script.time, script.time);
    ASSERT_TRUE(scheduler);
    for (int i = 1; i <= 100; ++i) {
        script.cost[0] = milliseconds(i == 100 ? 50 : 4);
        if (i == 1) script.cost[0] = milliseconds(1);
        scheduler->runFrame(script.time.now(), &script);
    }
    const TaskStatistics first = scheduler->statistics(0);
    EXPECT_EQ(first.runs, 100U);
    EXPECT_EQ(first.minimum, milliseconds(1));
    EXPECT_EQ(first.maximum, milliseconds(50));
    EXPECT_NEAR(hal::seconds(first.mean), (1 + 98 * 4 + 50) / 100.0 * 1e-3, 1e-6);
    EXPECT_NEAR(hal::seconds(first.p99), 4e-3, 0.3e-3);
}

TEST(Scheduler, takesNoMemoryWhileItRuns) {
    Scripted script;
    script.ran.reserve(10'000);
    Expected<Scheduler> scheduler = Scheduler::create(kTable, {}, script.time, script.time);
    ASSERT_TRUE(scheduler);
    const test::AllocationCounter counter;
    for (int i = 0; i < 1000; ++i) {
        script.cost[0] = milliseconds(i % 40);
        scheduler->runFrame(script.time.now(), &script);
    }
    EXPECT_EQ(scheduler->statistics(0).runs, 1000U);
    EXPECT_EQ(counter.count(), 0U);
}

TEST(Scheduler, refusesTablesThatAreNotInOrder) {
    hal::VirtualClock clock;
    const auto refused = [&clock](std::span<const Task> table) {
        return !Scheduler::create(table, {}, clock, clock).hasValue();
    };
    EXPECT_TRUE(refused({}));
    EXPECT_TRUE(refused(std::vector<Task>(kMaximumTasks + 1, kTable[0])));
    std::array<Task, 4> table = kTable;
    table[2].priority = 2;
    EXPECT_TRUE(refused(table));
    table = kTable;
    table[1].work = nullptr;
    EXPECT_TRUE(refused(table));
    table = kTable;
    table[1].budget = {};
    EXPECT_TRUE(refused(table));
    table = kTable;
    table[1].name = {};
    EXPECT_TRUE(refused(table));
    EXPECT_FALSE(refused(kTable));
    EXPECT_FALSE(Scheduler::create(kTable, {.framePeriod = {}}, clock, clock).hasValue());
    EXPECT_FALSE(Scheduler::create(kTable, {.budgetScale = -1.0}, clock, clock).hasValue());
}

TEST(DurationHistogram, holdsPercentilesToSixPerCentOverSixOrdersOfMagnitude) {
    for (const int microseconds : {1, 15, 16, 17, 100, 999, 12'345, 700'000, 20'000'000}) {
        DurationHistogram histogram;
        for (int i = 0; i < 99; ++i)
            histogram.add(std::chrono::microseconds(microseconds));
        histogram.add(std::chrono::microseconds(microseconds) * 10);
        const double found = hal::seconds(histogram.percentile(0.5));
        EXPECT_GE(found, microseconds * 1e-6) << microseconds;
        EXPECT_LE(found, microseconds * 1.0651e-6 + 1e-6) << microseconds;
    }
}

TEST(DurationHistogram, keepsExtremesAndSurvivesAnything) {
    DurationHistogram histogram;
    EXPECT_EQ(histogram.percentile(0.99), hal::Duration(0));
    EXPECT_EQ(histogram.mean(), hal::Duration(0));
    histogram.add(hal::Duration(-5));
    histogram.add(std::chrono::hours(1000));
    EXPECT_EQ(histogram.minimum(), hal::Duration(0));
    EXPECT_EQ(histogram.maximum(), std::chrono::hours(1000));
    EXPECT_LE(histogram.percentile(1.0), std::chrono::hours(1000));
}

}  // namespace
}  // namespace cheval::daemon

#include "daemon/even_samples.h"

#include <vector>

#include <gtest/gtest.h>

namespace cheval::daemon {
namespace {

using std::chrono::milliseconds;

/// Feeds `count` instants `period` apart and returns when the kept ones were, in milliseconds.
std::vector<long> keptOf(EvenSamples<int>& samples, int count, hal::Duration period) {
    for (int i = 0; i < count; ++i) {
        const hal::TimePoint time(milliseconds(500) + i * period);
        if (samples.due(time)) {
            samples.keep(time, i);
        }
    }
    std::vector<long> times;
    for (const auto& entry : samples.entries()) {
        times.push_back(std::chrono::duration_cast<milliseconds>(entry.time.time_since_epoch()).count() - 500);
    }
    return times;
}

TEST(EvenSamples, KeepsTheFirstAndThenOneEachInterval) {
    EvenSamples<int> samples(100, milliseconds(100));
    EXPECT_EQ(keptOf(samples, 11, milliseconds(50)), (std::vector<long>{0, 100, 200, 300, 400, 500}));
}

TEST(EvenSamples, KeepsTheRateOfAStreamThatDoesNotDivideIt) {
    EvenSamples<int> samples(1000, milliseconds(100));
    // 30 Hz for ten seconds: 100 intervals.
    const auto kept = keptOf(samples, 301, hal::fromSeconds(1.0 / 30.0));
    EXPECT_EQ(kept.size(), 101U);
}

TEST(EvenSamples, StaysWithinItsCapacityAndEvenlySpreadForAStreamOfAnyLength) {
    for (const std::size_t capacity : {2U, 3U, 7U, 24U}) {
        for (const int count : {1, 2, 5, 23, 24, 25, 100, 5000}) {
            EvenSamples<int> samples(capacity, milliseconds(10));
            const auto kept = keptOf(samples, count, milliseconds(10));
            ASSERT_FALSE(kept.empty());
            EXPECT_EQ(kept.front(), 0);
            EXPECT_LT(kept.size(), capacity) << count;
            if (static_cast<std::size_t>(count) >= capacity && capacity > 3) {
                EXPECT_GE(kept.size(), capacity / 2) << count;
            }
            const long step = std::chrono::duration_cast<milliseconds>(samples.interval()).count();
            for (std::size_t i = 1; i < kept.size(); ++i) {
                EXPECT_EQ(kept[i] - kept[i - 1], step) << "capacity " << capacity << ", " << count << " instants";
            }
        }
    }
}

TEST(EvenSamples, GoesOnAfterAPauseWithoutCatchingUp) {
    EvenSamples<int> samples(100, milliseconds(100));
    keptOf(samples, 3, milliseconds(100));
    const hal::TimePoint late(milliseconds(500 + 5040));
    ASSERT_TRUE(samples.due(late));
    samples.keep(late, 99);
    EXPECT_FALSE(samples.due(late + milliseconds(40)));
    EXPECT_TRUE(samples.due(late + milliseconds(60)));
}

}  // namespace
}  // namespace cheval::daemon

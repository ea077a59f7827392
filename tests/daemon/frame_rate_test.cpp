#include "daemon/frame_rate.h"

#include <cmath>

#include <gtest/gtest.h>

namespace cheval::daemon {
namespace {

hal::DepthFrame frameAt(double seconds, std::uint64_t sequence, bool restart = false) {
    return {.sequence = sequence, .captureTime = hal::TimePoint(hal::fromSeconds(seconds)), .restart = restart};
}

TEST(FrameRate, IsNotKnownBeforeAWholeSpan) {
    FrameRate rate;
    EXPECT_EQ(rate.hz(), 0.0);
    for (std::uint64_t i = 0; i < 60; ++i)
        rate.add(frameAt(static_cast<double>(i) / 30.0, i));
    EXPECT_EQ(rate.hz(), 0.0);
    rate.add(frameAt(2.0, 60));
    EXPECT_NEAR(rate.hz(), 30.0, 0.01);
}

TEST(FrameRate, IsThatOfTheSensorWhateverJitterAndHowManyFramesAreTakenIn) {
    for (const double hz : {5.0, 15.0, 30.0}) {
        for (const std::uint64_t every : {1U, 2U, 3U}) {
            FrameRate rate;
            for (std::uint64_t i = 0; i < 300; i += every) {
                const auto n = static_cast<double>(i);
                rate.add(frameAt(100.0 + n / hz + 0.01 * std::sin(n), 7 + i));
            }
            EXPECT_NEAR(rate.hz(), hz, 0.02 * hz) << hz << ", one in " << every;
        }
    }
}

TEST(FrameRate, FollowsASensorThatBecomesSlow) {
    FrameRate rate;
    double time = 0.0;
    std::uint64_t sequence = 0;
    for (int i = 0; i < 90; ++i, time += 1.0 / 30.0)
        rate.add(frameAt(time, sequence++));
    for (int i = 0; i < 25; ++i, time += 0.2)
        rate.add(frameAt(time, sequence++));
    EXPECT_NEAR(rate.hz(), 5.0, 0.1);
}

TEST(FrameRate, BeginsAnewWithARestartAndWhenTimeOrCountRunBackwards) {
    for (const hal::DepthFrame& after : {frameAt(3.0, 90, true), frameAt(0.5, 90), frameAt(3.0, 2)}) {
        FrameRate rate;
        for (std::uint64_t i = 0; i < 80; ++i)
            rate.add(frameAt(1.0 + static_cast<double>(i) / 30.0, 5 + i));
        ASSERT_GT(rate.hz(), 0.0);
        rate.add(after);
        EXPECT_EQ(rate.hz(), 0.0);
    }
}

}  // namespace
}  // namespace cheval::daemon

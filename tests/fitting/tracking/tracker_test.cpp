#include "fitting/tracking/tracker.h"

#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::fitting {
namespace {

using Depth = std::vector<std::uint16_t>;
constexpr int kWidth = 640;
constexpr int kHeight = 480;

hal::DepthFrame frameOf(const Depth& depth, std::int64_t number) {
    hal::DepthFrame frame;
    frame.sequence = frame.sourceIndex = static_cast<std::uint64_t>(number);
    frame.captureTime = hal::TimePoint(hal::Duration(number * 33'333'333));
    frame.depth = {depth.data(), kWidth, kHeight, kWidth};
    return frame;
}

void expectNobody(const Tracker& tracker) {
    EXPECT_EQ(tracker.users().count, 0U);
    EXPECT_FALSE(tracker.skeleton().present());
}

TEST(Tracker, FindsNobodyInAnEmptyFrame) {
    Tracker tracker(TrackerOptions{});
    tracker.track(hal::DepthFrame{});
    tracker.readHands(hal::DepthFrame{});
    expectNobody(tracker);
}

TEST(Tracker, FindsNobodyInAFrameOfAnotherSize) {
    const Depth depth(320UL * 240UL, 2000);
    hal::DepthFrame frame;
    frame.depth = {depth.data(), 320, 240, 320};
    Tracker tracker(TrackerOptions{});
    tracker.track(frame);
    tracker.readHands(frame);
    expectNobody(tracker);
}

TEST(Tracker, FindsNobodyWhereAllIsOneDepth) {
    for (const int value : {0, 600, 2500, 10000, 65535}) {
        const Depth depth(static_cast<std::size_t>(kWidth) * kHeight, static_cast<std::uint16_t>(value));
        Tracker tracker(TrackerOptions{});
        for (int i = 0; i < 5; ++i) {
            tracker.track(frameOf(depth, i));
            tracker.readHands(frameOf(depth, i));
            expectNobody(tracker);
        }
    }
}

TEST(Tracker, SurvivesNoiseInEveryPixelAndTakesNoMemoryForIt) {
    std::mt19937 random(7);
    std::uniform_int_distribution<int> value(0, 65535);
    Depth depth(static_cast<std::size_t>(kWidth) * kHeight);
    Tracker tracker(TrackerOptions{});
    for (int i = 0; i < 8; ++i) {
        for (std::uint16_t& pixel : depth) {
            pixel = static_cast<std::uint16_t>(value(random) >> (i % 5));
        }
        const hal::DepthFrame frame = frameOf(depth, i);
        const test::AllocationCounter counter;
        tracker.track(frame);
        tracker.readHands(frame);
        EXPECT_EQ(counter.count(), 0U);
    }
}

}  // namespace
}  // namespace cheval::fitting

#include "hal/preview/button_queue.h"

#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

TimePoint at(std::int64_t number) {
    return TimePoint(Duration(number));
}

TEST(ButtonQueueTest, GivesWhatWasPressedOldestFirst) {
    ButtonQueue queue;
    for (int i = 0; i < 5; ++i)
        queue.press({.button = Button::view, .time = at(i)});
    std::array<ButtonEvent, 3> events;
    ASSERT_EQ(*queue.poll(events), 3U);
    EXPECT_EQ(events[0].time, at(0));
    EXPECT_EQ(events[2].time, at(2));
    ASSERT_EQ(*queue.poll(events), 2U);
    EXPECT_EQ(events[0].time, at(3));
    EXPECT_EQ(events[1].time, at(4));
    EXPECT_EQ(*queue.poll(events), 0U);
    EXPECT_EQ(queue.dropped(), 0U);
}

TEST(ButtonQueueTest, BeyondItsCapacityTheOldestGiveWayAndAreCounted) {
    ButtonQueue queue;
    for (int i = 0; i < 200; ++i)
        queue.press({.time = at(i)});
    std::array<ButtonEvent, 100> events;
    ASSERT_EQ(*queue.poll(events), ButtonQueue::kCapacity);
    EXPECT_EQ(events[0].time, at(136));
    EXPECT_EQ(events[63].time, at(199));
    EXPECT_EQ(queue.dropped(), 136U);
    EXPECT_EQ(queue.pressed(), 200U);
}

TEST(ButtonQueueTest, NothingIsLostBetweenThreads) {
    ButtonQueue queue;
    constexpr std::uint64_t kEach = 5000;
    std::vector<std::thread> pressers;
    for (int i = 0; i < 3; ++i) {
        pressers.emplace_back([&queue] {
            for (std::uint64_t n = 0; n < kEach; ++n)
                queue.press({});
        });
    }
    std::uint64_t polled = 0;
    std::array<ButtonEvent, 16> events;
    while (polled + queue.dropped() < 3 * kEach)
        polled += *queue.poll(events);
    for (std::thread& presser : pressers)
        presser.join();
    EXPECT_EQ(polled + queue.dropped(), 3 * kEach);
}

}  // namespace
}  // namespace cheval::hal

#include "hal/preview/preview_display.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::hal {
namespace {

constexpr DisplayMode kMode{.width = 16, .height = 32, .refreshHz = 30};

void show(Display& display, std::uint8_t shade) {
    auto buffer = display.lend(Duration::zero());
    ASSERT_TRUE(buffer) << buffer.error().message();
    for (int y = 0; y < buffer->pixels.height; ++y) {
        std::fill_n(buffer->pixels.row(y), buffer->pixels.width, Rgba8{shade, shade, shade, 255});
    }
    ASSERT_TRUE(display.present(*buffer, TimePoint{}));
}

TEST(PreviewDisplayTest, WhileNobodyLooksEveryPictureButTheLastIsDropped) {
    PreviewDisplay display(kMode);
    ASSERT_TRUE(display.open());
    for (std::uint8_t i = 1; i <= 10; ++i)
        show(display, i);
    EXPECT_EQ(display.statistics().presented, 10U);
    EXPECT_EQ(display.statistics().dropped, 9U);
}

TEST(PreviewDisplayTest, AViewerGetsTheLatest) {
    PreviewDisplay display(kMode);
    ASSERT_TRUE(display.open());
    show(display, 1);
    show(display, 2);
    display.addViewer();
    PreviewDisplay::Picture picture;
    ASSERT_TRUE(display.take(picture));
    EXPECT_EQ(picture.number, 2U);
    EXPECT_EQ(picture.pixels.at(15, 31).r, 2);
    display.giveBack();
}

TEST(PreviewDisplayTest, ATakenPictureStaysAsItIsHoweverMuchIsDrawn) {
    PreviewDisplay display(kMode);
    ASSERT_TRUE(display.open());
    display.addViewer();
    show(display, 1);
    PreviewDisplay::Picture picture;
    ASSERT_TRUE(display.take(picture));
    for (std::uint8_t i = 2; i < 50; ++i) {
        show(display, i);
        EXPECT_EQ(picture.pixels.at(0, 0).r, 1);
    }
    display.close();
    ASSERT_TRUE(display.open());
    show(display, 99);
    show(display, 98);
    EXPECT_EQ(picture.pixels.at(0, 0).r, 1);
    display.giveBack();
    ASSERT_TRUE(display.take(picture));
    EXPECT_EQ(picture.pixels.at(0, 0).r, 98);
}

TEST(PreviewDisplayTest, LendingAndPresentingTakeNoMemory) {
    PreviewDisplay display(kMode);
    ASSERT_TRUE(display.open());
    const test::AllocationCounter counter;
    for (std::uint8_t i = 0; i < 100; ++i)
        show(display, i);
    EXPECT_EQ(counter.count(), 0U);
}

TEST(PreviewDisplayTest, WhatIsTakenWasDrawnWhole) {
    PreviewDisplay display(kMode);
    ASSERT_TRUE(display.open());
    display.addViewer();
    std::atomic<int> torn{0};
    std::thread reader([&] {
        PreviewDisplay::Picture picture;
        while (display.take(picture)) {
            const std::uint8_t first = picture.pixels.at(0, 0).r;
            for (int y = 0; y < picture.pixels.height; ++y) {
                for (int x = 0; x < picture.pixels.width; ++x)
                    torn += picture.pixels.at(x, y).r == first ? 0 : 1;
            }
            display.giveBack();
        }
    });
    for (int i = 0; i < 20000; ++i)
        show(display, static_cast<std::uint8_t>(i));
    display.stop();
    reader.join();
    EXPECT_EQ(torn, 0);
}

}  // namespace
}  // namespace cheval::hal

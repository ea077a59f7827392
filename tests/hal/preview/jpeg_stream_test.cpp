#include "hal/preview/jpeg_stream.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

TEST(JpegStreamTest, NothingIsEncodedWhileNobodyLooks) {
    constexpr DisplayMode kMode{.width = 16, .height = 32, .refreshHz = 30};
    PreviewDisplay display(kMode);
    JpegStream stream(display, kMode, 16, 80);
    ASSERT_TRUE(display.open());
    auto buffer = display.lend(Duration::zero());
    ASSERT_TRUE(display.present(*buffer, TimePoint{}));
    EXPECT_EQ(stream.next(0, std::chrono::milliseconds(1)), nullptr);
    display.addViewer();
    const auto jpeg = stream.next(0, std::chrono::minutes(1));
    ASSERT_NE(jpeg, nullptr);
    EXPECT_EQ(jpeg->number, 1U);
}

TEST(JpegStreamTest, AWaitEndsWithTheStream) {
    constexpr DisplayMode kMode{.width = 16, .height = 32, .refreshHz = 30};
    PreviewDisplay display(kMode);
    JpegStream stream(display, kMode, 16, 80);
    std::thread stopper([&] { stream.stop(); });
    EXPECT_EQ(stream.next(0, std::chrono::hours(1)), nullptr);
    stopper.join();
}

}  // namespace
}  // namespace cheval::hal

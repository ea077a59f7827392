#include "hal/shrink.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

TEST(ShrinkTest, APlainPictureStaysPlain) {
    for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {30, 50}, {31, 50}, {62, 75}}) {
        const Image<Rgba8> from(31, 50, {.r = 250, .g = 7, .b = 128, .a = 3});
        Image<Rgba8> to(width, height);
        std::vector<std::uint32_t> sums;
        shrink(from.view(), to.view(), sums);
        for (const Rgba8 pixel : to.pixels)
            EXPECT_EQ(pixel, (Rgba8{250, 7, 128, 255}));
    }
}

TEST(ShrinkTest, HalvingTakesTheMeanOfFour) {
    Image<Rgba8> from(4, 2);
    for (int i = 0; i < 8; ++i)
        from.pixels[static_cast<std::size_t>(i)] = {.r = static_cast<std::uint8_t>(i * 10), .g = 0, .b = 255};
    Image<Rgba8> to(2, 1);
    std::vector<std::uint32_t> sums;
    shrink(from.view(), to.view(), sums);
    EXPECT_EQ(to.pixels[0].r, (0 + 10 + 40 + 50) / 4);
    EXPECT_EQ(to.pixels[1].r, (20 + 30 + 60 + 70) / 4);
    EXPECT_EQ(to.pixels[1].b, 255);
}

TEST(ShrinkTest, EverySourcePixelCountsOnceWhereTheSizesDivide) {
    Image<Rgba8> from(60, 90);
    std::uint32_t expected = 0;
    for (std::size_t i = 0; i < from.pixels.size(); ++i) {
        from.pixels[i].r = static_cast<std::uint8_t>(i * 31);
        expected += from.pixels[i].r;
    }
    Image<Rgba8> to(10, 10);
    std::vector<std::uint32_t> sums;
    shrink(from.view(), to.view(), sums);
    std::uint32_t sum = 0;
    for (const Rgba8 pixel : to.pixels)
        sum += pixel.r;
    EXPECT_NEAR(static_cast<double>(sum) * 54.0, static_cast<double>(expected), 54.0 * 100 / 2);
}

}  // namespace
}  // namespace cheval::hal

#include "render/depth_relief.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

namespace cheval::render {
namespace {

constexpr hal::Intrinsics kIntrinsics{.width = 160, .height = 120, .fx = 150, .fy = 150, .cx = 79.5, .cy = 59.5};

hal::Image<std::uint16_t> wall(std::uint16_t depth) {
    return {160, 120, depth};
}

TEST(DepthRelief, NoReadingIsDarkerThanAnyReading) {
    hal::Image<std::uint16_t> depth = wall(0);
    for (int x = 10; x < 150; ++x) {
        for (int y = 10; y < 110; ++y)
            depth.view().at(x, y) = static_cast<std::uint16_t>(400 + (x * 7919 + y * 104'729) % 9000);
    }
    DepthRelief relief;
    const auto picture = relief.light(std::as_const(depth).view(), kIntrinsics);
    for (int y = 0; y < 120; ++y) {
        for (int x = 0; x < 160; ++x) {
            if (depth.view().at(x, y) == 0)
                EXPECT_EQ(picture.at(x, y), DepthRelief::kNoReading);
            else
                EXPECT_GE(picture.at(x, y), DepthRelief::kDarkestReading);
        }
    }
}

TEST(DepthRelief, WhatIsNearerIsBrighter) {
    DepthRelief relief;
    int before = 256;
    for (const std::uint16_t depth : {std::uint16_t{1000}, std::uint16_t{2000}, std::uint16_t{3500}}) {
        const hal::Image<std::uint16_t> flat = wall(depth);
        const int grey = relief.light(flat.view(), kIntrinsics).at(80, 60);
        EXPECT_LT(grey, before);
        before = grey;
    }
}

TEST(DepthRelief, WhatFacesUpIsBrighterThanWhatFacesDown) {
    hal::Image<std::uint16_t> up = wall(2000);
    hal::Image<std::uint16_t> down = wall(2000);
    for (int y = 0; y < 120; ++y) {
        for (int x = 0; x < 160; ++x) {
            // Nearer towards the picture's lower edge: a floor; the other way a ceiling.
            up.view().at(x, y) = static_cast<std::uint16_t>(2000 - 8 * (y - 60));
            down.view().at(x, y) = static_cast<std::uint16_t>(2000 + 8 * (y - 60));
        }
    }
    DepthRelief relief;
    const int floor = relief.light(std::as_const(up).view(), kIntrinsics).at(80, 60);
    const int ceiling = relief.light(std::as_const(down).view(), kIntrinsics).at(80, 60);
    EXPECT_GT(floor, ceiling + 20);
}

TEST(DepthRelief, AnEdgeDoesNotShadeTheSurfacesBesideIt) {
    hal::Image<std::uint16_t> step = wall(3000);
    for (int y = 0; y < 120; ++y) {
        for (int x = 0; x < 80; ++x)
            step.view().at(x, y) = 1500;
    }
    const hal::Image<std::uint16_t> nearWall = wall(1500);
    DepthRelief relief;
    DepthRelief alone;
    const auto picture = relief.light(std::as_const(step).view(), kIntrinsics);
    const auto reference = alone.light(nearWall.view(), kIntrinsics);
    for (int x = 70; x < 80; ++x)
        EXPECT_NEAR(picture.at(x, 60), reference.at(x, 60), 1) << x;
}

TEST(DepthRelief, KeepsUpWithPicturesOfAnotherSizeAndRefusesNone) {
    DepthRelief relief;
    const hal::Image<std::uint16_t> large(320, 240, 1000);
    const hal::Image<std::uint16_t> small(3, 1, 1000);
    EXPECT_EQ(relief.light(large.view(), kIntrinsics).width, 320);
    EXPECT_EQ(relief.light(small.view(), kIntrinsics).width, 3);
    EXPECT_TRUE(relief.light({}, kIntrinsics).empty());
}

}  // namespace
}  // namespace cheval::render

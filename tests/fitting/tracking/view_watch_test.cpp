#include "fitting/tracking/view_watch.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "fitting/tracking/placement.h"

namespace cheval::fitting::tracking {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr hal::Intrinsics kLens{kWidth, kHeight, 570.0F, 570.0F, 319.5F, 239.5F};
constexpr float kSensorHeight = 1.25F;

/// An empty room with a floor and a wall at 4 m, as a sensor of this tilt (radians) sees it.
std::vector<std::uint16_t> room(float tilt = 0.0F) {
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(kWidth) * kHeight);
    for (int v = 0; v < kHeight; ++v) {
        const float down = std::cos(tilt) * (static_cast<float>(v) - kLens.cy) / kLens.fy - std::sin(tilt);
        const float floor = down > 0.0F ? kSensorHeight / down : 100.0F;
        for (int u = 0; u < kWidth; ++u) {
            depth[static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u)] =
                static_cast<std::uint16_t>(1000.0F * std::min(4.0F, floor));
        }
    }
    return depth;
}

ViewFault judge(const std::vector<std::uint16_t>& depth, float tilt = 0.0F) {
    Cloud cloud;
    CloudJob job{.depth = {depth.data(), kWidth, kHeight, kWidth},
                 .intrinsics = kLens,
                 .placement = placementFrom({.height = kSensorHeight, .tilt = tilt}),
                 .cloud = &cloud};
    job.run();
    return ViewWatch::judge(cloud);
}

TEST(ViewWatch, ARoomIsSound) {
    EXPECT_EQ(judge(room()), ViewFault::none);
}

TEST(ViewWatch, ATableOfWhatCanHideEverybody) {
    const std::size_t pixels = static_cast<std::size_t>(kWidth) * kHeight;
    EXPECT_EQ(judge(std::vector<std::uint16_t>(pixels, 0)), ViewFault::noReadings);
    EXPECT_EQ(judge(std::vector<std::uint16_t>(pixels, 600)), ViewFault::covered);
    std::vector<std::uint16_t> hand = room();
    for (std::size_t i = 0; i < hand.size() * 3 / 5; ++i) {
        hand[i] = 450;
    }
    EXPECT_EQ(judge(hand), ViewFault::covered);
    std::vector<std::uint16_t> turned = room();
    std::reverse(turned.begin(), turned.end());
    EXPECT_EQ(judge(turned), ViewFault::upsideDown);
}

TEST(ViewWatch, ASensorOnItsHeadIsToldHoweverItIsTilted) {
    for (const float tilt : {-0.25F, -0.07F, 0.05F}) {
        std::vector<std::uint16_t> depth = room(tilt);
        EXPECT_EQ(judge(depth, tilt), ViewFault::none) << tilt;
        std::reverse(depth.begin(), depth.end());
        EXPECT_EQ(judge(depth, tilt), ViewFault::upsideDown) << tilt;
    }
}

TEST(ViewWatch, AWallWithoutAFloorIsNotUpsideDown) {
    EXPECT_EQ(judge(std::vector<std::uint16_t>(static_cast<std::size_t>(kWidth) * kHeight, 2500)), ViewFault::none);
}

TEST(ViewWatch, BelievesWhatHasLastedAndForgetsItLikewise) {
    Cloud sound;
    const std::vector<std::uint16_t> depth = room();
    CloudJob job{.depth = {depth.data(), kWidth, kHeight, kWidth},
                 .intrinsics = kLens,
                 .placement = placementFrom({.height = kSensorHeight}),
                 .cloud = &sound};
    job.run();
    ViewWatch watch;
    const auto at = [](double seconds) { return hal::TimePoint(hal::fromSeconds(seconds)); };
    watch.update(nullptr, at(0.0));
    watch.update(nullptr, at(ViewWatch::kBelievedAfter - 0.1));
    EXPECT_EQ(watch.fault(), ViewFault::none);
    watch.update(nullptr, at(ViewWatch::kBelievedAfter));
    EXPECT_EQ(watch.fault(), ViewFault::noReadings);
    watch.update(&sound, at(10.0));
    EXPECT_EQ(watch.fault(), ViewFault::noReadings);
    watch.update(&sound, at(10.0 + ViewWatch::kBelievedAfter));
    EXPECT_EQ(watch.fault(), ViewFault::none);
}

}  // namespace
}  // namespace cheval::fitting::tracking

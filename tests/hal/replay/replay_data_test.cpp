// The recordings that are not ours play from the first to the last picture.
#include <algorithm>

#include <gtest/gtest.h>

#include "hal/replay/replay_camera.h"

namespace cheval::hal {
namespace {

struct Played {
    std::size_t frames = 0;
    std::size_t stills = 0;
    std::uint16_t nearest = 65535;
    std::uint16_t farthest = 0;
};

Played play(const std::string& folder, int stillRepeats) {
    VirtualClock clock;
    auto made =
        makeReplayCamera({.folder = std::string(CHEVAL_DATA) + "/" + folder, .stillRepeats = stillRepeats}, clock);
    Played played;
    EXPECT_TRUE(made) << made.error().message();
    if (!made) return played;
    ReplayCamera& camera = **made;
    EXPECT_TRUE(camera.open());
    DepthFrame frame;
    FrameStatus status = FrameStatus::frame;
    while ((status = camera.waitFrame(fromSeconds(10), frame)) == FrameStatus::frame) {
        ++played.frames;
        played.stills += frame.lastOfStill ? 1U : 0U;
        for (int y = 0; y < frame.depth.height; ++y) {
            for (int x = 0; x < frame.depth.width; ++x) {
                const std::uint16_t z = frame.depth.at(x, y);
                if (z == 0) continue;
                played.nearest = std::min(played.nearest, z);
                played.farthest = std::max(played.farthest, z);
            }
        }
    }
    EXPECT_EQ(status, FrameStatus::ended);
    EXPECT_TRUE(camera.warnings().empty()) << camera.warnings().front();
    return played;
}

TEST(ReplayDataTest, PlaysAShopperFrameByFrame) {
    const Played played = play("shoppers/seq01", 45);
    EXPECT_EQ(played.frames, 105U);
    EXPECT_GT(played.nearest, 400);
    EXPECT_LT(played.farthest, 10000);
}

TEST(ReplayDataTest, RepeatsTheStillsOfARealSensor) {
    const Played played = play("real-upper-body", 3);
    EXPECT_EQ(played.frames, 24U);
    EXPECT_EQ(played.stills, 8U);
}

TEST(ReplayDataTest, ConvertsEighthsOfAMillimetre) {
    const Played played = play("real-hands", 1);
    EXPECT_EQ(played.frames, 10U);
    EXPECT_GT(played.nearest, 50);
    EXPECT_LE(played.farthest, 8192);  // 65535 eighths, rounded.
}

}  // namespace
}  // namespace cheval::hal

#include "fitting/tracking/lone_hand.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::fitting::tracking {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr float kMillimetresPerPixel = 1.0F;

/// A hand as wide as a grown-up's, drawn flat: a round palm, some straight fingers and an arm.
class DrawnHand {
  public:
    DrawnHand(int fingers, float angle) {
        for (int v = 0; v < kHeight; ++v) {
            for (int u = 0; u < kWidth; ++u) {
                const float x = (static_cast<float>(u) - 320.0F) * kMillimetresPerPixel;
                const float y = (static_cast<float>(v) - 240.0F) * kMillimetresPerPixel;
                // Fingers up, arm down, then turned.
                const Eigen::Vector2f p(std::cos(angle) * x - std::sin(angle) * y,
                                        std::sin(angle) * x + std::cos(angle) * y);
                if (isHand(p, fingers))
                    depth_[static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u)] = 570;
            }
        }
    }
    [[nodiscard]] hal::DepthFrame frame() const {
        hal::DepthFrame frame;
        frame.intrinsics = {kWidth, kHeight, 570.0F, 570.0F, 319.5F, 239.5F};
        frame.depth = {depth_.data(), kWidth, kHeight, kWidth};
        return frame;
    }

  private:
    static bool nearLine(const Eigen::Vector2f& p, const Eigen::Vector2f& from, const Eigen::Vector2f& to,
                         float radius) {
        const Eigen::Vector2f along = to - from;
        const float t = std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0F, 1.0F);
        return (p - from - t * along).norm() < radius;
    }
    static bool isHand(const Eigen::Vector2f& p, int fingers) {
        const Eigen::Vector2f palm(0.0F, 0.0F);
        if ((p - palm).norm() < 42.0F || nearLine(p, palm, {0.0F, 150.0F}, 28.0F)) return true;
        // From the thumb on, each a little farther round.
        constexpr float kAngles[] = {-1.25F, -0.45F, -0.12F, 0.2F, 0.52F};
        constexpr float kLengths[] = {90.0F, 118.0F, 126.0F, 118.0F, 100.0F};
        for (int k = 0; k < fingers; ++k) {
            const Eigen::Vector2f tip(kLengths[k] * std::sin(kAngles[k]), -kLengths[k] * std::cos(kAngles[k]));
            if (nearLine(p, palm, tip, 8.5F)) return true;
        }
        return false;
    }

    std::vector<std::uint16_t> depth_ = std::vector<std::uint16_t>(static_cast<std::size_t>(kWidth) * kHeight);
};

TEST(LoneHand, AnOpenHandIsReadAsOpenHoweverItIsTurned) {
    LoneHandReader reader;
    for (int step = 0; step < 16; ++step) {
        const float angle = 0.39F * static_cast<float>(step);
        const DrawnHand hand(5, angle);
        const LoneHandReader::Reading reading = reader.read(hand.frame());
        EXPECT_TRUE(reading.found) << angle;
        EXPECT_EQ(reading.fingers, 5) << angle;
        EXPECT_EQ(reading.state, HandState::open) << angle;
        EXPECT_GT(reading.confidence, 0.5F) << angle;
    }
}

TEST(LoneHand, AHandWithSomeFingersIsNeitherOpenNorClosed) {
    LoneHandReader reader;
    for (int fingers = 2; fingers <= 4; ++fingers) {
        const DrawnHand hand(fingers, 0.0F);
        const LoneHandReader::Reading reading = reader.read(hand.frame());
        EXPECT_EQ(reading.fingers, fingers);
        EXPECT_EQ(reading.state, HandState::unknown) << fingers;
    }
}

TEST(LoneHand, AFistHasNoFingers) {
    LoneHandReader reader;
    const DrawnHand hand(0, 0.0F);
    const LoneHandReader::Reading reading = reader.read(hand.frame());
    EXPECT_TRUE(reading.found);
    EXPECT_EQ(reading.fingers, 0);
    EXPECT_NE(reading.state, HandState::open);
}

TEST(LoneHand, NothingAndAWallAreNoHands) {
    LoneHandReader reader;
    EXPECT_FALSE(reader.read(hal::DepthFrame{}).found);
    for (const std::uint16_t depth : {std::uint16_t{0}, std::uint16_t{600}, std::uint16_t{4000}}) {
        const std::vector<std::uint16_t> pixels(static_cast<std::size_t>(kWidth) * kHeight, depth);
        hal::DepthFrame frame;
        frame.depth = {pixels.data(), kWidth, kHeight, kWidth};
        EXPECT_FALSE(reader.read(frame).found) << depth;
    }
}

TEST(LoneHand, TakesNoMemoryForAPicture) {
    LoneHandReader reader;
    const DrawnHand hand(5, 0.3F);
    const hal::DepthFrame frame = hand.frame();
    const cheval::test::AllocationCounter counter;
    reader.read(frame);
    EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace cheval::fitting::tracking

#include "fitting/tracking/background.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::fitting::tracking {
namespace {

constexpr float kFrame = 1.0F / 30.0F;

class BackgroundTest : public testing::Test {
  protected:
    /// One frame in which every cell shows `metres`.
    void see(float metres, int frames = 1) {
        std::fill(cloud_.depth.begin(), cloud_.depth.end(), metres);
        for (int i = 0; i < frames; ++i) {
            background_.learn(cloud_, belief_, kFrame);
        }
    }
    [[nodiscard]] bool inFront(std::size_t cell, float metres) {
        cloud_.depth[cell] = metres;
        return background_.isInFront(cloud_, cell);
    }

    Cloud cloud_;
    Background background_;
    std::vector<Belief> belief_ = std::vector<Belief>(kCloudCells, Belief::whereNew);
    const std::size_t cell_ = cellIndex(100, 100);
};

TEST_F(BackgroundTest, EverythingIsInFrontWhereNothingHasBeenSeen) {
    EXPECT_TRUE(inFront(cell_, 3.9F));
}

TEST_F(BackgroundTest, WhatIsSeenFirstIsBelievedAtOnceUnlessItIsAPerson) {
    belief_[cell_] = Belief::never;
    see(3.0F);
    EXPECT_FALSE(inFront(cellIndex(10, 10), 3.0F));
    EXPECT_TRUE(inFront(cellIndex(10, 10), 2.5F));
    // The person's cell has shown nothing yet; what stands about it is known.
    EXPECT_FALSE(inFront(cell_, 3.0F));
    EXPECT_TRUE(inFront(cell_, 2.5F));
}

TEST_F(BackgroundTest, WhatMayBelongToAPersonIsNotBelievedWhereItIsNew) {
    std::fill(belief_.begin(), belief_.end(), Belief::inTime);
    see(2.0F, 10);
    EXPECT_TRUE(inFront(cell_, 2.0F));
    EXPECT_TRUE(inFront(cell_, 2.4F));
}

TEST_F(BackgroundTest, ACellThatHasShownNothingIsLikeTheNearestOfItsNeighbours) {
    std::fill(cloud_.depth.begin(), cloud_.depth.end(), 4.0F);
    cloud_.depth[cell_] = 0.0F;
    cloud_.depth[cell_ + 1] = 3.5F;
    background_.learn(cloud_, belief_, kFrame);
    EXPECT_FALSE(inFront(cell_, 3.5F));
    EXPECT_TRUE(inFront(cell_, 3.0F));
}

TEST_F(BackgroundTest, WhatHasLeftIsForgottenSoon) {
    see(2.0F);
    see(4.0F, static_cast<int>(Background::kLeaveSeconds / kFrame) + 2);
    EXPECT_TRUE(inFront(cell_, 2.0F));
}

TEST_F(BackgroundTest, WhatShowsTheWallBehindItNowAndThenStays) {
    see(3.6F);
    for (int i = 0; i < 100; ++i) {
        see(3.9F, 3);
        see(3.6F);
    }
    EXPECT_FALSE(inFront(cell_, 3.6F));
}

TEST_F(BackgroundTest, WhatIsPutDownIsBelievedWhenItHasStoodForLong) {
    see(4.0F);
    const int settle = static_cast<int>(Background::kSettleSeconds / kFrame);
    see(3.0F, settle - 5);
    EXPECT_TRUE(inFront(cell_, 3.0F));
    see(3.0F, 10);
    EXPECT_FALSE(inFront(cell_, 3.0F));
}

TEST_F(BackgroundTest, APersonIsNeverBelievedHoweverLongTheyStand) {
    see(4.0F);
    belief_[cell_] = Belief::never;
    see(3.0F, static_cast<int>(60.0F / kFrame));
    EXPECT_TRUE(inFront(cell_, 3.0F));
}

TEST_F(BackgroundTest, WhatIsMarkedAsSceneryIsBelievedAtOnce) {
    see(4.0F);
    belief_[cell_] = Belief::atOnce;
    see(3.0F);
    EXPECT_FALSE(inFront(cell_, 3.0F));
}

}  // namespace
}  // namespace cheval::fitting::tracking

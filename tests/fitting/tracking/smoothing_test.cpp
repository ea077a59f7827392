#include "fitting/tracking/smoothing.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace cheval::fitting::tracking {
namespace {

constexpr float kFrame = 1.0F / 30.0F;

TEST(PointFilter, TellsTheVelocityOfWhatMovesEvenly) {
    for (const float speed : {0.2F, 1.0F, 3.0F}) {
        PointFilter filter;
        const Eigen::Vector3f velocity(speed, -0.5F * speed, 0.0F);
        for (int frame = 0; frame < 90; ++frame) {
            filter.filter(velocity * (kFrame * static_cast<float>(frame)), kFrame);
        }
        EXPECT_LT((filter.velocity() - velocity).norm(), 0.01F * speed) << speed;
    }
}

TEST(PointFilter, HoldsStillWhatTrembles) {
    std::mt19937 random(5);
    std::normal_distribution<float> noise(0.0F, 0.006F);
    PointFilter filter;
    double raw = 0.0;
    double left = 0.0;
    for (int frame = 0; frame < 600; ++frame) {
        const Eigen::Vector3f point(noise(random), noise(random), noise(random));
        const Eigen::Vector3f value = filter.filter(point, kFrame);
        if (frame < 60) continue;
        raw += static_cast<double>(point.squaredNorm());
        left += static_cast<double>(value.squaredNorm());
    }
    EXPECT_LT(std::sqrt(left), 0.5 * std::sqrt(raw));
}

TEST(PointFilter, StartsAfreshWhereItIsTold) {
    PointFilter filter;
    filter.filter({1, 2, 3}, kFrame);
    filter.filter({2, 2, 3}, kFrame);
    filter.reset();
    EXPECT_EQ(filter.filter({5, 5, 5}, kFrame), Eigen::Vector3f(5, 5, 5));
    EXPECT_EQ(filter.velocity(), Eigen::Vector3f(0, 0, 0));
    EXPECT_EQ(filter.filter({7, 7, 7}, 0.0F), Eigen::Vector3f(7, 7, 7)) << "no time has passed";
}

}  // namespace
}  // namespace cheval::fitting::tracking

// What Script::measuring promises, and the noise that it can be played with.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "hal/sim/world.h"

namespace cheval::hal::sim {
namespace {

using Eigen::Vector3f;
using fitting::Joint;

constexpr double kStep = 1.0 / 30.0;
constexpr float kDegree = std::numbers::pi_v<float> / 180.0F;

float yawOf(const fitting::Skeleton& skeleton) {
    const Vector3f ahead = skeleton[Joint::torso].orientation * Vector3f::UnitZ();
    return std::atan2(-ahead.x(), -ahead.z());
}

TEST(Measuring, FacesTheGlassThenShowsBothSidesAndTheBack) {
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        const World world({.seed = seed, .script = Script::measuring, .visitSeconds = 23.0});
        double facing = 0.0, left = 0.0, right = 0.0;
        bool turned = false, back = false;
        float before = 0.0F;
        for (int frame = 102; frame < 675; ++frame) {
            const double t = kStep * frame;
            const fitting::Skeleton skeleton = truthAt(world, t).skeleton;
            ASSERT_TRUE(skeleton.present()) << "seed " << seed << " at " << t;
            const float yaw = yawOf(skeleton);
            const float away = std::abs(yaw) / kDegree;
            turned |= away > 45.0F;
            if (!turned && away < 15.0F) facing += kStep;
            const bool still = std::abs(yaw - before) < 0.2F * kDegree;
            before = yaw;
            if (std::abs(away - 90.0F) < 8.0F && still) (yaw > 0.0F ? left : right) += kStep;
            back |= away > 170.0F;
        }
        EXPECT_GT(facing, 5.0) << "seed " << seed;
        EXPECT_GT(left, 0.6) << "seed " << seed;
        EXPECT_GT(right, 0.6) << "seed " << seed;
        EXPECT_TRUE(back) << "seed " << seed;
        EXPECT_LT(std::abs(yawOf(truthAt(world, 22.5).skeleton)), 10.0F * kDegree);
    }
}

TEST(Measuring, StandsWhereCrownAndHipsAreInThePicture) {
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        const World world({.seed = seed, .script = Script::measuring, .visitSeconds = 23.0});
        const WorldTruth truth = truthAt(world, 5.0);
        const Vector3f hip = truth.skeleton[Joint::leftHip].position;
        EXPECT_GT(hip.z(), 1.9F);
        EXPECT_LT(hip.z(), 2.8F);
        // Up to a hand's breadth over the crown, as the sensor looks up.
        EXPECT_LT((truth.statureMetres + 0.08F - 1.25F) / hip.z(), 0.345F) << "seed " << seed;
    }
}

TEST(Measuring, IsSeenNoisierByANoisierSensor) {
    const auto roughness = [](float scale) {
        World world({.seed = 4, .colour = false, .script = Script::measuring, .noiseScale = scale});
        Image<std::uint16_t> first, second;
        Image<Rgb8> none;
        // The empty room: what differs is noise in time.
        renderFrame(world, 720, first, none);
        renderFrame(world, 721, second, none);
        double sum = 0.0;
        long count = 0;
        for (std::size_t i = 0; i < first.pixels.size(); ++i) {
            if (first.pixels[i] == 0 || second.pixels[i] == 0) continue;
            const double step = static_cast<double>(first.pixels[i]) - static_cast<double>(second.pixels[i]);
            sum += std::min(std::abs(step), 200.0);
            ++count;
        }
        return sum / static_cast<double>(count);
    };
    const double usual = roughness(1.0F);
    EXPECT_GT(roughness(2.0F), 1.5 * usual);
    EXPECT_LT(roughness(0.25F), 0.7 * usual);
}

}  // namespace
}  // namespace cheval::hal::sim

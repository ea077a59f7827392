#include "fitting/tracking/depth_cleanup.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace cheval::fitting::tracking {
namespace {

struct Scene {
    int width, height;
    std::vector<std::uint16_t> depth, cleaned;
    std::vector<std::uint8_t> map;
    std::vector<float> scratch;

    Scene(int w, int h)
        : width(w),
          height(h),
          depth(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)),
          cleaned(depth.size()),
          map(depth.size()),
          scratch(depth.size()) {}
    DepthCleanupJob job() {
        return {.depth = {depth.data(), width, height, width},
                .userMap = {map.data(), width, height, width},
                .label = 1,
                .scratch = scratch,
                .cleaned = {cleaned.data(), width, height, width}};
    }
};

TEST(DepthCleanup, RefusesWhatDoesNotFit) {
    EXPECT_FALSE(DepthCleanupJob{}.isValid());
    Scene scene(64, 48);
    EXPECT_TRUE(scene.job().isValid());
    DepthCleanupJob job = scene.job();
    job.userMap.width = 63;
    EXPECT_FALSE(job.isValid());
    job = scene.job();
    job.scratch = job.scratch.first(10);
    EXPECT_FALSE(job.isValid());
    job = scene.job();
    job.sigma = 0.0F;
    EXPECT_FALSE(job.isValid());
}

TEST(DepthCleanup, EqualsFillAndGaussianOfTheReference) {
    for (const unsigned seed : {1U, 2U, 3U}) {
        Scene scene(160, 120);
        std::mt19937 random(seed);
        std::uniform_int_distribution<int> near(1900, 2300);
        std::uniform_int_distribution<int> chance(0, 9);
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < scene.depth.size(); ++i) {
            scene.map[i] = static_cast<std::uint8_t>(chance(random) < 5 ? 1 : chance(random) % 3);
            scene.depth[i] = static_cast<std::uint16_t>(chance(random) == 0 ? 0 : near(random));
            if (scene.map[i] == 1 && scene.depth[i] != 0) {
                sum += scene.depth[i];
                ++count;
            }
        }
        cv::Mat filled(scene.height, scene.width, CV_32F);
        for (std::size_t i = 0; i < scene.depth.size(); ++i) {
            filled.ptr<float>()[i] = scene.map[i] == 1 && scene.depth[i] != 0 ? static_cast<float>(scene.depth[i])
                                                                              : static_cast<float>(sum / count);
        }
        cv::Mat reference;
        cv::GaussianBlur(filled, reference, {5, 5}, 1.1, 1.1, cv::BORDER_REFLECT_101);
        DepthCleanupJob job = scene.job();
        job.run();
        EXPECT_NEAR(job.mean, sum / count, 0.01);
        for (std::size_t i = 0; i < scene.depth.size(); ++i) {
            EXPECT_NEAR(scene.cleaned[i], reference.ptr<float>()[i], 0.51F);
        }
    }
}

TEST(DepthCleanup, LeavesAFlatUserFlatAndClosesItsHoles) {
    Scene scene(40, 30);
    std::fill(scene.map.begin(), scene.map.end(), std::uint8_t{1});
    std::fill(scene.depth.begin(), scene.depth.end(), std::uint16_t{2000});
    scene.depth[15 * 40 + 20] = 0;
    DepthCleanupJob job = scene.job();
    job.run();
    for (const std::uint16_t value : scene.cleaned) {
        EXPECT_EQ(value, 2000);
    }
}

TEST(DepthCleanup, GivesZeroWithoutAUser) {
    Scene scene(40, 30);
    std::fill(scene.depth.begin(), scene.depth.end(), std::uint16_t{2000});
    scene.cleaned[7] = 9;
    DepthCleanupJob job = scene.job();
    job.run();
    EXPECT_EQ(job.mean, 0.0F);
    EXPECT_EQ(scene.cleaned[7], 0);
}

}  // namespace
}  // namespace cheval::fitting::tracking

#include "fitting/tracking/depth_cleanup.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/support/allocation_counter.h"

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
    SurfaceCleanupJob surfaceJob() {
        return {.depth = {depth.data(), width, height, width},
                .userMap = {map.data(), width, height, width},
                .label = 1,
                .scratch = scratch,
                .cleaned = {cleaned.data(), width, height, width}};
    }
    /// The user's readings in a rectangle, right and bottom not included; 0 is a hole.
    void fill(int left, int right, int top, int bottom, std::uint16_t value) {
        for (int row = top; row < bottom; ++row) {
            for (int column = left; column < right; ++column) {
                at(column, row) = value;
                map[index(column, row)] = value != 0 ? 1 : 0;
            }
        }
    }
    [[nodiscard]] std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
    }
    std::uint16_t& at(int column, int row) { return depth[index(column, row)]; }
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

TEST(SurfaceCleanup, RefusesWhatDoesNotFit) {
    EXPECT_FALSE(SurfaceCleanupJob{}.isValid());
    Scene scene(64, 48);
    EXPECT_TRUE(scene.surfaceJob().isValid());
    SurfaceCleanupJob job = scene.surfaceJob();
    job.cleaned.height = 47;
    EXPECT_FALSE(job.isValid());
    job = scene.surfaceJob();
    job.scratch = job.scratch.first(10);
    EXPECT_FALSE(job.isValid());
    job = scene.surfaceJob();
    job.widestHole = -1;
    EXPECT_FALSE(job.isValid());
    job = scene.surfaceJob();
    job.label = 0;
    EXPECT_FALSE(job.isValid());
}

TEST(SurfaceCleanup, BridgesAHoleInASlopeByTheSlope) {
    Scene scene(60, 50);
    scene.fill(5, 55, 5, 45, 2000);
    for (int row = 5; row < 45; ++row) {
        for (int column = 5; column < 55; ++column)
            scene.at(column, row) = static_cast<std::uint16_t>(2000 + 2 * column - row);
    }
    scene.fill(20, 28, 15, 24, 0);
    SurfaceCleanupJob job = scene.surfaceJob();
    job.run();
    EXPECT_EQ(job.filled, 8 * 9);
    for (int row = 15; row < 24; ++row) {
        for (int column = 20; column < 28; ++column)
            EXPECT_NEAR(scene.cleaned[scene.index(column, row)], 2000 + 2 * column - row, 2);
    }
}

TEST(SurfaceCleanup, LeavesWhatIsNotClosedInByTheUser) {
    Scene scene(100, 60);
    scene.fill(10, 90, 5, 60, 2000);
    scene.fill(20, 26, 40, 60, 0);  // Between the legs: open below.
    scene.fill(40, 60, 20, 30, 0);  // Wider than a hole may be.
    scene.fill(70, 76, 20, 26, 0);
    scene.at(73, 23) = 3200;  // Something else is seen through it.
    SurfaceCleanupJob job = scene.surfaceJob();
    job.run();
    EXPECT_EQ(scene.cleaned[scene.index(22, 50)], 0);
    EXPECT_EQ(scene.cleaned[scene.index(50, 25)], 0);
    EXPECT_EQ(scene.cleaned[scene.index(73, 23)], 0);
    EXPECT_EQ(scene.cleaned[scene.index(71, 23)], 0) << "not closed in along its row";
    EXPECT_EQ(scene.cleaned[scene.index(5, 5)], 0);
    EXPECT_EQ(scene.cleaned[scene.index(15, 50)], 2000);
}

TEST(SurfaceCleanup, FillsAShadowBesideAnArmWithTheTrunkBehindIt) {
    Scene scene(80, 60);
    scene.fill(10, 70, 5, 55, 2200);
    scene.fill(40, 50, 5, 55, 1700);  // A forearm before the trunk …
    scene.fill(34, 40, 20, 24, 0);    // … and a piece of its shadow.
    SurfaceCleanupJob job = scene.surfaceJob();
    job.run();
    for (int column = 34; column < 40; ++column)
        EXPECT_EQ(scene.cleaned[scene.index(column, 22)], 2200) << column;
}

TEST(SurfaceCleanup, KeepsAnEdgeThatAGaussianSmears) {
    Scene scene(80, 60);
    scene.fill(10, 40, 5, 55, 1500);
    scene.fill(40, 70, 5, 55, 2000);
    SurfaceCleanupJob job = scene.surfaceJob();
    job.run();
    for (int column = 10; column < 70; ++column)
        EXPECT_EQ(scene.cleaned[scene.index(column, 30)], column < 40 ? 1500 : 2000) << column;
    DepthCleanupJob source = scene.job();
    source.run();
    EXPECT_GT(scene.cleaned[scene.index(39, 30)], 1550);
}

TEST(SurfaceCleanup, QuietensASurfaceAsTheReferenceDoes) {
    Scene scene(200, 150);
    std::mt19937 random(5);
    cv::Mat noisy(scene.height, scene.width, CV_32F);
    const auto exact = [](int column, int row) { return 2500.0F + 1.5F * static_cast<float>(column - row); };
    std::normal_distribution<float> noise(0.0F, 9.0F);
    for (int row = 0; row < scene.height; ++row) {
        for (int column = 0; column < scene.width; ++column) {
            const float value = std::round(exact(column, row) + noise(random));
            scene.at(column, row) = static_cast<std::uint16_t>(value);
            scene.map[scene.index(column, row)] = 1;
            noisy.at<float>(row, column) = value;
        }
    }
    cv::Mat reference;
    // A Gaussian that falls off as the parabola of this width does.
    const double range = 0.45 * static_cast<double>(SurfaceCleanupJob::surfaceRange(2500.0F));
    cv::bilateralFilter(noisy, reference, 7, range, 1.6, cv::BORDER_REFLECT_101);
    SurfaceCleanupJob job = scene.surfaceJob();
    job.run();
    double ours = 0.0;
    double theirs = 0.0;
    double apart = 0.0;
    int count = 0;
    for (int row = 4; row < scene.height - 4; ++row) {
        for (int column = 4; column < scene.width - 4; ++column) {
            const double got = scene.cleaned[scene.index(column, row)];
            const double expected = reference.at<float>(row, column);
            ours += (got - exact(column, row)) * (got - exact(column, row));
            theirs += (expected - exact(column, row)) * (expected - exact(column, row));
            apart += (got - expected) * (got - expected);
            ++count;
        }
    }
    EXPECT_LT(std::sqrt(ours / count), 1.1 * std::sqrt(theirs / count));
    EXPECT_LT(std::sqrt(ours / count), 0.35 * 9.0);
    EXPECT_LT(std::sqrt(apart / count), 0.2 * 9.0) << "two passes are not quite one";
}

TEST(SurfaceCleanup, MirroredInputGivesMirroredOutput) {
    // Narrower than the filter, and touching every edge of the picture, among others.
    for (const int width : {3, 5, 64}) {
        Scene scene(width, 40);
        Scene mirrored(width, 40);
        std::mt19937 random(static_cast<unsigned>(width));
        std::uniform_int_distribution<int> near(1980, 2020);
        for (int row = 0; row < 40; ++row) {
            for (int column = 0; column < width; ++column) {
                const auto value = static_cast<std::uint16_t>(random() % 8 == 0 ? 0 : near(random));
                const auto label = static_cast<std::uint8_t>(random() % 16 == 0 ? 2 : 1);
                scene.at(column, row) = mirrored.at(width - 1 - column, row) = value;
                scene.map[scene.index(column, row)] = mirrored.map[scene.index(width - 1 - column, row)] = label;
            }
        }
        SurfaceCleanupJob job = scene.surfaceJob();
        job.run();
        SurfaceCleanupJob other = mirrored.surfaceJob();
        other.run();
        EXPECT_EQ(job.filled, other.filled);
        if (width == 64) {
            EXPECT_GT(job.filled, 50);
        }
        for (int row = 0; row < 40; ++row) {
            // Sums are taken in another order, so that the last bit may round the other way.
            for (int column = 0; column < width; ++column)
                EXPECT_NEAR(scene.cleaned[scene.index(column, row)],
                            mirrored.cleaned[scene.index(width - 1 - column, row)], 1);
        }
    }
}

TEST(SurfaceCleanup, TakesNoMemoryAndGivesZeroWithoutAUser) {
    Scene scene(64, 48);
    scene.fill(10, 50, 10, 40, 2000);
    scene.fill(20, 25, 20, 25, 0);
    SurfaceCleanupJob job = scene.surfaceJob();
    const test::AllocationCounter counter;
    job.run();
    EXPECT_EQ(counter.count(), 0U);
    EXPECT_EQ(job.filled, 25);
    job.label = 2;
    job.run();
    EXPECT_EQ(*std::max_element(scene.cleaned.begin(), scene.cleaned.end()), 0);
    EXPECT_EQ(job.filled, 0);
}

}  // namespace
}  // namespace cheval::fitting::tracking

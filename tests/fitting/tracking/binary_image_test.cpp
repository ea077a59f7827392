// Our own allocation-free filters against OpenCV, on masks drawn at random and on shapes.
#include "fitting/tracking/binary_image.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace cheval::fitting::tracking {
namespace {

/// Twice the signed area of a polygon of cell centres.
long doubledArea(std::span<const Cell> polygon) {
    long sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Cell& a = polygon[i];
        const Cell& b = polygon[(i + 1) % polygon.size()];
        sum += static_cast<long>(a.x) * b.y - static_cast<long>(b.x) * a.y;
    }
    return sum;
}

/// Overlapping discs and bars: hand-like blobs, now and then in several pieces. The rim stays clear.
HandMask randomMask(unsigned seed) {
    std::mt19937 random(seed);
    cv::Mat picture(kHandGrid, kHandGrid, CV_8UC1, cv::Scalar(0));
    std::uniform_int_distribution<int> place(8, kHandGrid - 9);
    std::uniform_int_distribution<int> size(1, 12);
    for (int k = 0; k < 6; ++k) {
        cv::circle(picture, {place(random), place(random)}, size(random), 1, -1);
        cv::line(picture, {place(random), place(random)}, {place(random), place(random)}, 1, size(random) / 3 + 1);
    }
    for (int k = 0; k < 40; ++k) {
        picture.at<std::uint8_t>(place(random), place(random)) ^= 1;
    }
    cv::rectangle(picture, {0, 0}, {kHandGrid - 1, kHandGrid - 1}, 0, 1);
    HandMask mask;
    std::copy(picture.begin<std::uint8_t>(), picture.end<std::uint8_t>(), mask.begin());
    return mask;
}

cv::Mat asMat(HandMask& mask) {
    return {kHandGrid, kHandGrid, CV_8UC1, mask.data()};
}

class RandomMask : public testing::TestWithParam<unsigned> {};

TEST_P(RandomMask, IsDilatedAndErodedAsTheReferenceDoes) {
    HandMask mask = randomMask(GetParam());
    HandMask ours;
    cv::Mat reference;
    const cv::Rect inner(1, 1, kHandGrid - 2, kHandGrid - 2);
    dilate(mask, ours);
    cv::dilate(asMat(mask), reference, cv::Mat::ones(3, 3, CV_8U));
    EXPECT_EQ(cv::countNonZero(asMat(ours)(inner) != reference(inner)), 0);
    erode(mask, ours);
    cv::erode(asMat(mask), reference, cv::Mat::ones(3, 3, CV_8U));
    EXPECT_EQ(cv::countNonZero(asMat(ours)(inner) != reference(inner)), 0);
}

TEST_P(RandomMask, HasTheReferencesContourAndHull) {
    HandMask mask = randomMask(GetParam());
    const auto first = std::find(mask.begin(), mask.end(), std::uint8_t{1});
    ASSERT_NE(first, mask.end());
    // One 8-connected component: ours traces the one with the first cell, the reference lists all, that one last.
    std::vector<Cell> contour(4096);
    contour.resize(traceContour(mask, contour));
    std::vector<std::vector<cv::Point>> references;
    cv::findContours(asMat(mask).clone(), references, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    const auto place = static_cast<int>(first - mask.begin());
    const cv::Point start(place % kHandGrid, place / kHandGrid);
    const auto reference = std::find_if(references.begin(), references.end(), [&](const auto& candidate) {
        return std::find(candidate.begin(), candidate.end(), start) != candidate.end();
    });
    ASSERT_NE(reference, references.end());
    std::vector<cv::Point> ours;
    ours.reserve(contour.size());
    for (const Cell cell : contour) {
        ours.emplace_back(cell.x, cell.y);
    }
    EXPECT_EQ(ours.size(), reference->size());
    EXPECT_NEAR(std::abs(static_cast<double>(doubledArea(contour))) / 2.0, cv::contourArea(*reference), 1e-6);
    EXPECT_TRUE(std::is_permutation(ours.begin(), ours.end(), reference->begin(), reference->end()));

    std::vector<Cell> sorted(contour.size());
    std::vector<Cell> hull(contour.size() + 1);
    hull.resize(convexHull(contour, sorted, hull));
    std::vector<cv::Point> referenceHull;
    cv::convexHull(*reference, referenceHull);
    EXPECT_NEAR(std::abs(static_cast<double>(doubledArea(hull))) / 2.0, cv::contourArea(referenceHull), 1e-6);
    EXPECT_EQ(hull.size(), referenceHull.size());
}

TEST_P(RandomMask, HullContainsEveryContourCell) {
    const HandMask mask = randomMask(GetParam());
    std::vector<Cell> contour(4096);
    contour.resize(traceContour(mask, contour));
    std::vector<Cell> sorted(contour.size());
    std::vector<Cell> hull(contour.size() + 1);
    hull.resize(convexHull(contour, sorted, hull));
    ASSERT_GE(hull.size(), 1U);
    for (const Cell cell : contour) {
        for (std::size_t i = 0; i < hull.size(); ++i) {
            const Cell a = hull[i];
            const Cell b = hull[(i + 1) % hull.size()];
            EXPECT_GE((b.x - a.x) * (cell.y - a.y) - (b.y - a.y) * (cell.x - a.x), 0);
        }
    }
}

TEST_P(RandomMask, KeepsExactlyOneComponent) {
    HandMask mask = randomMask(GetParam());
    cv::Mat labels;
    cv::connectedComponents(asMat(mask), labels, 4);
    const auto first = static_cast<int>(std::find(mask.begin(), mask.end(), std::uint8_t{1}) - mask.begin());
    const int wanted = labels.at<int>(first / kHandGrid, first % kHandGrid);
    std::vector<Cell> scratch(kHandCells);
    const int count = keepComponent(
        mask, {static_cast<std::int16_t>(first % kHandGrid), static_cast<std::int16_t>(first / kHandGrid)},
        std::span<Cell, kHandCells>(scratch.data(), kHandCells));
    EXPECT_EQ(count, cv::countNonZero(labels == wanted));
    EXPECT_EQ(cv::countNonZero((labels == wanted) != (asMat(mask) * 255)), 0);
}

TEST_P(RandomMask, DistancesAreWithinChamferErrorOfTheTrueOnes) {
    HandMask mask = randomMask(GetParam());
    std::vector<float> distance(kHandCells);
    distanceInside(mask, std::span<float, kHandCells>(distance.data(), kHandCells));
    cv::Mat reference;
    cv::distanceTransform(asMat(mask), reference, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    for (std::size_t i = 0; i < kHandCells; ++i) {
        const float exact = reference.at<float>(static_cast<int>(i) / kHandGrid, static_cast<int>(i) % kHandGrid);
        EXPECT_GE(distance[i], exact - 1e-3F);
        EXPECT_LE(distance[i], exact * 1.09F + 1e-3F);
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomMask, testing::Range(1U, 25U));

TEST(Contour, OfNothingIsEmptyAndOfOneCellIsThatCell) {
    HandMask mask{};
    std::vector<Cell> contour(16);
    EXPECT_EQ(traceContour(mask, contour), 0U);
    mask[handIndex(40, 50)] = 1;
    ASSERT_EQ(traceContour(mask, contour), 1U);
    EXPECT_EQ(contour[0], (Cell{40, 50}));
}

TEST(Contour, StopsWhenThereIsNoMoreRoom) {
    HandMask mask{};
    for (int k = 10; k < 80; ++k) {
        mask[handIndex(k, 40)] = 1;
    }
    std::vector<Cell> contour(5);
    EXPECT_EQ(traceContour(mask, contour), 5U);
}

}  // namespace
}  // namespace cheval::fitting::tracking

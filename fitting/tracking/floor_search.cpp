#include "fitting/tracking/floor_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace cheval::fitting::tracking {
namespace {

/// Every so many cells, in columns and rows, are looked at.
constexpr int kStep = 7;
constexpr std::size_t kMostPoints = static_cast<std::size_t>(kCloudWidth / kStep + 1) * (kCloudHeight / kStep + 1);
/// Planes tried. Where a third of the lower half of the view is floor, the chance to miss it is 1 %.
constexpr int kPlanes = 120;
constexpr float kFarthest = 5.0F;
/// A point under the floor speaks against it as much as three on it speak for it.
constexpr float kUnderWeight = 3.0F;
/// The least share of all readings that must lie on it, and how far it must reach either way, metres.
constexpr float kLeastShare = 0.06F;
constexpr float kLeastReach = 0.5F;

}  // namespace

void FloorSearchJob::run() {
    found = false;
    std::array<Eigen::Vector3f, kMostPoints> points;
    std::size_t count = 0;
    for (int row = kStep / 2; row < kCloudHeight; row += kStep) {
        for (int column = kStep / 2; column < kCloudWidth; column += kStep) {
            const std::size_t i = cellIndex(column, row);
            if (cloud->depth[i] > 0.0F && cloud->depth[i] < kFarthest) points[count++] = cloud->point(i);
        }
    }
    // Floors are seen in the lower half of the view.
    const Eigen::Vector3f eye = cloud->placement.translation;
    const auto middle = std::partition(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count),
                                       [&](const Eigen::Vector3f& point) { return point.y() < eye.y(); });
    const auto lower = static_cast<std::size_t>(middle - points.begin());
    if (lower < 3) return;

    std::minstd_rand random(seed);
    const auto draw = [&] { return points[random() % lower]; };
    float best = kLeastShare * static_cast<float>(count);
    for (int plane = 0; plane < kPlanes; ++plane) {
        const Eigen::Vector3f a = draw();
        const Eigen::Vector3f b = draw();
        const Eigen::Vector3f c = draw();
        Eigen::Vector3f normal = (b - a).cross(c - a);
        if (normal.norm() < 0.02F) continue;  // Too close to each other, or in a line.
        normal.normalize();
        if (normal.y() < 0.0F) normal = -normal;
        const MountEstimate seen = mountOver(cloud->placement, normal, a);
        if (seen.height < kLowest || seen.height > kHighest || std::abs(seen.tilt) > kMostTilt ||
            std::abs(between(roll, seen.roll)) > kMostRoll) {
            continue;
        }
        float score = 0.0F;
        Eigen::AlignedBox3f on;
        for (std::size_t i = 0; i < count; ++i) {
            const float above = normal.dot(points[i] - a);
            const float band = 0.02F + 0.004F * (points[i] - eye).squaredNorm();
            if (above < -2.0F * band) {
                score -= kUnderWeight;
            } else if (above < band) {
                score += 1.0F;
                on.extend(points[i]);
            }
        }
        if (score <= best || on.sizes().x() < kLeastReach || on.sizes().z() < kLeastReach) continue;
        best = score;
        mount = seen;
        found = true;
    }
}

}  // namespace cheval::fitting::tracking

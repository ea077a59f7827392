#include "fitting/tracking/components.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace cheval::fitting::tracking {
namespace {

constexpr float kTopBand = 0.14F;
/// Bands of height in which widths are taken: from 1 m under the floor (where it is not known) upwards.
constexpr std::size_t kBands = 80;
constexpr float kBandHeight = 0.05F;
constexpr float kLowestBand = -1.0F;
constexpr float kWide = 0.85F;

std::uint32_t findRoot(std::span<std::uint32_t> parents, std::uint32_t cell) {
    while (parents[cell] != cell) {
        parents[cell] = parents[parents[cell]];
        cell = parents[cell];
    }
    return cell;
}

/// The smaller index becomes the root, so that a root is its component's first cell in raster order.
void join(std::span<std::uint32_t> parents, std::uint32_t a, std::uint32_t b) {
    a = findRoot(parents, a);
    b = findRoot(parents, b);
    if (a < b) parents[b] = a;
    if (b < a) parents[a] = b;
}

/// Sums for the plane through a component, about its first point.
struct Moments {
    Eigen::Vector3f origin = Eigen::Vector3f::Zero();
    Eigen::Vector3f first = Eigen::Vector3f::Zero();
    Eigen::Matrix3f second = Eigen::Matrix3f::Zero();

    [[nodiscard]] float roughness(int count) const {
        const Eigen::Vector3f mean = first / static_cast<float>(count);
        const Eigen::Matrix3f covariance = second / static_cast<float>(count) - mean * mean.transpose();
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
        solver.computeDirect(covariance, Eigen::EigenvaluesOnly);
        return std::sqrt(std::max(0.0F, solver.eigenvalues()[0]));
    }
};

void add(Component& component, Moments& moments, const Cloud& cloud, std::size_t cell) {
    const Eigen::Vector3f point = cloud.point(cell);
    if (component.cells == 0) moments.origin = point;
    const Eigen::Vector3f offset = point - moments.origin;
    moments.first += offset;
    moments.second += offset * offset.transpose();
    if (component.cells == 0) {
        component.lower = component.upper = point;
    } else {
        component.lower = component.lower.cwiseMin(point);
        component.upper = component.upper.cwiseMax(point);
    }
    ++component.cells;
    component.centroid += point;
    const float side = cloud.cellSize(cloud.depth[cell]);
    component.area += side * side;
    component.touchesLeft |= cellColumn(cell) < 2;
    component.touchesBottom |= cellRow(cell) >= kCloudHeight - 2;
    component.touchesRight |= cellColumn(cell) >= kCloudWidth - 2;
}

/// Which of two surfaces that meet in the picture hides the other.
void countOutlines(const Cloud& cloud, std::span<const std::uint8_t> labels, std::span<Component> components) {
    /// Shadows of the projector part what meets in the picture: as many cells are skipped.
    constexpr int kWidestShadow = 16;
    const auto meet = [&](std::size_t a, std::size_t b) {
        const float step = cloud.depth[b] - cloud.depth[a];
        if (labels[a] == labels[b] || std::abs(step) < depthTolerance(cloud.depth[a])) return;
        if (labels[a] != 0) ++(step > 0.0F ? components[labels[a]].before : components[labels[a]].behind);
        if (labels[b] != 0) ++(step < 0.0F ? components[labels[b]].before : components[labels[b]].behind);
    };
    // Wide gaps are no shadows: there the sensor reaches nothing, which lies farther than everything.
    const auto end = [&](std::size_t cell) {
        if (labels[cell] != 0) ++components[labels[cell]].before;
    };
    for (int row = 0; row < kCloudHeight; ++row) {
        int last = -1;
        for (int column = 0; column < kCloudWidth; ++column) {
            const std::size_t i = cellIndex(column, row);
            if (cloud.depth[i] <= 0.0F) continue;
            if (column - last >= kWidestShadow) {
                if (last >= 0) end(cellIndex(last, row));
                end(i);
            } else if (last >= 0) {
                meet(cellIndex(last, row), i);
            }
            if (row > 0 && cloud.depth[i - kCloudWidth] > 0.0F) meet(i - kCloudWidth, i);
            last = column;
        }
        if (last >= 0 && kCloudWidth - last >= kWidestShadow) end(cellIndex(last, row));
    }
}

}  // namespace

void ComponentsJob::run() {
    count = 0;
    for (std::uint32_t cell = 0; cell < kCloudCells; ++cell) {
        scratch[cell] = cell;
        if (mask[cell] == 0) continue;
        const float depth = cloud->depth[cell];
        const float tolerance = depthTolerance(depth);
        const auto same = [&](std::uint32_t other) {
            return mask[other] != 0 && std::abs(cloud->depth[other] - depth) < tolerance;
        };
        if (cellColumn(cell) > 0 && same(cell - 1)) join(scratch, cell - 1, cell);
        if (cell >= kCloudWidth && same(cell - kCloudWidth)) join(scratch, cell - kCloudWidth, cell);
    }
    // Sizes first, so that specks take none of the 255 numbers. Sizes are kept in the roots' own entries, marked by a
    // high bit: no second array.
    constexpr std::uint32_t kSizeMark = 0x80000000U;
    for (std::uint32_t cell = kCloudCells; cell-- > 0;) {
        if (mask[cell] != 0 && scratch[cell] != cell) scratch[cell] = findRoot(scratch, cell);
    }
    for (std::uint32_t cell = 0; cell < kCloudCells; ++cell) {
        if (mask[cell] == 0) continue;
        const std::uint32_t entry = scratch[cell];
        const bool root = entry == cell;
        if (root) {
            scratch[cell] = kSizeMark | 1U;
        } else {
            ++scratch[entry];
        }
    }
    std::array<Moments, kMaximumComponents + 1> moments{};
    for (std::uint32_t cell = 0; cell < kCloudCells; ++cell) {
        labels[cell] = 0;
        if (mask[cell] == 0) continue;
        const std::uint32_t entry = scratch[cell];
        if ((entry & kSizeMark) != 0) {
            if (static_cast<int>(entry & ~kSizeMark) >= leastCells && count < kMaximumComponents) {
                components[++count] = Component{};
                labels[cell] = static_cast<std::uint8_t>(count);
            }
        } else {
            labels[cell] = labels[entry];
        }
        if (labels[cell] != 0) add(components[labels[cell]], moments[labels[cell]], *cloud, cell);
    }
    countOutlines(*cloud, labels, components);
    float least[kMaximumComponents + 1];
    float most[kMaximumComponents + 1];
    std::fill(std::begin(least), std::end(least), 1e3F);
    std::fill(std::begin(most), std::end(most), -1e3F);
    std::array<std::array<float, kBands>, kMaximumComponents + 1> areas{};
    for (std::size_t cell = 0; cell < kCloudCells; ++cell) {
        const std::uint8_t label = labels[cell];
        if (label == 0) continue;
        const float band = std::clamp((cloud->y[cell] - kLowestBand) / kBandHeight, 0.0F, kBands - 1.0F);
        const float cellSide = cloud->cellSize(cloud->depth[cell]);
        areas[label][static_cast<std::size_t>(band)] += cellSide * cellSide;
        if (cloud->y[cell] < components[label].upper.y() - kTopBand) continue;
        least[label] = std::min(least[label], cloud->x[cell]);
        most[label] = std::max(most[label], cloud->x[cell]);
        components[label].topArea += cellSide * cellSide;
    }
    for (std::size_t i = 1; i <= count; ++i) {
        components[i].roughness = moments[i].roughness(components[i].cells);
        components[i].centroid /= static_cast<float>(components[i].cells);
        components[i].topWidth = std::max(0.0F, most[i] - least[i]);
        for (const float area : areas[i]) {
            if (area > kWide * kBandHeight) components[i].wideHeight += kBandHeight;
        }
    }
}

}  // namespace cheval::fitting::tracking

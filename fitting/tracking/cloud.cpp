#include "fitting/tracking/cloud.h"

#include <algorithm>

namespace cheval::fitting::tracking {
namespace {

/// Millimetres within which two readings of a cell count as one surface.
constexpr int kSameSurface = 60;
/// Beyond what such a sensor measures.
constexpr int kFarthest = 8000;

/// Metres, 0 for none.
float cellDepth(const std::uint16_t* upper, const std::uint16_t* lower) {
    const int values[4] = {upper[0], upper[1], lower[0], lower[1]};
    int nearest = kFarthest;
    for (const int value : values) {
        if (value > 0) nearest = std::min(nearest, value);
    }
    if (nearest >= kFarthest) return 0.0F;
    int sum = 0;
    int count = 0;
    for (const int value : values) {
        if (value > 0 && value < nearest + kSameSurface) {
            sum += value;
            ++count;
        }
    }
    return static_cast<float>(sum) / static_cast<float>(count) * 1e-3F;
}

}  // namespace

void CloudJob::run() const {
    cloud->intrinsics = intrinsics;
    cloud->placement = placement;
    const Eigen::Vector3f across = placement.rotation.col(0) / intrinsics.fx;
    const Eigen::Vector3f upwards = placement.rotation.col(1) / intrinsics.fy;
    for (int row = 0; row < kCloudHeight; ++row) {
        const std::uint16_t* upper = depth.row(2 * row);
        const std::uint16_t* lower = depth.row(2 * row + 1);
        const float v = static_cast<float>(2 * row) + 0.5F;
        const Eigen::Vector3f rowRay = upwards * (intrinsics.cy - v) + placement.rotation.col(2);
        const std::size_t base = cellIndex(0, row);
        for (int column = 0; column < kCloudWidth; ++column) {
            const std::size_t i = base + static_cast<std::size_t>(column);
            const float z = cellDepth(upper + 2 * column, lower + 2 * column);
            cloud->depth[i] = z;
            const float u = static_cast<float>(2 * column) + 0.5F - intrinsics.cx;
            cloud->x[i] = placement.translation.x() + z * (rowRay.x() + across.x() * u);
            cloud->y[i] = placement.translation.y() + z * (rowRay.y() + across.y() * u);
            cloud->z[i] = placement.translation.z() + z * (rowRay.z() + across.z() * u);
        }
    }
}

}  // namespace cheval::fitting::tracking

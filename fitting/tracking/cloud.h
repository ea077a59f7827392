// The depth picture at half size, as points in the mirror frame: what all of tracking but the hands works on.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

inline constexpr int kFrameWidth = 640;
inline constexpr int kFrameHeight = 480;
inline constexpr int kCloudWidth = kFrameWidth / 2;
inline constexpr int kCloudHeight = kFrameHeight / 2;
inline constexpr std::size_t kCloudCells = static_cast<std::size_t>(kCloudWidth) * kCloudHeight;

constexpr std::size_t cellIndex(int column, int row) {
    return static_cast<std::size_t>(row) * kCloudWidth + static_cast<std::size_t>(column);
}
constexpr int cellColumn(std::size_t cell) {
    return static_cast<int>(cell % kCloudWidth);
}
constexpr int cellRow(std::size_t cell) {
    return static_cast<int>(cell / kCloudWidth);
}

/// How far two neighbouring readings of one surface may differ at this depth: structured-light steps and noise grow
/// with the square of the distance. Metres in, metres out.
constexpr float depthTolerance(float depth) {
    return 0.045F + 0.010F * depth * depth;
}

/// One point per 2×2 pixels, structure of arrays, kCloudCells long each. `depth` is along the sensor's axis in metres,
/// 0 = no reading; x, y, z are the mirror frame's metres and mean nothing where depth is 0.
struct Cloud {
    std::vector<float> depth, x, y, z;
    hal::Intrinsics intrinsics;
    SensorPlacement placement;

    Cloud() : depth(kCloudCells), x(kCloudCells), y(kCloudCells), z(kCloudCells) {}
    [[nodiscard]] bool isValid() const {
        return depth.size() == kCloudCells && x.size() == kCloudCells && y.size() == kCloudCells &&
               z.size() == kCloudCells;
    }
    [[nodiscard]] Eigen::Vector3f point(std::size_t cell) const { return {x[cell], y[cell], z[cell]}; }
    /// Metres that one cell spans at this depth.
    [[nodiscard]] float cellSize(float metres) const { return 2.0F * metres / intrinsics.fx; }

    /// Column, row (not rounded) and depth in metres of a point of the mirror frame; depth ≤ 0: behind the sensor.
    [[nodiscard]] Eigen::Vector3f toCell(const Eigen::Vector3f& mirror) const {
        const Eigen::Vector3f sensor = placement.rotation.transpose() * (mirror - placement.translation);
        if (sensor.z() < 0.05F) return {-1.0F, -1.0F, -1.0F};
        return {(intrinsics.cx + intrinsics.fx * sensor.x() / sensor.z() - 0.5F) * 0.5F,
                (intrinsics.cy - intrinsics.fy * sensor.y() / sensor.z() - 0.5F) * 0.5F, sensor.z()};
    }
};

/// Fills a cloud from a 640×480 picture: each cell takes the mean of those of its four pixels that lie on the nearest
/// surface among them. Invalid with a picture of another size, or intrinsics that are not finite or have no focal
/// length.
struct CloudJob {
    hal::ImageView<const std::uint16_t> depth;
    hal::Intrinsics intrinsics;
    SensorPlacement placement;
    Cloud* cloud = nullptr;

    [[nodiscard]] bool isValid() const {
        return cloud != nullptr && cloud->isValid() && !depth.empty() && depth.width == kFrameWidth &&
               depth.height == kFrameHeight && intrinsics.fx > 0.0F && intrinsics.fy > 0.0F &&
               std::isfinite(intrinsics.fx + intrinsics.fy + intrinsics.cx + intrinsics.cy);
    }
    void run() const;
};

}  // namespace cheval::fitting::tracking

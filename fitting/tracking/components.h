// Connected surfaces of the depth picture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fitting/tracking/cloud.h"

namespace cheval::fitting::tracking {

inline constexpr std::size_t kMaximumComponents = 255;

/// One connected surface. Mirror frame, metres.
struct Component {
    int cells = 0;
    float area = 0.0F;  ///< Square metres as seen from the sensor.
    Eigen::Vector3f centroid = Eigen::Vector3f::Zero();
    Eigen::Vector3f lower = Eigen::Vector3f::Zero();
    Eigen::Vector3f upper = Eigen::Vector3f::Zero();
    float topWidth = 0.0F;     ///< Extent in x of what lies within 0.14 m of the highest point.
    float topArea = 0.0F;      ///< Square metres of that.
    int before = 0;            ///< Cells of its outline beyond which something farther is seen,
    int behind = 0;            ///< … or something nearer, which hides the rest of it.
    float roughness = 0.0F;    ///< Root mean square of the distances to its best plane, metres.
    float wideHeight = 0.0F;   ///< Metres of height over which it is more than 0.85 m wide, gaps not counted.
    bool touchesLeft = false;  ///< The picture's edges.
    bool touchesRight = false;
    bool touchesBottom = false;
};

/// Labels cells of `mask` that are neighbours (of four) and differ in depth by no more than depthTolerance().
/// Components of fewer than `leastCells` cells get label 0; 255 are kept, numbered from 1 in the order of their first
/// cell. Invalid unless the spans have kCloudCells elements and `components` holds 256.
struct ComponentsJob {
    const Cloud* cloud = nullptr;
    std::span<const std::uint8_t> mask;  ///< 0: leave out.
    int leastCells = 12;
    std::span<std::uint32_t> scratch;  ///< Union-find parents; kCloudCells.
    std::span<std::uint8_t> labels;    ///< Out.
    std::span<Component> components;   ///< Out: entry 0 is not used.
    std::size_t count = 0;             ///< Out: entries 1…count are.

    [[nodiscard]] bool isValid() const {
        return cloud != nullptr && cloud->isValid() && mask.size() == kCloudCells && scratch.size() == kCloudCells &&
               labels.size() == kCloudCells && components.size() > kMaximumComponents;
    }
    void run();
};

}  // namespace cheval::fitting::tracking

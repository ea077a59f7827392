#include "fitting/tracking/hand_region.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting::tracking {
namespace {

/// From the palm's centre to the wrist, over the distance from head to neck.
constexpr float kWristFactor = 0.42F;

}  // namespace

float HandRegionJob::findSurface() const {
    // The median of what lies near where the palm should be, in front of what may be behind it.
    const Eigen::Vector2f at = project(intrinsics, palm);
    const float radius = 0.22F * headToNeck * 1e3F * intrinsics.fx / palm.z();
    const int reach = std::clamp(static_cast<int>(radius), 2, 40);
    constexpr int kBins = 64;
    constexpr float kBinSize = 5.0F;
    const float first = palm.z() - 0.5F * kBinSize * kBins - 20.0F;
    std::array<int, kBins> bins{};
    int count = 0;
    const int u0 = static_cast<int>(std::lround(at.x()));
    const int v0 = static_cast<int>(std::lround(at.y()));
    for (int v = v0 - reach; v <= v0 + reach; ++v) {
        for (int u = u0 - reach; u <= u0 + reach; ++u) {
            if (!depth.contains(u, v) || depth.at(u, v) == 0) continue;
            if (!userMap.empty() && userMap.at(u, v) != label) continue;
            const int bin = static_cast<int>(std::floor((static_cast<float>(depth.at(u, v)) - first) / kBinSize));
            if (bin < 0 || bin >= kBins) continue;
            ++bins[static_cast<std::size_t>(bin)];
            ++count;
        }
    }
    if (count < 8) return 0.0F;
    int below = 0;
    for (int bin = 0; bin < kBins; ++bin) {
        below += bins[static_cast<std::size_t>(bin)];
        if (below * 10 >= count * 4) return first + (static_cast<float>(bin) + 0.5F) * kBinSize;
    }
    return 0.0F;
}

void HandRegionJob::run() {
    mask->fill(0);
    cellMetres = kSideFactor * headToNeck / static_cast<float>(kHandGrid);
    surface = findSurface();
    forearm.setZero();
    if (surface <= 0.0F) return;
    const Eigen::Vector2f centre = project(intrinsics, palm);
    pixelsPerCell = cellMetres * 1e3F * intrinsics.fx / surface;
    const Eigen::Vector3f along = palm - elbow;
    if (along.norm() > 1.0F) forearm = Eigen::Vector2f(along.x(), -along.y()) / along.norm();
    const Eigen::Vector3f axis = along.norm() > 1.0F ? Eigen::Vector3f(along / along.norm()) : Eigen::Vector3f::Zero();
    const float wrist = kWristFactor * headToNeck * 1e3F;
    const Eigen::Vector3f centreOfPalm = palmOnSurface();
    for (int row = 1; row < kHandGrid - 1; ++row) {
        for (int column = 1; column < kHandGrid - 1; ++column) {
            const Eigen::Vector2f offset(static_cast<float>(column - kHandMiddle),
                                         static_cast<float>(row - kHandMiddle));
            const int u = static_cast<int>(std::lround(centre.x() + offset.x() * pixelsPerCell));
            const int v = static_cast<int>(std::lround(centre.y() + offset.y() * pixelsPerCell));
            if (!depth.contains(u, v)) continue;
            if (!userMap.empty() && userMap.at(u, v) != label) continue;
            const auto z = static_cast<float>(depth.at(u, v));
            if (z <= surface - kNearer || z >= surface + kFarther) continue;
            // Beyond the wrist is arm, whether it comes from the side or from behind the hand.
            const Eigen::Vector3f point = unproject(intrinsics, static_cast<float>(u), static_cast<float>(v), z);
            (*mask)[handIndex(column, row)] = (point - centreOfPalm).dot(axis) > -wrist ? 1 : 0;
        }
    }
    if (!close) return;
    dilate(*mask, *scratch);
    dilate(*scratch, *mask);
    erode(*mask, *scratch);
    *mask = *scratch;
}

}  // namespace cheval::fitting::tracking

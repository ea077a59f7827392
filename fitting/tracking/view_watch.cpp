#include "fitting/tracking/view_watch.h"

#include <cmath>

namespace cheval::fitting::tracking {
namespace {

/// Shares of the picture's cells.
constexpr float kLeastReadings = 0.04F;
constexpr float kCovered = 0.5F;
/// Nearer than this nobody is wholly in view, metres.
constexpr float kClose = 0.75F;
/// The floor's share of the readings, where there is one, and how far from its plane it may seem to lie.
constexpr float kFloor = 0.05F;
constexpr float kFloorBand = 0.10F;
constexpr float kClearly = 5.0F;
/// A floor comes nearer by so much, metres, over so many rows.
constexpr float kNearer = 0.05F;
constexpr int kRows = 4;

}  // namespace

ViewFault ViewWatch::judge(const Cloud& cloud) {
    int readings = 0;
    int close = 0;
    int below = 0;
    int above = 0;
    const float height = cloud.placement.translation.y();
    const float along = cloud.placement.rotation(1, 2);
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const float depth = cloud.depth[i];
        if (depth <= 0.0F) continue;
        ++readings;
        if (depth < kClose) ++close;
        // A sensor on its head sees the floor mirrored at the line that it looks along. Unlike walls, floors come
        // nearer row by row.
        const float mirrored = 2.0F * (height + along * depth) - cloud.y[i];
        const int row = cellRow(i);
        const auto comesNearer = [&](std::size_t other) {
            return cloud.depth[other] > 0.0F && depth - cloud.depth[other] > kNearer;
        };
        if (std::abs(cloud.y[i]) < kFloorBand && row + kRows < kCloudHeight && comesNearer(i + kRows * kCloudWidth)) {
            ++below;
        }
        if (std::abs(mirrored) < kFloorBand && row >= kRows && comesNearer(i - kRows * kCloudWidth)) {
            ++above;
        }
    }
    const auto cells = static_cast<float>(kCloudCells);
    const auto seen = static_cast<float>(readings);
    if (seen < kLeastReadings * cells) return ViewFault::noReadings;
    if (static_cast<float>(close) > kCovered * cells) return ViewFault::covered;
    const auto floor = static_cast<float>(below);
    const auto ceiling = static_cast<float>(above);
    if (ceiling > kFloor * seen && ceiling > kClearly * floor) return ViewFault::upsideDown;
    return ViewFault::none;
}

void ViewWatch::update(const Cloud* cloud, hal::TimePoint time) {
    const ViewFault now = cloud == nullptr ? ViewFault::noReadings : judge(*cloud);
    if (now != seen_) {
        seen_ = now;
        since_ = time;
    }
    if (hal::seconds(time - since_) >= kBelievedAfter) fault_ = seen_;
}

}  // namespace cheval::fitting::tracking

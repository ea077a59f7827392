#include "fitting/tracking/hem.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cheval::fitting::tracking {
namespace {

/// Levels between hips and ankles that are looked at, from kFirst on; thighs touch above it.
constexpr int kLevels = 12;
constexpr int kFirst = 3;
/// Cloth that ends above this level is no skirt.
constexpr int kShortest = 5;
/// Metres by which the middle lies deeper than two legs beside it, at least.
constexpr float kValley = 0.022F;
constexpr float kReach = 0.02F;
/// The trunk's left axis along the line of sight: from here on one leg is before the other anyway.
constexpr float kMostTurned = 0.4F;
constexpr float kFollow = 0.15F;

}  // namespace

void HemFinder::look(const Cloud& cloud, const Silhouette& silhouette, const ArticulatedPose& body) {
    const Silhouette& s = silhouette;
    const auto nearestAbout = [&](const Eigen::Vector3f& at, float& depth) {
        const Eigen::Vector3f cell = cloud.toCell(at);
        const int row = static_cast<int>(std::lround(cell.y()));
        const int reach = std::max(1, static_cast<int>(std::lround(kReach / cloud.cellSize(std::max(cell.z(), 0.3F)))));
        const int middle = static_cast<int>(std::lround(cell.x()));
        depth = 0.0F;
        if (!s.contains(middle - reach, row) || !s.contains(middle + reach, row)) return false;
        for (int column = middle - reach; column <= middle + reach; ++column) {
            const std::size_t i = cellIndex(column, row);
            if (s.inside[i] != 0 && (depth <= 0.0F || s.surface[i] < depth)) depth = s.surface[i];
        }
        return true;
    };
    // In profile one leg is before the other anyway.
    if (std::abs(body.left().z()) > kMostTurned) return;
    int known = 0;
    int closed = 0;
    int lowest = 0;
    for (int level = kFirst; level < kLevels; ++level) {
        const float share = static_cast<float>(level) / kLevels;
        std::array<Eigen::Vector3f, kSideCount> at;
        for (const Side side : {Side::left, Side::right}) {
            const float thigh = body.length(BodyLength::thigh);
            const float along = share * (thigh + body.length(BodyLength::shank));
            at[index(side)] = along < thigh ? body.hip(side) + along * body.legs[index(side)].upper
                                            : body.knee(side) + (along - thigh) * body.legs[index(side)].lower;
        }
        std::array<float, 3> depth{};
        if (!nearestAbout(at[0], depth[0]) || !nearestAbout(at[1], depth[1]) ||
            !nearestAbout(0.5F * (at[0] + at[1]), depth[2])) {
            continue;
        }
        if (depth[0] <= 0.0F || depth[1] <= 0.0F) continue;
        ++known;
        if (depth[2] > 0.0F && depth[2] - 0.5F * (depth[0] + depth[1]) < kValley) {
            if (closed == known - 1) lowest = level;  // Without a gap from the hips down to here.
            ++closed;
        }
    }
    if (known < 3) return;
    const float seen = lowest >= kShortest ? 1.0F : 0.0F;
    covered_ += kFollow * (seen - covered_);
    if (seen > 0.0F) hem_ += (hem_ == 0.0F ? 1.0F : kFollow) * (static_cast<float>(lowest + 1) / kLevels - hem_);
}

}  // namespace cheval::fitting::tracking

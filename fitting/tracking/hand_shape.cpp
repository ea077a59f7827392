#include "fitting/tracking/hand_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace cheval::fitting::tracking {
namespace {

/// Fewer cells than this are a speck.
constexpr int kLeastCells = 120;
/// The palm's centre is looked for this far about the region's middle, cells.
constexpr float kPalmSearch = 24.0F;

Eigen::Vector2f toVector(Cell cell) {
    return {static_cast<float>(cell.x), static_cast<float>(cell.y)};
}

}  // namespace

bool HandShapeJob::findPalm() {
    const std::span<float, kHandCells> distance(context->distance.data(), kHandCells);
    distanceInside(*mask, distance);
    float best = 0.0F;
    Cell centre;
    for (int row = 1; row < kHandGrid - 1; ++row) {
        for (int column = 1; column < kHandGrid - 1; ++column) {
            const Eigen::Vector2f offset(static_cast<float>(column - kHandMiddle),
                                         static_cast<float>(row - kHandMiddle));
            if (offset.norm() > kPalmSearch) continue;
            // Of two equal circles the nearer to the middle.
            const float score = distance[handIndex(column, row)] - 0.12F * offset.norm();
            if (distance[handIndex(column, row)] > 1.5F && score > best) {
                best = score;
                centre = {static_cast<std::int16_t>(column), static_cast<std::int16_t>(row)};
            }
        }
    }
    if (best <= 0.0F) return false;
    shape.palm = toVector(centre);
    shape.palmRadius = distance[handIndex(centre.x, centre.y)];
    return keepComponent(*mask, centre, std::span<Cell, kHandCells>(context->cells.data(), kHandCells)) >= kLeastCells;
}

void HandShapeJob::run() {
    shape = HandShape{};
    if (!findPalm()) return;
    context->contourSize = traceContour(*mask, context->contour);
    const std::span<const Cell> contour(context->contour.data(), context->contourSize);
    context->hullSize = convexHull(contour, context->sorted, context->hull);
    if (context->hullSize < 3) return;
    measureGaps();
    countFingers();
    shape.valid = true;
}

void HandShapeJob::countFingers() {
    // Along the outline the distance from the palm rises to each fingertip and falls between two of them.
    constexpr float kTip = 1.75F;  // Palm's radii.
    constexpr float kDip = 0.35F;
    const std::span<const Cell> contour(context->contour.data(), context->contourSize);
    const bool armKnown = forearm.norm() > 0.35F;
    const auto reachAt = [&](std::size_t i) {
        const Eigen::Vector2f offset = toVector(contour[i % contour.size()]) - shape.palm;
        // The arm's own outline is no finger.
        if (armKnown && offset.dot(forearm.normalized()) < -0.6F * offset.norm()) return 0.0F;
        return offset.norm() / std::max(shape.palmRadius, 0.1F);
    };
    std::size_t lowest = 0;
    for (std::size_t i = 1; i < contour.size(); ++i) {
        if (reachAt(i) < reachAt(lowest)) lowest = i;
    }
    float low = reachAt(lowest);
    float high = low;
    bool rising = true;
    for (std::size_t k = 1; k <= contour.size(); ++k) {
        const float reach = reachAt(lowest + k);
        if (rising) {
            high = std::max(high, reach);
            if (reach > high - kDip) continue;
            if (high >= kTip && high - low >= kDip) ++shape.fingers;
            rising = false;
            low = reach;
        } else {
            low = std::min(low, reach);
            if (reach < low + kDip) continue;
            rising = true;
            high = reach;
        }
    }
}

void HandShapeJob::measureGaps() {
    const std::span<const Cell> contour(context->contour.data(), context->contourSize);
    const std::span<const Cell> hull(context->hull.data(), context->hullSize);
    const bool armKnown = forearm.norm() > 0.35F;
    const Eigen::Vector2f along = armKnown ? Eigen::Vector2f(forearm.normalized()) : Eigen::Vector2f::Zero();
    // Fingers are on the far side of the palm from the arm, thumb included; where the arm lies in the line of sight,
    // anywhere.
    const auto fingerSide = [&](const Eigen::Vector2f& point) {
        return !armKnown || (point - shape.palm).dot(along) > -0.25F * shape.palmRadius;
    };
    for (const Cell cell : contour) {
        const Eigen::Vector2f point = toVector(cell);
        if (fingerSide(point)) shape.fingerReach = std::max(shape.fingerReach, (point - shape.palm).norm());
    }
    // Hull corners are contour cells; between two of them that follow each other on the contour lies one gap.
    const auto isCorner = [&](Cell cell) { return std::find(hull.begin(), hull.end(), cell) != hull.end(); };
    const auto firstCorner = std::find_if(contour.begin(), contour.end(), isCorner);
    if (firstCorner == contour.end()) return;
    const auto start = static_cast<std::size_t>(firstCorner - contour.begin());
    Eigen::Vector2f from = toVector(*firstCorner);
    std::size_t gapStart = start;
    for (std::size_t k = 1; k <= contour.size(); ++k) {
        const std::size_t i = (start + k) % contour.size();
        if (!isCorner(contour[i])) continue;
        const Eigen::Vector2f to = toVector(contour[i]);
        const Eigen::Vector2f side = to - from;
        const float length = side.norm();
        float deepest = 0.0F;
        if (length > 0.5F) {
            for (std::size_t j = gapStart + 1; j < start + k; ++j) {
                const Eigen::Vector2f point = toVector(contour[j % contour.size()]);
                if (!fingerSide(point)) continue;
                const Eigen::Vector2f offset = point - from;
                deepest = std::max(deepest, std::abs(side.x() * offset.y() - side.y() * offset.x()) / length);
            }
        }
        if (deepest > shape.palmRadius / 3.0F) ++shape.deepGaps;
        from = to;
        gapStart = start + k;
    }
}

}  // namespace cheval::fitting::tracking

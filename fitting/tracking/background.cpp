#include "fitting/tracking/background.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting::tracking {

Background::Background() : depth_(kCloudCells), blocks_(kBlocks), waiting_(kCloudCells) {}

void Background::reset() {
    std::fill(depth_.begin(), depth_.end(), 0.0F);
    std::fill(blocks_.begin(), blocks_.end(), 0.0F);
    std::fill(waiting_.begin(), waiting_.end(), 0.0F);
}

void Background::learn(const Cloud& cloud, std::span<const Belief> belief, float elapsed) {
    constexpr float kFollow = 0.05F;
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        const float depth = cloud.depth[i];
        if (depth <= 0.0F || belief[i] == Belief::never) {
            waiting_[i] = 0.0F;
            continue;
        }
        float& known = depth_[i];
        float& waiting = waiting_[i];
        const bool farther = depth > known;
        if (known > 0.0F && std::abs(depth - known) < depthTolerance(depth)) {
            known += kFollow * (depth - known);
            waiting = 0.0F;
            continue;
        }
        // Seconds for which the cell has shown something farther, then something nearer, do not add up.
        if (farther != (waiting < 0.0F)) waiting = 0.0F;
        waiting += farther ? -elapsed : elapsed;
        const bool believed = belief[i] == Belief::atOnce || (known <= 0.0F && belief[i] == Belief::whereNew) ||
                              waiting <= -kLeaveSeconds || waiting >= kSettleSeconds;
        if (!believed) continue;
        known = depth;
        waiting = 0.0F;
    }
    std::fill(blocks_.begin(), blocks_.end(), 0.0F);
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        float& nearest = blocks_[blockOf(i)];
        if (depth_[i] > 0.0F && (nearest <= 0.0F || depth_[i] < nearest)) nearest = depth_[i];
    }
}

}  // namespace cheval::fitting::tracking

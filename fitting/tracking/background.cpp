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
        if (known > 0.0F && std::abs(depth - known) < depthTolerance(depth)) {
            known += kFollow * (depth - known);
            waiting_[i] = 0.0F;
        } else if (belief[i] == Belief::atOnce || (known <= 0.0F && belief[i] == Belief::whereNew) ||
                   (known > 0.0F && depth > known)) {
            known = depth;
            waiting_[i] = 0.0F;
        } else {
            waiting_[i] += elapsed;
            if (waiting_[i] >= kSettleSeconds) {
                known = depth;
                waiting_[i] = 0.0F;
            }
        }
    }
    std::fill(blocks_.begin(), blocks_.end(), 0.0F);
    for (std::size_t i = 0; i < kCloudCells; ++i) {
        float& nearest = blocks_[blockOf(i)];
        if (depth_[i] > 0.0F && (nearest <= 0.0F || depth_[i] < nearest)) nearest = depth_[i];
    }
}

}  // namespace cheval::fitting::tracking

// What stands still: the depth that each cell shows when nobody is before it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fitting/tracking/cloud.h"

namespace cheval::fitting::tracking {

/// The farthest surface seen in each cell, and what replaced it for long. Farther readings are believed at once (what
/// was nearer has left), nearer ones after kSettleSeconds without a person. Thread-bound.
class Background {
  public:
    Background();
    void reset();

    /// Nearer than what stands there. True where nothing is known yet.
    [[nodiscard]] bool isInFront(const Cloud& cloud, std::size_t cell) const {
        const float known = depth_[cell];
        const float depth = cloud.depth[cell];
        return known <= 0.0F || depth < known - depthTolerance(depth);
    }
    /// Learns from every cell with a reading, except those with a person (`users` not 0). Cells marked in `scenery` are
    /// believed at once. `elapsed` is the time since the frame before, in seconds.
    void learn(const Cloud& cloud, std::span<const std::uint8_t> users, std::span<const std::uint8_t> scenery,
               float elapsed);

    /// How long something must stand where it was not before until it is part of the shop.
    static constexpr float kSettleSeconds = 8.0F;

  private:
    std::vector<float> depth_;    ///< Metres; 0: not known.
    std::vector<float> waiting_;  ///< Seconds for which the cell has shown something nearer.
};

}  // namespace cheval::fitting::tracking

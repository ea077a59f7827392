// What stands still: the depth that each cell shows when nobody is before it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fitting/tracking/cloud.h"

namespace cheval::fitting::tracking {

/// How soon a reading becomes part of the shop.
enum class Belief : std::uint8_t {
    never,     ///< It is a person's.
    inTime,    ///< When it has stood for kSettleSeconds, or for kLeaveSeconds where it is farther than what was known.
    whereNew,  ///< The same, but at once where nothing has been seen before.
    atOnce
};

/// The farthest surface seen in each cell, and what replaced it for long. Cells that have shown nothing yet are taken
/// to be like the nearest of their neighbours. Thread-bound.
class Background {
  public:
    Background();
    void reset();

    /// Nearer than what stands there. True where nothing is known yet, nor about it.
    [[nodiscard]] bool isInFront(const Cloud& cloud, std::size_t cell) const {
        float known = depth_[cell];
        if (known <= 0.0F) known = blocks_[blockOf(cell)];
        const float depth = cloud.depth[cell];
        return known <= 0.0F || depth < known - depthTolerance(depth);
    }
    /// Learns from every cell with a reading; `belief` has kCloudCells elements. `elapsed` is the time since the frame
    /// before, in seconds.
    void learn(const Cloud& cloud, std::span<const Belief> belief, float elapsed);

    /// How long something must stand where it was not before until it is part of the shop.
    static constexpr float kSettleSeconds = 8.0F;
    /// How long something must have been gone. Edges and cloth with holes show what is behind them now and then.
    static constexpr float kLeaveSeconds = 0.5F;

  private:
    static constexpr int kBlock = 8;  ///< Cells.
    static constexpr int kBlockColumns = kCloudWidth / kBlock;
    static constexpr std::size_t kBlocks = kCloudCells / (kBlock * kBlock);
    static constexpr std::size_t blockOf(std::size_t cell) {
        const int row = cellRow(cell) / kBlock;
        const int column = cellColumn(cell) / kBlock;
        return static_cast<std::size_t>(row) * kBlockColumns + static_cast<std::size_t>(column);
    }

    std::vector<float> depth_;    ///< Metres; 0: not known.
    std::vector<float> blocks_;   ///< The nearest that is known in each block of cells; 0: nothing.
    std::vector<float> waiting_;  ///< Seconds for which the cell has shown something nearer; negative: farther.
};

}  // namespace cheval::fitting::tracking

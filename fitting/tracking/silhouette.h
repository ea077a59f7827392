// One person's outline and front surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fitting/tracking/cloud.h"

namespace cheval::fitting::tracking {

/// A person's cells with small holes closed, and distances to the outline. All kCloudCells long, meaningful inside the
/// rectangle only. Distances are in cells; multiply by Cloud::cellSize() for metres.
struct Silhouette {
    std::vector<std::uint8_t> inside;
    std::vector<float> surface;    ///< Depth along the sensor's axis, metres; holes bridged; 0 outside.
    std::vector<float> reach;      ///< To the nearest cell outside; the picture's edges count as inside.
    std::vector<float> limbReach;  ///< The same, but where depth jumps inside the outline there is an edge, too.
    std::vector<float> outside;    ///< From a cell outside to the nearest inside; 0 inside.
    int left = 0, right = -1, top = 0, bottom = -1;  ///< Rectangle, inclusive, with a margin about the person.
    int cells = 0;                                   ///< Inside.

    Silhouette()
        : inside(kCloudCells), surface(kCloudCells), reach(kCloudCells), limbReach(kCloudCells), outside(kCloudCells) {}
    [[nodiscard]] bool contains(int column, int row) const {
        return column >= left && column <= right && row >= top && row <= bottom;
    }
};

/// Fills a silhouette from the cells that carry `label`. Holes: runs without reading of at most `widestHole` cells in a
/// row between two cells of the person. Invalid without cloud, labels of kCloudCells and a silhouette.
struct SilhouetteJob {
    const Cloud* cloud = nullptr;
    std::span<const std::uint8_t> labels;
    std::uint8_t label = 0;
    int widestHole = 10;
    Silhouette* silhouette = nullptr;

    [[nodiscard]] bool isValid() const {
        return cloud != nullptr && cloud->isValid() && labels.size() == kCloudCells && label != 0 &&
               silhouette != nullptr;
    }
    void run() const;
};

}  // namespace cheval::fitting::tracking

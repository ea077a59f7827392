// Small binary pictures: what reading a hand's shape needs, without allocation. Cells are 0 or 1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace cheval::fitting::tracking {

/// Side of the square picture in which a hand is read. Its rim stays 0.
inline constexpr int kHandGrid = 96;
inline constexpr int kHandMiddle = kHandGrid / 2;
inline constexpr std::size_t kHandCells = static_cast<std::size_t>(kHandGrid) * kHandGrid;

using HandMask = std::array<std::uint8_t, kHandCells>;

constexpr std::size_t handIndex(int column, int row) {
    return static_cast<std::size_t>(row) * kHandGrid + static_cast<std::size_t>(column);
}

/// One cell.
struct Cell {
    std::int16_t x = 0, y = 0;
    friend bool operator==(const Cell&, const Cell&) = default;
};

/// 3×3 dilation and erosion (square) of all but the rim, which is cleared. `from` and `to` must be different.
void dilate(const HandMask& from, HandMask& to);
void erode(const HandMask& from, HandMask& to);

/// Keeps the 4-connected component that contains `start` and clears the rest; clears all where `start` is 0. Returns
/// its number of cells.
int keepComponent(HandMask& mask, Cell start, std::span<Cell, kHandCells> scratch);

/// Chamfer distance in cells from each 1 to the nearest 0.
void distanceInside(const HandMask& mask, std::span<float, kHandCells> distance);

/// The outer boundary of the component that has the first 1 in raster order: its boundary cells by Moore's neighbour
/// tracing, each visit once, 8-connected, clockwise in a picture whose rows go down. Stops when `contour` is full.
/// Returns how many.
std::size_t traceContour(const HandMask& mask, std::span<Cell> contour);

/// The convex hull of `points` (Andrew's monotone chain), counter-clockwise in axes x right, y down; corners only.
/// `sorted` is scratch as long as `points`; `hull` one longer. Returns the number of corners.
std::size_t convexHull(std::span<const Cell> points, std::span<Cell> sorted, std::span<Cell> hull);

}  // namespace cheval::fitting::tracking

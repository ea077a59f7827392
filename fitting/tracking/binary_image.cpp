#include "fitting/tracking/binary_image.h"

#include <algorithm>

namespace cheval::fitting::tracking {
namespace {

constexpr float kDiagonal = 1.41421356F;

void clearRim(HandMask& mask) {
    for (int k = 0; k < kHandGrid; ++k) {
        mask[handIndex(k, 0)] = mask[handIndex(k, kHandGrid - 1)] = 0;
        mask[handIndex(0, k)] = mask[handIndex(kHandGrid - 1, k)] = 0;
    }
}

/// Combines each 3×3 neighbourhood by `combine`, across first, then down: plain loops over rows that compilers
/// vectorise.
template <typename Combine>
void filter(const HandMask& from, HandMask& to, Combine combine) {
    HandMask across;
    across[0] = across[kHandCells - 1] = 0;
    for (std::size_t i = 1; i + 1 < kHandCells; ++i) {
        across[i] = combine(combine(from[i - 1], from[i]), from[i + 1]);
    }
    for (std::size_t i = kHandGrid; i + kHandGrid < kHandCells; ++i) {
        to[i] = combine(combine(across[i - kHandGrid], across[i]), across[i + kHandGrid]);
    }
    clearRim(to);
}

long cross(Cell origin, Cell a, Cell b) {
    return static_cast<long>(a.x - origin.x) * (b.y - origin.y) - static_cast<long>(a.y - origin.y) * (b.x - origin.x);
}

/// The eight neighbours, clockwise on the screen, from the left.
constexpr int kAround[8][2] = {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}};

}  // namespace

void dilate(const HandMask& from, HandMask& to) {
    filter(from, to, [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a | b); });
}

void erode(const HandMask& from, HandMask& to) {
    filter(from, to, [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a & b); });
}

int keepComponent(HandMask& mask, Cell start, std::span<Cell, kHandCells> scratch) {
    constexpr std::uint8_t kKept = 2;
    int count = 0;
    std::size_t waiting = 0;
    const auto visit = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= kHandGrid || y >= kHandGrid || mask[handIndex(x, y)] != 1) return;
        mask[handIndex(x, y)] = kKept;
        scratch[waiting++] = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
        ++count;
    };
    visit(start.x, start.y);
    while (waiting > 0) {
        const Cell cell = scratch[--waiting];
        visit(cell.x - 1, cell.y);
        visit(cell.x + 1, cell.y);
        visit(cell.x, cell.y - 1);
        visit(cell.x, cell.y + 1);
    }
    for (std::uint8_t& cell : mask) {
        cell = cell == kKept ? 1 : 0;
    }
    return count;
}

void distanceInside(const HandMask& mask, std::span<float, kHandCells> distance) {
    const auto at = [&](int x, int y) {
        return x < 0 || y < 0 || x >= kHandGrid || y >= kHandGrid ? 0.0F : distance[handIndex(x, y)];
    };
    for (std::size_t i = 0; i < kHandCells; ++i) {
        distance[i] = mask[i] != 0 ? 1e4F : 0.0F;
    }
    for (int y = 0; y < kHandGrid; ++y) {
        for (int x = 0; x < kHandGrid; ++x) {
            float& d = distance[handIndex(x, y)];
            d = std::min({d, at(x - 1, y) + 1.0F, at(x, y - 1) + 1.0F, at(x - 1, y - 1) + kDiagonal,
                          at(x + 1, y - 1) + kDiagonal});
        }
    }
    for (int y = kHandGrid - 1; y >= 0; --y) {
        for (int x = kHandGrid - 1; x >= 0; --x) {
            float& d = distance[handIndex(x, y)];
            d = std::min({d, at(x + 1, y) + 1.0F, at(x, y + 1) + 1.0F, at(x + 1, y + 1) + kDiagonal,
                          at(x - 1, y + 1) + kDiagonal});
        }
    }
}

std::size_t traceContour(const HandMask& mask, std::span<Cell> contour) {
    const auto first = std::find_if(mask.begin(), mask.end(), [](std::uint8_t cell) { return cell != 0; });
    if (first == mask.end() || contour.empty()) return 0;
    const auto place = static_cast<int>(first - mask.begin());
    const Cell start{static_cast<std::int16_t>(place % kHandGrid), static_cast<std::int16_t>(place / kHandGrid)};
    const auto filled = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < kHandGrid && y < kHandGrid && mask[handIndex(x, y)] != 0;
    };
    // Before the first 1 in raster order lies a 0 to its left: the search begins there and goes clockwise.
    Cell at = start;
    int backtrack = 0;
    std::size_t count = 0;
    int firstStep = -1;
    while (count < contour.size()) {
        int step = -1;
        for (int k = 0; k < 8; ++k) {
            const int candidate = (backtrack + k) % 8;
            if (filled(at.x + kAround[candidate][0], at.y + kAround[candidate][1])) {
                step = candidate;
                break;
            }
        }
        if (step < 0) {
            contour[count++] = at;  // A single cell.
            break;
        }
        // Back at the start and about to leave it the same way: the round is closed.
        if (at == start && step == firstStep) break;
        if (firstStep < 0) firstStep = step;
        contour[count++] = at;
        at = {static_cast<std::int16_t>(at.x + kAround[step][0]), static_cast<std::int16_t>(at.y + kAround[step][1])};
        // The last 0 that was looked at, seen from the new cell: a quarter turn back after a straight step, a quarter
        // and an eighth after a diagonal one.
        backtrack = step % 2 == 0 ? (step + 6) % 8 : (step + 5) % 8;
    }
    return count;
}

std::size_t convexHull(std::span<const Cell> points, std::span<Cell> sorted, std::span<Cell> hull) {
    const std::size_t n = points.size();
    if (n == 0 || sorted.size() < n || hull.size() < n + 1) return 0;
    std::copy(points.begin(), points.end(), sorted.begin());
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n),
              [](Cell a, Cell b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    const auto end = std::unique(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n));
    const auto unique = static_cast<std::size_t>(end - sorted.begin());
    if (unique == 1) {
        hull[0] = sorted[0];
        return 1;
    }
    std::size_t count = 0;
    const auto push = [&](Cell cell, std::size_t least) {
        while (count >= least + 2 && cross(hull[count - 2], hull[count - 1], cell) <= 0)
            --count;
        hull[count++] = cell;
    };
    for (std::size_t i = 0; i < unique; ++i) {
        push(sorted[i], 0);
    }
    const std::size_t lowerEnd = count - 1;
    for (std::size_t i = unique - 1; i-- > 0;) {
        push(sorted[i], lowerEnd);
    }
    return count - 1;
}

}  // namespace cheval::fitting::tracking

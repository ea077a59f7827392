#include "fitting/tracking/silhouette.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting::tracking {
namespace {

constexpr float kFar = 1e4F;
constexpr float kDiagonal = 1.41421356F;
/// Cells about the person in which `outside` is known.
constexpr int kMargin = 24;

/// One line of the chamfer: what the line before (above or below) and then the neighbour on one side allow.
void relaxLine(float* line, const float* before, int count) {
    for (int k = 0; k < count; ++k) {
        line[k] = std::min(line[k], before[k] + 1.0F);
    }
    for (int k = 1; k < count; ++k) {
        line[k] = std::min(line[k], before[k - 1] + kDiagonal);
    }
    for (int k = 0; k + 1 < count; ++k) {
        line[k] = std::min(line[k], before[k + 1] + kDiagonal);
    }
}

/// Two-pass chamfer distance inside the silhouette's rectangle, to the nearest zero. Beyond the rectangle nothing is
/// known: whoever wants zeroes there puts them on its rim.
void chamfer(const Silhouette& s, std::vector<float>& distance) {
    const int count = s.right - s.left + 1;
    for (int row = s.top; row <= s.bottom; ++row) {
        float* line = &distance[cellIndex(s.left, row)];
        if (row > s.top) relaxLine(line, line - kCloudWidth, count);
        for (int k = 1; k < count; ++k) {
            line[k] = std::min(line[k], line[k - 1] + 1.0F);
        }
    }
    for (int row = s.bottom; row >= s.top; --row) {
        float* line = &distance[cellIndex(s.left, row)];
        if (row < s.bottom) relaxLine(line, line + kCloudWidth, count);
        for (int k = count - 1; k-- > 0;) {
            line[k] = std::min(line[k], line[k + 1] + 1.0F);
        }
    }
}

void findRectangle(std::span<const std::uint8_t> labels, std::uint8_t label, Silhouette& s) {
    s.left = kCloudWidth;
    s.top = kCloudHeight;
    s.right = s.bottom = -1;
    for (int row = 0; row < kCloudHeight; ++row) {
        for (int column = 0; column < kCloudWidth; ++column) {
            if (labels[cellIndex(column, row)] != label) continue;
            s.left = std::min(s.left, column);
            s.right = std::max(s.right, column);
            s.top = std::min(s.top, row);
            s.bottom = std::max(s.bottom, row);
        }
    }
    if (s.right < 0) return;
    s.left = std::max(0, s.left - kMargin);
    s.top = std::max(0, s.top - kMargin);
    s.right = std::min(kCloudWidth - 1, s.right + kMargin);
    s.bottom = std::min(kCloudHeight - 1, s.bottom + kMargin);
}

}  // namespace

void SilhouetteJob::run() const {
    Silhouette& s = *silhouette;
    findRectangle(labels, label, s);
    s.cells = 0;
    for (int row = s.top; row <= s.bottom; ++row) {
        int last = -1;  // Column of the person's last cell in this row.
        for (int column = s.left; column <= s.right; ++column) {
            const std::size_t i = cellIndex(column, row);
            const bool mine = labels[i] == label;
            s.inside[i] = mine ? 1 : 0;
            s.surface[i] = mine ? cloud->depth[i] : 0.0F;
            if (cloud->depth[i] > 0.0F && !mine) last = -1;
            if (!mine) continue;
            ++s.cells;
            if (last >= 0 && column - last > 1 && column - last <= widestHole + 1) {
                const float from = s.surface[cellIndex(last, row)];
                for (int k = last + 1; std::abs(from - s.surface[i]) < 0.15F && k < column; ++k) {
                    s.inside[cellIndex(k, row)] = 1;
                    s.surface[cellIndex(k, row)] = 0.5F * (from + s.surface[i]);
                    ++s.cells;
                }
            }
            last = column;
        }
    }
    for (int row = s.top; row <= s.bottom; ++row) {
        for (int column = s.left; column <= s.right; ++column) {
            const std::size_t i = cellIndex(column, row);
            s.reach[i] = s.inside[i] != 0 ? kFar : 0.0F;
            s.outside[i] = s.inside[i] != 0 ? 0.0F : kFar;
            bool edge = s.inside[i] == 0;
            if (!edge) {
                const float jump = 1.6F * depthTolerance(s.surface[i]);
                if (column > s.left && s.inside[i - 1] != 0) edge |= std::abs(s.surface[i] - s.surface[i - 1]) > jump;
                if (row > s.top && s.inside[i - kCloudWidth] != 0) {
                    edge |= std::abs(s.surface[i] - s.surface[i - kCloudWidth]) > jump;
                }
            }
            s.limbReach[i] = edge ? 0.0F : kFar;
        }
    }
    chamfer(s, s.reach);
    chamfer(s, s.limbReach);
    chamfer(s, s.outside);
}

}  // namespace cheval::fitting::tracking

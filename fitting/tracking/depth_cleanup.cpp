#include "fitting/tracking/depth_cleanup.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting::tracking {
namespace {

/// The index of the pixel that stands in for one beyond the edge: −1 → 1, size → size − 2.
int mirrored(int i, int size) {
    if (i < 0) i = -i;
    return i < size ? i : 2 * size - 2 - i;
}

}  // namespace

float DepthCleanupJob::findMean() const {
    std::uint64_t sum = 0;
    std::uint64_t count = 0;
    for (int row = 0; row < depth.height; ++row) {
        for (int column = 0; column < depth.width; ++column) {
            if (userMap.at(column, row) != label || depth.at(column, row) == 0) continue;
            sum += depth.at(column, row);
            ++count;
        }
    }
    return count == 0 ? 0.0F : static_cast<float>(static_cast<double>(sum) / static_cast<double>(count));
}

void DepthCleanupJob::run() {
    mean = findMean();
    // Half of a symmetric kernel: middle, next, outermost; they sum to 1.
    std::array<float, 3> kernel{1.0F, std::exp(-0.5F / (sigma * sigma)), std::exp(-2.0F / (sigma * sigma))};
    const float total = kernel[0] + 2.0F * (kernel[1] + kernel[2]);
    for (float& weight : kernel) {
        weight /= total;
    }
    const int width = depth.width;
    const int height = depth.height;
    for (int row = 0; row < height; ++row) {
        float* out = scratch.data() + static_cast<std::ptrdiff_t>(row) * width;
        for (int column = 0; column < width; ++column) {
            const auto at = [&](int offset) { return filled(mirrored(column + offset, width), row); };
            out[column] = kernel[0] * at(0) + kernel[1] * (at(-1) + at(1)) + kernel[2] * (at(-2) + at(2));
        }
    }
    for (int row = 0; row < height; ++row) {
        const auto line = [&](int offset) {
            return scratch.data() + static_cast<std::ptrdiff_t>(mirrored(row + offset, height)) * width;
        };
        const float* rows[5] = {line(-2), line(-1), line(0), line(1), line(2)};
        std::uint16_t* out = cleaned.row(row);
        for (int column = 0; column < width; ++column) {
            const float value = kernel[0] * rows[2][column] + kernel[1] * (rows[1][column] + rows[3][column]) +
                                kernel[2] * (rows[0][column] + rows[4][column]);
            // Depth is never negative, so that adding a half and cutting off rounds; lround would cost a call a pixel.
            out[column] = static_cast<std::uint16_t>(value + 0.5F);  // NOLINT(bugprone-incorrect-roundings)
        }
    }
}

namespace {

constexpr int kTaps = 2 * SurfaceCleanupJob::kReach + 1;
/// A Gaussian of 1.6 pixels.
constexpr std::array<float, kTaps> kSpatial = {0.1724F, 0.4578F, 0.8226F, 1.0F, 0.8226F, 0.4578F, 0.1724F};

/// The middle of `tap(−kReach) … tap(kReach)`, averaged over those that lie on its surface. The range weight is a
/// parabola, which is as good as a Gaussian and takes no exp(); what has no reading (0) is out of range by itself.
template <typename Tap>
float bilateral(float middle, const Tap& tap) {
    const float range = SurfaceCleanupJob::surfaceRange(middle);
    const float scale = 1.0F / (range * range);
    float sum = 0.0F;
    float total = 0.0F;
    for (int k = 0; k < kTaps; ++k) {
        const float value = tap(k - SurfaceCleanupJob::kReach);
        const float away = value - middle;
        const float weight = kSpatial[static_cast<std::size_t>(k)] * std::max(0.0F, 1.0F - away * away * scale);
        sum += weight * value;
        total += weight;
    }
    return middle > 0.0F ? sum / total : 0.0F;
}

bool sameSurface(std::uint16_t a, std::uint16_t b, int apart) {
    // Across a hole a surface may slope, too: twice the range, and a millimetre a pixel.
    const auto nearer = static_cast<float>(std::min(a, b));
    return static_cast<float>(std::abs(a - b)) <=
           2.0F * SurfaceCleanupJob::surfaceRange(nearer) + static_cast<float>(apart);
}

}  // namespace

SurfaceCleanupJob::Box SurfaceCleanupJob::findUser() const {
    Box box{.left = depth.width, .right = -1, .top = depth.height, .bottom = -1};
    for (int row = 0; row < depth.height; ++row) {
        const std::uint8_t* begin = userMap.row(row);
        const std::uint8_t* end = begin + depth.width;
        const std::uint8_t* first = std::find(begin, end, label);
        if (first == end) continue;
        const std::uint8_t* last = end - 1;
        while (*last != label)
            --last;
        box.left = std::min(box.left, static_cast<int>(first - begin));
        box.right = std::max(box.right, static_cast<int>(last - begin));
        box.top = std::min(box.top, row);
        box.bottom = row;
    }
    return box;
}

void SurfaceCleanupJob::run() {
    for (int row = 0; row < depth.height; ++row)
        std::fill_n(cleaned.row(row), depth.width, std::uint16_t{0});
    filled = 0;
    const Box box = findUser();
    if (box.right < box.left) return;
    for (int row = box.top; row <= box.bottom; ++row) {
        for (int column = box.left; column <= box.right; ++column)
            cleaned.at(column, row) = isUser(column, row) ? depth.at(column, row) : std::uint16_t{0};
    }
    if (widestHole > 0) fillHoles(box);
    smoothRows(box);
    smoothColumns(box);
}

void SurfaceCleanupJob::fillHoles(const Box& box) {
    // Only what was read closes a hole in, never what was filled, so that the order of filling does not matter.
    for (int row = box.top; row <= box.bottom; ++row) {
        int last = -1;
        for (int column = box.left; column <= box.right; ++column) {
            if (depth.at(column, row) == 0) continue;
            const bool user = isUser(column, row);
            if (user && last >= 0 && column - last > 1 && column - last - 1 <= widestHole) {
                for (int hole = last + 1; hole < column; ++hole) {
                    const float value = bridge(hole, row, last, column);
                    if (value <= 0.0F) continue;
                    cleaned.at(hole, row) =
                        static_cast<std::uint16_t>(value + 0.5F);  // NOLINT(bugprone-incorrect-roundings)
                    ++filled;
                }
            }
            last = user ? column : -1;
        }
    }
}

float SurfaceCleanupJob::bridge(int column, int row, int before, int after) const {
    const auto end = [&](int step) {
        int at = row + step;
        for (int gone = 0; gone < widestHole && at >= 0 && at < depth.height && depth.at(column, at) == 0; ++gone)
            at += step;
        return at >= 0 && at < depth.height && isUser(column, at) ? at : -1;
    };
    const int above = end(-1);
    const int below = end(1);
    if (above < 0 || below < 0 || below - above - 1 > widestHole) return 0.0F;
    float sum = 0.0F;
    float total = 0.0F;
    const auto join = [&](std::uint16_t first, std::uint16_t second, int gone, int apart) {
        if (!sameSurface(first, second, apart)) return;
        const float weight = 1.0F / static_cast<float>(apart);
        const float share = static_cast<float>(gone) * weight;
        sum += weight * (static_cast<float>(first) * (1.0F - share) + static_cast<float>(second) * share);
        total += weight;
    };
    join(depth.at(before, row), depth.at(after, row), column - before, after - before);
    join(depth.at(column, above), depth.at(column, below), row - above, below - above);
    return total > 0.0F ? sum / total : 0.0F;
}

void SurfaceCleanupJob::smoothRows(const Box& box) {
    for (int row = box.top; row <= box.bottom; ++row) {
        const std::uint16_t* in = cleaned.row(row);
        float* out = scratch.data() + static_cast<std::ptrdiff_t>(row) * depth.width;
        const auto at = [&](int column) {
            return column >= 0 && column < depth.width ? static_cast<float>(in[column]) : 0.0F;
        };
        const int left = std::max(box.left, kReach);
        const int right = std::min(box.right, depth.width - 1 - kReach);
        for (int column = box.left; column < std::min(left, box.right + 1); ++column)
            out[column] = bilateral(at(column), [&](int k) { return at(column + k); });
        for (int column = left; column <= right; ++column) {
            out[column] =
                bilateral(static_cast<float>(in[column]), [&](int k) { return static_cast<float>(in[column + k]); });
        }
        for (int column = std::max(right + 1, left); column <= box.right; ++column)
            out[column] = bilateral(at(column), [&](int k) { return at(column + k); });
    }
}

void SurfaceCleanupJob::smoothColumns(const Box& box) {
    for (int row = box.top; row <= box.bottom; ++row) {
        // Beyond the box there is no reading.
        std::array<const float*, kTaps> lines{};
        std::array<float, kTaps> share{};
        for (int k = 0; k < kTaps; ++k) {
            const int at = row + k - kReach;
            const bool inside = at >= box.top && at <= box.bottom;
            lines[static_cast<std::size_t>(k)] =
                scratch.data() + static_cast<std::ptrdiff_t>(inside ? at : row) * depth.width;
            share[static_cast<std::size_t>(k)] = inside ? 1.0F : 0.0F;
        }
        const float* middle = lines[kReach];
        std::uint16_t* out = cleaned.row(row);
        for (int column = box.left; column <= box.right; ++column) {
            const float value = bilateral(middle[column], [&](int k) {
                const int tap = k + kReach;
                return share[static_cast<std::size_t>(tap)] * lines[static_cast<std::size_t>(tap)][column];
            });
            out[column] = static_cast<std::uint16_t>(value + 0.5F);  // NOLINT(bugprone-incorrect-roundings)
        }
    }
}

}  // namespace cheval::fitting::tracking

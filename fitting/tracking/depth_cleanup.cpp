#include "fitting/tracking/depth_cleanup.h"

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

}  // namespace cheval::fitting::tracking

#include "hal/shrink.h"

#include <algorithm>
#include <cstddef>

namespace cheval::hal {

void shrink(ImageView<const Rgba8> from, ImageView<Rgba8> to, std::vector<std::uint32_t>& sums) {
    const auto sourceWidth = static_cast<std::size_t>(from.width);
    sums.resize(sourceWidth * 3);
    for (int y = 0; y < to.height; ++y) {
        const int top = static_cast<int>(std::int64_t{y} * from.height / to.height);
        // At least one row and column each, where the target is the larger one.
        const int bottom = std::max(static_cast<int>((std::int64_t{y} + 1) * from.height / to.height), top + 1);
        std::fill(sums.begin(), sums.end(), 0U);
        for (int sourceY = top; sourceY < bottom; ++sourceY) {
            const Rgba8* const row = from.row(sourceY);
            for (std::size_t x = 0; x < sourceWidth; ++x) {
                sums[3 * x] += row[x].r;
                sums[3 * x + 1] += row[x].g;
                sums[3 * x + 2] += row[x].b;
            }
        }
        for (int x = 0; x < to.width; ++x) {
            const auto left = static_cast<std::size_t>(std::int64_t{x} * from.width / to.width);
            const auto right =
                std::max(static_cast<std::size_t>((std::int64_t{x} + 1) * from.width / to.width), left + 1);
            std::uint32_t r = 0;
            std::uint32_t g = 0;
            std::uint32_t b = 0;
            for (std::size_t sourceX = left; sourceX < right; ++sourceX) {
                r += sums[3 * sourceX];
                g += sums[3 * sourceX + 1];
                b += sums[3 * sourceX + 2];
            }
            const std::uint32_t count =
                std::max(static_cast<std::uint32_t>(right - left) * static_cast<std::uint32_t>(bottom - top), 1U);
            const auto mean = [count](std::uint32_t sum) {
                return static_cast<std::uint8_t>((sum + count / 2) / count);
            };
            to.at(x, y) = {.r = mean(r), .g = mean(g), .b = mean(b), .a = 255};
        }
    }
}

}  // namespace cheval::hal

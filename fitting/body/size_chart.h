// Which body girths a size is for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fitting/advice.h"
#include "fitting/body.h"

namespace cheval::fitting {

/// Whom a garment is cut for: the same letter is another girth.
enum class SizesFor : std::uint8_t { women, men };
inline constexpr std::size_t kSizesForCount = 2;

/// Greatest number of sizes in a chart.
inline constexpr std::size_t kMaximumSizes = 16;

/// Sizes as bands of body girths. Immutable once made. Whoever makes one sees to it that edges rise.
struct SizeChart {
    SizesFor sizesFor = SizesFor::women;
    std::vector<SizeName> sizes;  ///< From the smallest, at most kMaximumSizes.
    /// By Dimension, metres: size i is for girths greater than edges[i] and up to edges[i + 1]. Empty where the chart
    /// does not go by that dimension, else one more than `sizes`.
    std::array<std::vector<float>, kDimensionCount> edges;

    [[nodiscard]] const std::vector<float>& of(Dimension dimension) const {
        return edges[static_cast<std::size_t>(dimension)];
    }
};

}  // namespace cheval::fitting

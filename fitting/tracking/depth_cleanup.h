// The depth picture of one user, without holes and smoothed (D10).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "hal/image.h"

namespace cheval::fitting::tracking {

/// D10 as its source has it (equations 8.1 and 8.2): pixels that are not the user's, and pixels without a reading, take
/// the mean depth of the user's pixels; then a 5×5 Gaussian. At the picture's edges rows and columns are mirrored about
/// the outermost one. Millimetres in, millimetres out. Without a single user pixel the result is 0 throughout. Invalid
/// unless all pictures have one size of at least 3×3, `scratch` has a value for each pixel, and sigma is positive.
struct DepthCleanupJob {
    hal::ImageView<const std::uint16_t> depth;
    hal::ImageView<const std::uint8_t> userMap;
    std::uint8_t label = 0;
    float sigma = 1.1F;  ///< Pixels.
    std::span<float> scratch;
    hal::ImageView<std::uint16_t> cleaned;  ///< Out.

    float mean = 0.0F;  ///< Out: millimetres.

    [[nodiscard]] bool isValid() const {
        return !depth.empty() && depth.width >= 3 && depth.height >= 3 && userMap.data != nullptr &&
               userMap.width == depth.width && userMap.height == depth.height && cleaned.data != nullptr &&
               cleaned.width == depth.width && cleaned.height == depth.height && label != 0 && sigma > 0.0F &&
               scratch.size() >= static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height);
    }
    void run();

  private:
    [[nodiscard]] float filled(int column, int row) const {
        return userMap.at(column, row) == label && depth.at(column, row) != 0
                   ? static_cast<float>(depth.at(column, row))
                   : mean;
    }
    [[nodiscard]] float findMean() const;
};

}  // namespace cheval::fitting::tracking

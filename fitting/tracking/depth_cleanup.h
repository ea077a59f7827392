// The depth picture of one user, without holes and smoothed (D10): as the source has it, and so that edges stay.
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

/// The same purpose without its two faults: the mean depth is no surface, and a Gaussian draws edges towards it.
/// First, runs without a reading take values between their ends, if they lie within the user: closed in by the user's
/// readings along the row and along the column, at most `widestHole` pixels apart, and at least one pair of ends on one
/// surface (two pairs: their mean, the nearer pair weighing more). Gaps between limbs are open at an end and stay. Then
/// a bilateral filter in two passes, rows and columns (Pham and van Vliet, Separable Bilateral Filtering for Fast Video
/// Preprocessing, ICME 2005), whose range is that of structured light's noise at each reading's distance (Khoshelham
/// and Elberink, Sensors 12(2), 2012). Millimetres in, millimetres out; 0 where nobody is, or nothing is known. Invalid
/// unless all pictures have one size of at least 3×3, `scratch` has a value for each pixel, and widestHole is not
/// negative.
struct SurfaceCleanupJob {
    hal::ImageView<const std::uint16_t> depth;
    hal::ImageView<const std::uint8_t> userMap;
    std::uint8_t label = 0;
    int widestHole = 16;  ///< Pixels; 0 fills nothing.
    std::span<float> scratch;
    hal::ImageView<std::uint16_t> cleaned;  ///< Out.

    int filled = 0;  ///< Out: pixels without a reading that were given one.

    [[nodiscard]] bool isValid() const {
        return !depth.empty() && depth.width >= 3 && depth.height >= 3 && userMap.data != nullptr &&
               userMap.width == depth.width && userMap.height == depth.height && cleaned.data != nullptr &&
               cleaned.width == depth.width && cleaned.height == depth.height && label != 0 && widestHole >= 0 &&
               scratch.size() >= static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height);
    }
    void run();

    /// Readings of one surface differ by at most this, millimetres, at a distance of `depth` millimetres: four standard
    /// deviations of the noise, and a little where it is near and the slope is all.
    static constexpr float surfaceRange(float depth) { return 8.0F + 6e-6F * depth * depth; }
    /// Pixels to either side that the filter reaches.
    static constexpr int kReach = 3;

  private:
    struct Box {
        int left = 0, right = -1, top = 0, bottom = -1;  ///< Inclusive.
    };
    [[nodiscard]] bool isUser(int column, int row) const {
        return userMap.at(column, row) == label && depth.at(column, row) != 0;
    }
    [[nodiscard]] Box findUser() const;
    void fillHoles(const Box& box);
    [[nodiscard]] float bridge(int column, int row, int before, int after) const;
    void smoothRows(const Box& box);
    void smoothColumns(const Box& box);
};

}  // namespace cheval::fitting::tracking

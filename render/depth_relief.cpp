#include "render/depth_relief.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cheval::render {
namespace {

/// Pixels to either side that a slope's noise is averaged over.
constexpr int kReach = 3;

/// Pixels to either side over which a slope is taken: noise grows with the distance faster than a pixel does.
int slopeReach(float depth) {
    return std::clamp(static_cast<int>(1.3e-3F * depth), 2, 6);
}

/// Millimetres between neighbouring readings of one surface: the steps of structured light grow with the square of the
/// distance (Khoshelham and Elberink, Sensors 12(2), 2012), and a surface may stand obliquely.
float sameSurface(float depth) {
    return 25.0F + 8e-6F * depth * depth;
}

/// The mean of the readings on the surface of value `i`, among `reach` before and after it, `step` apart.
float surfaceMean(const float* values, std::ptrdiff_t step, int before, int after) {
    const float own = *values;
    if (own <= 0.0F) return 0.0F;
    const float allowed = sameSurface(own);
    float sum = 0.0F;
    int count = 0;
    for (int k = -before; k <= after; ++k) {
        const float value = values[k * step];
        if (std::abs(value - own) > allowed) continue;
        sum += value;
        ++count;
    }
    return sum / static_cast<float>(count);
}

}  // namespace

void DepthRelief::smooth(hal::ImageView<const std::uint16_t> depth) {
    const int width = depth.width;
    const int height = depth.height;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    rows_.resize(pixels);
    smooth_.resize(pixels);
    for (int y = 0; y < height; ++y) {
        float* raw = smooth_.data() + static_cast<std::ptrdiff_t>(y) * width;
        float* row = rows_.data() + static_cast<std::ptrdiff_t>(y) * width;
        std::copy_n(depth.row(y), width, raw);
        for (int x = 0; x < width; ++x)
            row[x] = surfaceMean(raw + x, 1, std::min(kReach, x), std::min(kReach, width - 1 - x));
    }
    for (int y = 0; y < height; ++y) {
        const float* row = rows_.data() + static_cast<std::ptrdiff_t>(y) * width;
        float* out = smooth_.data() + static_cast<std::ptrdiff_t>(y) * width;
        for (int x = 0; x < width; ++x)
            out[x] = surfaceMean(row + x, width, std::min(kReach, y), std::min(kReach, height - 1 - y));
    }
}

hal::ImageView<const std::uint8_t> DepthRelief::light(hal::ImageView<const std::uint16_t> depth,
                                                      const hal::Intrinsics& intrinsics) {
    if (depth.empty()) return {};
    if (picture_.width != depth.width || picture_.height != depth.height) picture_.resize(depth.width, depth.height);
    smooth(depth);
    const int width = depth.width;
    const int height = depth.height;
    const auto at = [&](int x, int y) {
        return smooth_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    };
    const auto point = [&](int x, int y) -> Eigen::Vector3f {
        const float z = at(x, y);
        return {(static_cast<float>(x) - intrinsics.cx) * z / intrinsics.fx,
                (intrinsics.cy - static_cast<float>(y)) * z / intrinsics.fy, z};
    };
    // In the sensor frame: a lamp above and a little to the left of the sensor.
    const Eigen::Vector3f lamp = Eigen::Vector3f(-0.25F, 0.55F, -1.0F).normalized();
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const float z = at(x, y);
            std::uint8_t& out = picture_.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                                static_cast<std::size_t>(x)];
            if (z <= 0.0F) {
                out = kNoReading;
                continue;
            }
            // At the rim of a surface the slope is taken from the side that is left.
            const auto other = [&](int u, int v) {
                const bool inside = u >= 0 && v >= 0 && u < width && v < height;
                return inside && std::abs(at(u, v) - z) <= sameSurface(z) ? point(u, v) : point(x, y);
            };
            const int reach = slopeReach(z);
            const Eigen::Vector3f across = other(x + reach, y) - other(x - reach, y);
            const Eigen::Vector3f down = other(x, y + reach) - other(x, y - reach);
            // The sensor frame is left-handed: this order points towards the sensor for a wall that faces it.
            const Eigen::Vector3f normal = across.cross(down);
            const float length = normal.norm();
            const float lit = length > 0.0F ? std::max(0.0F, normal.dot(lamp) / length) : 0.5F;
            const float near = std::clamp(1.08F - 0.12e-3F * z, 0.45F, 1.0F);
            const float grey = 245.0F * near * (0.25F + 0.75F * lit * lit);
            out = static_cast<std::uint8_t>(std::clamp(grey, static_cast<float>(kDarkestReading), 255.0F));
        }
    }
    return std::as_const(picture_).view();
}

}  // namespace cheval::render

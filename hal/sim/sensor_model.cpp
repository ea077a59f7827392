#include "hal/sim/sensor_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "hal/sim/hash.h"
#include "hal/sim/rounding.h"

namespace cheval::hal::sim {

namespace {

constexpr int kProjectorMargin = 128;   ///< Columns left of the picture that the projector's row keeps.
constexpr float kShadowMargin = 0.75F;  ///< Disparity by which something must be nearer to cast a shadow.
constexpr float kEdge = 0.35F;          ///< Step of disparity between neighbours that is an edge and not a slope.
constexpr int kEdgeReach = 2;

/// Standard deviation of the sum of four uniform bytes.
constexpr float kBytesDeviation = 147.80F;

/// About normal, mean 0, deviation 1 (Irwin–Hall of four).
inline float bellShaped(std::uint32_t bits) {
    const std::uint32_t pairs = (bits & 0x00ff00ffU) + (bits >> 8U & 0x00ff00ffU);
    const auto sum = static_cast<std::int32_t>((pairs & 0xffffU) + (pairs >> 16U));
    return static_cast<float>(sum - 510) * (1.0F / kBytesDeviation);
}

/// Noise hangs together over about a pixel: a pair of draws is shared by neighbours.
constexpr float kPairShare = 0.70710678F;

/// Chance that light of a material's own comes back too weak.
constexpr float weakness(Material material) {
    switch (material) {
        case Material::hair:
            return 0.30F;
        case Material::darkCloth:
            return 0.05F;
        case Material::shoe:
            return 0.03F;
        case Material::glossy:
            return 0.25F;
        case Material::room:
        case Material::skin:
        case Material::cloth:
            break;
    }
    return 0.0F;
}

std::uint16_t chance(float probability) {
    return static_cast<std::uint16_t>(std::clamp(probability, 0.0F, 1.0F) * 65535.0F);
}

}  // namespace

SensorModel::SensorModel(const Intrinsics& intrinsics, const Room& room, std::uint32_t key, float noiseScale)
    : intrinsics_(intrinsics), key_(key), noiseScale_(noiseScale), focalBaseline_(intrinsics.fx * kBaselineMm) {
    const auto width = static_cast<std::size_t>(intrinsics.width);
    const std::size_t pixels = width * static_cast<std::size_t>(intrinsics.height);
    fixedNoise_.resize(pixels);
    roomDisparity_.resize(pixels);
    roomFailure_.resize(pixels);
    rowDisparity_.resize(width);
    rowFailure_.resize(width);
    projector_.resize(width + kProjectorMargin + 2);
    noise_.resize(width + 1);
    const std::uint32_t fixedKey = scramble(key, 0xf1edU);
    for (std::size_t i = 0; i < pixels; ++i) {
        const auto counter = static_cast<std::uint32_t>(i);
        fixedNoise_[i] = noiseScale * kDisparityNoise * kPairShare * kPairShare *
                         (bellShaped(scramble(fixedKey, counter)) + bellShaped(scramble(fixedKey, counter + 1)));
    }
    for (int y = 0; y < intrinsics.height; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * width;
        prepareRow(room.depth, room.material, y, 0, intrinsics.width, &roomDisparity_[row], &roomFailure_[row]);
    }
}

void SensorModel::prepareRow(const Image<float>& depth, const Image<Material>& material, int y, int from, int to,
                             float* disparity, std::uint16_t* failure) {
    const int width = intrinsics_.width;
    const float* z = depth.view().row(y);
    const Material* surface = material.view().row(y);
    for (int x = from; x < to; ++x)
        disparity[x] = z[x] > 0.0F ? focalBaseline_ / z[x] : 0.0F;

    std::fill(projector_.begin(), projector_.end(), 0.0F);
    // Rounded; what lies left of the margin is out of the projector's row.
    const auto column = [](float at) {
        const float shifted = at + (0.5F + static_cast<float>(kProjectorMargin));
        return shifted < 0.0F ? -1 : static_cast<int>(shifted);
    };
    const auto columns = static_cast<int>(projector_.size());
    int last = -1;
    float lastDisparity = 0.0F;
    // What takes a pixel's light lies to its right, by the difference of the two disparities.
    const int end = std::min(width, to + kProjectorMargin);
    for (int x = std::max(0, from - 1); x < end; ++x) {
        const float d = disparity[x];
        if (d <= 0.0F) continue;
        const int at = column(static_cast<float>(x) - d);
        if (at < 0 || at >= columns) {
            last = -1;
            continue;
        }
        projector_[static_cast<std::size_t>(at)] = std::max(projector_[static_cast<std::size_t>(at)], d);
        // One surface covers the columns between its pixels too.
        if (last >= 0 && at > last + 1 && std::abs(d - lastDisparity) < kEdge) {
            for (int gap = last + 1; gap < at; ++gap) {
                float& seen = projector_[static_cast<std::size_t>(gap)];
                seen = std::max(seen, std::min(d, lastDisparity));
            }
        }
        last = at;
        lastDisparity = d;
    }

    const int above = std::max(0, y - 1);
    const int below = std::min(intrinsics_.height - 1, y + 1);
    const float* upper = depth.view().row(above);
    const float* lower = depth.view().row(below);
    for (int x = from; x < to; ++x) {
        const float d = disparity[x];
        if (d <= 0.0F || z[x] < kNearestMm || z[x] > kFarthestMm) {
            failure[x] = 0xffffU;
            continue;
        }
        // Light of the projector that something nearer takes away; half a step to either side counts as blocked.
        const int at = column(static_cast<float>(x) - d);
        const bool seen = at >= 0 && at < columns;
        if (!seen || projector_[static_cast<std::size_t>(at)] > d + kShadowMargin) {
            failure[x] = 0xffffU;
            continue;
        }
        float probability = weakness(surface[x]);
        // Slopes: reflected light gets weak as the surface turns away. Edges: half of the window that is compared
        // shows something else.
        float slope = 0.0F;
        float edge = 0.0F;
        const auto compare = [&](float other, float weight) {
            const float step = std::abs(d - (other > 0.0F ? focalBaseline_ / other : 0.0F));
            if (step > kEdge) {
                edge = std::max(edge, weight);
            } else {
                slope = std::max(slope, step);
            }
        };
        compare(z[std::max(0, x - 1)], 0.42F);
        compare(z[std::min(width - 1, x + 1)], 0.42F);
        compare(upper[x], 0.30F);
        compare(lower[x], 0.30F);
        compare(z[std::max(0, x - kEdgeReach)], 0.06F);
        compare(z[std::min(width - 1, x + kEdgeReach)], 0.06F);
        // A step of disparity of s a pixel means a surface that recedes by about s · z / b of its breadth.
        const float recession = slope * z[x] / kBaselineMm;
        probability += edge + std::clamp((recession - 4.0F) * 0.08F, 0.0F, 0.9F);
        failure[x] = chance(noiseScale_ * probability);
    }
}

void SensorModel::senseRow(int y, std::uint32_t frameKey, const float* disparity, const std::uint16_t* failure,
                           std::uint16_t* readings) {
    const int width = intrinsics_.width;
    const std::uint32_t base = frameKey + static_cast<std::uint32_t>(y * (width + 1));
    const float* fixedNoise = &fixedNoise_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
    float* noise = noise_.data();
    for (int x = 0; x <= width; ++x)
        noise[x] = bellShaped(scramble(base + static_cast<std::uint32_t>(x)));
    // Failures come in small patches, half of them the same in every frame and half flickering.
    const std::uint32_t patchRow = scramble(key_, static_cast<std::uint32_t>(y / 2));
    const std::uint32_t flickerRow = scramble(frameKey, static_cast<std::uint32_t>(y / 2) + 0x5000U);
    const float temporal = noiseScale_ * kDisparityNoise * kPairShare * kPairShare;
    for (int x = 0; x < width; ++x) {
        const float d = disparity[x] + fixedNoise[x] + temporal * (noise[x] + noise[x + 1]);
        const std::int32_t steps = nearestWhole(d * (1.0F / kDisparityStep));
        const float z = focalBaseline_ / (std::max(1.0F, static_cast<float>(steps)) * kDisparityStep);
        const bool inRange = z >= kNearestMm && z <= kFarthestMm;
        readings[x] = static_cast<std::uint16_t>(inRange ? nearestWhole(z) : 0);
    }
    for (int x = 0; x < width; ++x) {
        if (failure[x] == 0) continue;
        if (failure[x] == 0xffffU) {
            readings[x] = 0;
            continue;
        }
        const auto patch = static_cast<std::uint32_t>(x / 2);
        const std::uint32_t mixed =
            (scramble(patchRow + patch) & 0xffffU) / 2 + (scramble(flickerRow + patch) & 0xffffU) / 2;
        // The mean of two uniform draws, made uniform again.
        const float mean = static_cast<float>(mixed) * (1.0F / 65535.0F);
        const float uniform = mean < 0.5F ? 2.0F * mean * mean : 1.0F - 2.0F * (1.0F - mean) * (1.0F - mean);
        if (uniform * 65535.0F < static_cast<float>(failure[x])) readings[x] = 0;
    }
}

void SensorModel::sense(const Image<float>& depth, const Image<Material>& material, const PixelBox& changed,
                        std::uint64_t frame, ImageView<std::uint16_t> readings) {
    const std::uint32_t frameKey =
        scramble(key_, scramble(static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(frame >> 32U)));
    const int width = intrinsics_.width;
    for (int y = 0; y < intrinsics_.height; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        const float* disparity = &roomDisparity_[row];
        const std::uint16_t* failure = &roomFailure_[row];
        if (!changed.empty() && y >= changed.top && y < changed.bottom) {
            std::copy_n(disparity, width, rowDisparity_.begin());
            std::copy_n(disparity, width, rowDisparity_.begin());
            std::copy_n(failure, width, rowFailure_.begin());
            prepareRow(depth, material, y, changed.left, changed.right, rowDisparity_.data(), rowFailure_.data());
            disparity = rowDisparity_.data();
            failure = rowFailure_.data();
        }
        senseRow(y, frameKey, disparity, failure, readings.row(y));
    }
}

}  // namespace cheval::hal::sim

#include "render/picture_scaler.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cheval::render {
namespace {

std::uint64_t spread(hal::Rgba8 pixel) {
    // Four channels in four lanes of 16 bits, so that one multiplication weighs all of them.
    return std::uint64_t{pixel.r} | std::uint64_t{pixel.g} << 16U | std::uint64_t{pixel.b} << 32U |
           std::uint64_t{pixel.a} << 48U;
}

hal::Rgba8 gather(std::uint64_t lanes) {
    return {static_cast<std::uint8_t>(lanes >> 8U), static_cast<std::uint8_t>(lanes >> 24U),
            static_cast<std::uint8_t>(lanes >> 40U), static_cast<std::uint8_t>(lanes >> 56U)};
}

}  // namespace

RowBlend rowBlend(float position, int rows) {
    const float centred = position - 0.5F;
    const float floor = std::floor(centred);
    const int first = static_cast<int>(floor);
    RowBlend blend{.first = std::clamp(first, 0, rows - 1), .second = std::clamp(first + 1, 0, rows - 1)};
    blend.weight = static_cast<unsigned>(std::lround((centred - floor) * 256.0F));
    return blend;
}

void blendRows(const std::uint8_t* a, const std::uint8_t* b, unsigned weight, std::uint8_t* out, std::size_t count) {
    if (a == b || weight == 0) {
        std::memcpy(out, a, count);
        return;
    }
    // Weights of 0…256 on bytes fit 16 bits with the rounding: the compiler makes eight lanes of it.
    const auto second = static_cast<std::uint16_t>(weight);
    const auto first = static_cast<std::uint16_t>(256U - weight);
    for (std::size_t i = 0; i < count; ++i) {
        const auto sum = static_cast<std::uint16_t>(static_cast<std::uint16_t>(a[i] * first) +
                                                    static_cast<std::uint16_t>(b[i] * second) + 128U);
        out[i] = static_cast<std::uint8_t>(sum >> 8U);
    }
}

void RowStretcher::prepare(float offset, float step, int outputs, int sourceWidth) {
    taps_.resize(static_cast<std::size_t>(outputs));
    for (int i = 0; i < outputs; ++i) {
        const RowBlend blend = rowBlend(offset + (static_cast<float>(i) + 0.5F) * step, sourceWidth);
        taps_[static_cast<std::size_t>(i)] = {.first = blend.first, .second = blend.second, .weight = blend.weight};
    }
}

void RowStretcher::stretch(const hal::Rgba8* source, hal::Rgba8* output) const {
    constexpr std::uint64_t kHalf = 0x0080008000800080U;
    for (const Tap& tap : taps_) {
        const std::uint64_t sum =
            spread(source[tap.first]) * (256U - tap.weight) + spread(source[tap.second]) * tap.weight + kHalf;
        *output++ = gather(sum);
    }
}

void PictureScaler::draw(const MirrorMapping& mapping, hal::ImageView<const hal::Rgb8> picture, const ToneCurve& tone,
                         hal::ImageView<hal::Rgba8> target) {
    const float step = 1.0F / mapping.scale;
    const int sourceWidth = mapping.mirroredWidth();
    columns_.prepare(mapping.cropLeft, step, target.width, sourceWidth);
    source_.resize(static_cast<std::size_t>(sourceWidth));
    for (auto& cached : rows_)
        cached.resize(static_cast<std::size_t>(target.width));
    rowIndex_ = {-1, -1};
    const int firstColumn = std::max(static_cast<int>(mapping.cropLeft) - 1, 0);
    const int lastColumn =
        std::min(static_cast<int>(mapping.cropLeft + step * static_cast<float>(target.width)) + 2, sourceWidth);
    for (int y = 0; y < target.height; ++y) {
        const RowBlend blend =
            rowBlend(mapping.cropTop + (static_cast<float>(y) + 0.5F) * step, mapping.mirroredHeight());
        for (const int index : {blend.first, blend.second}) {
            const auto slot = static_cast<std::size_t>(index) & 1U;
            if (rowIndex_[slot] == index) continue;
            for (int x = firstColumn; x < lastColumn; ++x) {
                const Eigen::Vector2i pixel = mapping.sensorPixel(x, index);
                const hal::Rgb8 colour = picture.at(pixel.x(), pixel.y());
                source_[static_cast<std::size_t>(x)] = {tone[colour.r], tone[colour.g], tone[colour.b], 255};
            }
            columns_.stretch(source_.data(), rows_[slot].data());
            rowIndex_[slot] = index;
        }
        blendRows(reinterpret_cast<const std::uint8_t*>(rows_[static_cast<std::size_t>(blend.first) & 1U].data()),
                  reinterpret_cast<const std::uint8_t*>(rows_[static_cast<std::size_t>(blend.second) & 1U].data()),
                  blend.weight, reinterpret_cast<std::uint8_t*>(target.row(y)),
                  static_cast<std::size_t>(target.width) * sizeof(hal::Rgba8));
    }
}

}  // namespace cheval::render

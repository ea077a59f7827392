#include "render/compositor.h"

#include <algorithm>

namespace cheval::render {
namespace {

constexpr int kRadius = 2;
constexpr int kWindow = 2 * kRadius + 1;

}  // namespace

void layOver(const hal::Rgba8* drawn, hal::Rgba8* under, int count) {
    const auto* from = reinterpret_cast<const std::uint8_t*>(drawn);
    auto* to = reinterpret_cast<std::uint8_t*>(under);
    for (int i = 0; i < count; ++i, from += 4, to += 4) {
        const unsigned alpha = from[3];
        if (alpha == 0) continue;
        const unsigned rest = 255U - alpha;
        for (int channel = 0; channel < 3; ++channel) {
            const unsigned under255 = to[channel] * rest + 127U;
            // Exact division by 255 for products of bytes.
            to[channel] =
                static_cast<std::uint8_t>(std::min(from[channel] + ((under255 + 1U + (under255 >> 8U)) >> 8U), 255U));
        }
        to[3] = 255;
    }
}

void Compositor::compose(hal::ImageView<hal::Rgba8> drawn, const PixelRect& rect, const MirrorMapping& mapping,
                         const Occlusion* occlusion, hal::ImageView<hal::Rgba8> target) {
    if (drawn.empty() || rect.empty()) return;
    const auto width = static_cast<std::size_t>(drawn.width);
    const std::size_t padded = width + 2 * kRadius;
    coverage_.assign(padded * static_cast<std::size_t>(drawn.height + 2 * kRadius), 0);
    for (int y = 0; y < drawn.height; ++y) {
        const hal::Rgba8* row = drawn.row(y);
        std::uint8_t* coverage = coverage_.data() + static_cast<std::size_t>(y + kRadius) * padded + kRadius;
        for (std::size_t x = 0; x < width; ++x)
            coverage[x] = row[x].a >> 7U;
    }
    sums_.assign(padded, 0);
    visible_.assign(width, 255);
    for (int y = 0; y < kWindow - 1; ++y) {
        for (std::size_t x = 0; x < padded; ++x)
            sums_[x] = static_cast<std::uint8_t>(sums_[x] + coverage_[static_cast<std::size_t>(y) * padded + x]);
    }
    const float stepX = static_cast<float>(rect.width()) / static_cast<float>(drawn.width);
    const float stepY = static_cast<float>(rect.height()) / static_cast<float>(drawn.height);
    const bool stretched = drawn.width != rect.width() || drawn.height != rect.height();
    for (int y = 0; y < drawn.height; ++y) {
        const std::uint8_t* entering = coverage_.data() + static_cast<std::size_t>(y + kWindow - 1) * padded;
        for (std::size_t x = 0; x < padded; ++x)
            sums_[x] = static_cast<std::uint8_t>(sums_[x] + entering[x]);
        if (occlusion != nullptr)
            occlusion->visibleRow(mapping, static_cast<float>(rect.x0) + 0.5F * stepX,
                                  static_cast<float>(rect.y0) + (static_cast<float>(y) + 0.5F) * stepY, stepX,
                                  drawn.width, visible_.data());
        hal::Rgba8* row = drawn.row(y);
        for (std::size_t x = 0; x < width; ++x) {
            if (row[x].a == 0) continue;
            // Coverage of a 5×5 window: 25 inside, 15 beside a straight edge. What is over a half becomes a ramp of
            // two pixels inside the outline, so that no colour is needed beyond it.
            const int covered = sums_[x] + sums_[x + 1] + sums_[x + 2] + sums_[x + 3] + sums_[x + 4];
            const int edge = std::clamp((covered * 2 - 25) * 12, 0, 255);
            const unsigned alpha = static_cast<unsigned>(edge) * visible_[x] / 255U;
            if (alpha == 255) continue;
            row[x].r = static_cast<std::uint8_t>(row[x].r * alpha / 255U);
            row[x].g = static_cast<std::uint8_t>(row[x].g * alpha / 255U);
            row[x].b = static_cast<std::uint8_t>(row[x].b * alpha / 255U);
            row[x].a = static_cast<std::uint8_t>(alpha);
        }
        const std::uint8_t* leaving = coverage_.data() + static_cast<std::size_t>(y) * padded;
        for (std::size_t x = 0; x < padded; ++x)
            sums_[x] = static_cast<std::uint8_t>(sums_[x] - leaving[x]);
        if (!stretched) layOver(row, target.row(rect.y0 + y) + rect.x0, drawn.width);
    }
    if (!stretched) return;
    scaler_.stretch(drawn, rect.width(), rect.height(), [&](int y, const hal::Rgba8* row) {
        layOver(row, target.row(rect.y0 + y) + rect.x0, rect.width());
    });
}

}  // namespace cheval::render

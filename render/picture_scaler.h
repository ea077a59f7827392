// Magnifies small pictures onto the display on the CPU: separable bilinear in fixed point, every source row stretched
// once. A full-screen quad in software GL costs several times as much.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/image.h"
#include "render/mirror_mapping.h"

namespace cheval::render {

/// A curve for each channel's bytes.
using ToneCurve = std::array<std::uint8_t, 256>;

/// Stretches rows by a fixed factor. Thread-bound; takes memory only when its sizes grow.
class RowStretcher {
  public:
    /// Output pixel i looks at source position offset + (i + 0.5) · step, in source pixels with edges at whole numbers.
    void prepare(float offset, float step, int outputs, int sourceWidth);
    void stretch(const hal::Rgba8* source, hal::Rgba8* output) const;

  private:
    struct Tap {
        std::int32_t first = 0, second = 0;
        std::uint32_t weight = 0;  ///< Of the second, in 256ths.
    };
    std::vector<Tap> taps_;
};

/// out = a + (b − a) · weight / 256 for `count` bytes, weight 0…256.
void blendRows(const std::uint8_t* a, const std::uint8_t* b, unsigned weight, std::uint8_t* out, std::size_t count);

/// Fills the display with the camera's picture as the mapping says. Thread-bound.
class PictureScaler {
  public:
    void draw(const MirrorMapping& mapping, hal::ImageView<const hal::Rgb8> picture, const ToneCurve& tone,
              hal::ImageView<hal::Rgba8> target);
    /// Fills `target` with `source`, stretched to its size. `row` is called with each finished row.
    template <typename RowDone>
    void stretch(hal::ImageView<const hal::Rgba8> source, int width, int height, RowDone row);

  private:
    RowStretcher columns_;
    std::vector<hal::Rgba8> source_;
    std::array<std::vector<hal::Rgba8>, 2> rows_;
    std::array<int, 2> rowIndex_{-1, -1};
    std::vector<hal::Rgba8> output_;
};

/// The two source rows and the weight of the second (in 256ths) for source position `position` (edges at whole
/// numbers).
struct RowBlend {
    int first = 0, second = 0;
    unsigned weight = 0;
};
RowBlend rowBlend(float position, int rows);

template <typename RowDone>
void PictureScaler::stretch(hal::ImageView<const hal::Rgba8> source, int width, int height, RowDone row) {
    columns_.prepare(0.0F, static_cast<float>(source.width) / static_cast<float>(width), width, source.width);
    const auto count = static_cast<std::size_t>(width);
    for (auto& cached : rows_)
        cached.resize(count);
    output_.resize(count);
    rowIndex_ = {-1, -1};
    const float step = static_cast<float>(source.height) / static_cast<float>(height);
    for (int y = 0; y < height; ++y) {
        const RowBlend blend = rowBlend((static_cast<float>(y) + 0.5F) * step, source.height);
        for (const int index : {blend.first, blend.second}) {
            auto& slot = rowIndex_[static_cast<std::size_t>(index) & 1U];
            if (slot == index) continue;
            columns_.stretch(source.row(index), rows_[static_cast<std::size_t>(index) & 1U].data());
            slot = index;
        }
        blendRows(reinterpret_cast<const std::uint8_t*>(rows_[static_cast<std::size_t>(blend.first) & 1U].data()),
                  reinterpret_cast<const std::uint8_t*>(rows_[static_cast<std::size_t>(blend.second) & 1U].data()),
                  blend.weight, reinterpret_cast<std::uint8_t*>(output_.data()), count * sizeof(hal::Rgba8));
        row(y, output_.data());
    }
}

}  // namespace cheval::render

// Lays what GL drew over the picture: edges softened, hidden parts taken away, in one pass over the garments'
// rectangle.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/image.h"
#include "render/mirror_mapping.h"
#include "render/occlusion.h"
#include "render/picture_scaler.h"
#include "render/projection.h"

namespace cheval::render {

/// over = drawn · a + under · (1 − a) for `count` pixels of premultiplied `drawn`; the result is opaque.
void layOver(const hal::Rgba8* drawn, hal::Rgba8* under, int count);

/// Thread-bound; takes memory only when sizes grow.
class Compositor {
  public:
    /// Lays `drawn` (alpha 0 or 255; it is used up) over the part `rect` of `target`, stretched if it is smaller.
    /// `occlusion` may be null: nothing hides anything.
    void compose(hal::ImageView<hal::Rgba8> drawn, const PixelRect& rect, const MirrorMapping& mapping,
                 const Occlusion* occlusion, hal::ImageView<hal::Rgba8> target);

  private:
    PictureScaler scaler_;
    std::vector<std::uint8_t> coverage_;  ///< 0 or 1 a pixel, two rows and columns of 0 around.
    std::vector<std::uint8_t> sums_;      ///< Of five rows of coverage, a column.
    std::vector<std::uint8_t> visible_;
};

}  // namespace cheval::render

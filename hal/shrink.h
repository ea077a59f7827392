// Smaller copies of pictures, for pages and reports.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/image.h"

namespace cheval::hal {

/// Shrinks `from` to `to`'s size as the mean over each target pixel's whole source pixels; where `to` is larger, source
/// pixels are repeated.
/// Every pixel of `to` becomes opaque. `sums` is scratch, kept by the caller so that no call but the first takes heap
/// memory.
void shrink(ImageView<const Rgba8> from, ImageView<Rgba8> to, std::vector<std::uint32_t>& sums);

}  // namespace cheval::hal

// PNG for the textures inside assets. (The devices' PNG lives in a room that the builders do not see.)
#pragma once

#include <cstdint>
#include <vector>

#include "hal/expected.h"
#include "hal/image.h"

namespace cheval::fitting::bake {

/// 8-bit RGB, no time stamp; alpha is left out. The same picture gives the same bytes.
Expected<std::vector<std::uint8_t>> encodePng(hal::ImageView<const hal::Rgba8> image);

}  // namespace cheval::fitting::bake

#include "fitting/bake/png.h"

#include <cstdlib>
#include <memory>
#include <string>

#include <spng.h>

namespace cheval::fitting::bake {

Expected<std::vector<std::uint8_t>> encodePng(hal::ImageView<const hal::Rgba8> image) {
    std::vector<std::uint8_t> rgb;
    rgb.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const hal::Rgba8& pixel = image.at(x, y);
            rgb.insert(rgb.end(), {pixel.r, pixel.g, pixel.b});
        }
    }
    const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(SPNG_CTX_ENCODER), spng_ctx_free);
    spng_ihdr header{};
    header.width = static_cast<std::uint32_t>(image.width);
    header.height = static_cast<std::uint32_t>(image.height);
    header.bit_depth = 8;
    header.color_type = SPNG_COLOR_TYPE_TRUECOLOR;
    int failure = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
    if (failure == 0) failure = spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, 5);
    if (failure == 0) failure = spng_set_ihdr(context.get(), &header);
    if (failure == 0) {
        failure = spng_encode_image(context.get(), rgb.data(), rgb.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
    }
    std::size_t bytes = 0;
    const std::unique_ptr<void, decltype(&std::free)> encoded(
        failure == 0 ? spng_get_png_buffer(context.get(), &bytes, &failure) : nullptr, std::free);
    if (encoded == nullptr) {
        return Error{.code = ErrorCode::internal,
                     .cause = std::string("a texture could not be encoded: ") + spng_strerror(failure)};
    }
    const auto* data = static_cast<const std::uint8_t*>(encoded.get());
    return std::vector<std::uint8_t>(data, data + bytes);
}

}  // namespace cheval::fitting::bake

// Pictures as plain memory. A view owns nothing; an Image owns its pixels, rows one after another without gaps.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace cheval::hal {

struct Rgb8 {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Rgb8&, const Rgb8&) = default;
};
struct Rgba8 {
    std::uint8_t r = 0, g = 0, b = 0, a = 255;
    friend bool operator==(const Rgba8&, const Rgba8&) = default;
};

/// A rectangle of pixels, row 0 at the top. `stride` is in pixels and at least `width`. An empty view has no pixels.
template <typename Pixel>
struct ImageView {
    Pixel* data = nullptr;
    int width = 0;
    int height = 0;
    std::ptrdiff_t stride = 0;

    [[nodiscard]] bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
    [[nodiscard]] Pixel* row(int y) const { return data + y * stride; }
    [[nodiscard]] Pixel& at(int x, int y) const { return data[y * stride + x]; }
    [[nodiscard]] bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
    operator ImageView<const Pixel>() const requires(!std::is_const_v<Pixel>) { return {data, width, height, stride}; }
};

/// Pixels that somebody owns. Assigning the same size again takes no memory.
template <typename Pixel>
struct Image {
    int width = 0;
    int height = 0;
    std::vector<Pixel> pixels;

    Image() = default;
    Image(int imageWidth, int imageHeight, Pixel fill = {}) { resize(imageWidth, imageHeight, fill); }
    void resize(int imageWidth, int imageHeight, Pixel fill = {}) {
        width = imageWidth;
        height = imageHeight;
        pixels.assign(static_cast<std::size_t>(imageWidth) * static_cast<std::size_t>(imageHeight), fill);
    }
    [[nodiscard]] bool empty() const { return pixels.empty(); }
    [[nodiscard]] ImageView<Pixel> view() { return {pixels.data(), width, height, width}; }
    [[nodiscard]] ImageView<const Pixel> view() const { return {pixels.data(), width, height, width}; }
};

/// Copies `from` into `to`, which takes no memory when it already has that size.
template <typename Pixel>
void copyInto(ImageView<const Pixel> from, Image<Pixel>& to) {
    to.width = from.empty() ? 0 : from.width;
    to.height = from.empty() ? 0 : from.height;
    to.pixels.resize(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height));
    for (int y = 0; y < to.height; ++y) {
        const Pixel* source = from.row(y);
        std::copy(source, source + to.width, to.pixels.data() + static_cast<std::ptrdiff_t>(y) * to.width);
    }
}

}  // namespace cheval::hal

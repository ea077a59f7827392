// PNG in and out, from memory or file, for depth (16-bit grey) and colour. Input is untrusted: what a picture would
// cost is checked before anything of its size is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/expected.h"
#include "hal/image.h"

namespace cheval::hal {

/// What a PNG may ask for. The pixels' memory is at most maxPixels times the pixel's size.
struct PngLimits {
    int maxWidth = 8192;
    int maxHeight = 8192;
    std::size_t maxPixels = std::size_t{1} << 25;
    std::size_t maxFileBytes = std::size_t{1} << 26;
    std::size_t maxChunkBytes = std::size_t{1} << 20;  ///< Of one chunk of text, profile and the like; not the pixels.
};

/// A PNG's header. colourType as in ISO/IEC 15948: 0 grey, 2 RGB, 3 palette, 4 grey with alpha, 6 RGBA.
struct PngInfo {
    int width = 0;
    int height = 0;
    int bitDepth = 0;  ///< Bits a channel.
    int colourType = 0;

    [[nodiscard]] bool isGrey16() const { return colourType == 0 && bitDepth == 16; }
};

struct PngWriteOptions {
    int compression = 6;  ///< zlib's level: 1 fast … 9 small.
    /// One filter for every row instead of the best of five for each: faster, and larger where rows differ.
    bool oneFilter = false;
};

/// The header of a PNG in memory, within the limits. Errors: invalidInput.
Expected<PngInfo> inspectPng(std::span<const std::byte> png, const PngLimits& limits = {});

/// Decodes a PNG in memory into `to`, which takes no memory when it already has the picture's size. On an error `to`
/// holds no promised picture. Grey16 takes 16-bit grey only and refuses the rest, since depth in 8 bits is not depth;
/// Rgb8 and Rgba8 take every kind, converted (16 bits to 8, palette to colours, missing alpha to 255). No colour
/// management. Errors: invalidInput, with cause, mend and why.
Expected<void> decodePng(std::span<const std::byte> png, Image<std::uint16_t>& to, const PngLimits& limits = {});
Expected<void> decodePng(std::span<const std::byte> png, Image<Rgb8>& to, const PngLimits& limits = {});
Expected<void> decodePng(std::span<const std::byte> png, Image<Rgba8>& to, const PngLimits& limits = {});

/// Encodes into `png`, replacing what it held. Same picture and options, same bytes. Errors: invalidInput for an empty
/// picture, resource.
Expected<void> encodePng(ImageView<const std::uint16_t> picture, std::vector<std::byte>& png,
                         const PngWriteOptions& options = {});
Expected<void> encodePng(ImageView<const Rgb8> picture, std::vector<std::byte>& png,
                         const PngWriteOptions& options = {});
Expected<void> encodePng(ImageView<const Rgba8> picture, std::vector<std::byte>& png,
                         const PngWriteOptions& options = {});

/// Reads a whole file of at most `maxBytes` into `bytes`, which takes memory only when the file is larger than any
/// before. Errors: notFound, invalidInput (not a regular file, too large), resource.
Expected<void> readBytes(const std::string& path, std::size_t maxBytes, std::vector<std::byte>& bytes);
/// Writes a whole file, replacing it. Errors: notFound (folder), resource (disk).
Expected<void> writeBytes(const std::string& path, std::span<const std::byte> bytes);

/// As decodePng and inspectPng, from a file; errors name it.
Expected<PngInfo> inspectPngFile(const std::string& path, const PngLimits& limits = {});
Expected<void> readPng(const std::string& path, Image<std::uint16_t>& to, const PngLimits& limits = {});
Expected<void> readPng(const std::string& path, Image<Rgb8>& to, const PngLimits& limits = {});
Expected<void> readPng(const std::string& path, Image<Rgba8>& to, const PngLimits& limits = {});

/// As encodePng, into a file; errors name it.
Expected<void> writePng(const std::string& path, ImageView<const std::uint16_t> picture,
                        const PngWriteOptions& options = {});
Expected<void> writePng(const std::string& path, ImageView<const Rgb8> picture, const PngWriteOptions& options = {});
Expected<void> writePng(const std::string& path, ImageView<const Rgba8> picture, const PngWriteOptions& options = {});

}  // namespace cheval::hal

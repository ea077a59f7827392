// Fuzzes the PNG decoder in each of its three pixel types.
#include <span>

#include "hal/png/png.h"
#include "tests/support/fuzz.h"

using namespace cheval;

namespace {

std::uint32_t readBigEndian(const std::uint8_t* at) {
    return std::uint32_t{at[0]} << 24U | std::uint32_t{at[1]} << 16U | std::uint32_t{at[2]} << 8U |
           std::uint32_t{at[3]};
}

// Makes the chunks' checksums right, since what changes one bit and nothing else never gets past them.
void repairChecksums(std::vector<std::uint8_t>& png) {
    std::size_t at = 8;
    while (at + 12 <= png.size()) {
        const std::size_t length = readBigEndian(png.data() + at);
        if (length > png.size() - at - 12) return;
        std::uint32_t crc = 0xFFFFFFFFU;
        for (std::size_t i = at + 4; i < at + 8 + length; ++i) {
            crc ^= png[i];
            for (int bit = 0; bit < 8; ++bit)
                crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
        }
        for (unsigned i = 0; i < 4; ++i)
            png[at + 8 + length + i] = static_cast<std::uint8_t>(~crc >> (24U - 8U * i));
        at += 12 + length;
    }
}

void decodeAll(std::span<const std::byte> png) {
    // Small, so that the search spends its time on the format and not on pixels.
    const hal::PngLimits limits{.maxWidth = 512, .maxHeight = 512, .maxPixels = 1U << 16U, .maxFileBytes = 1U << 20U};
    hal::Image<std::uint16_t> depth;
    hal::Image<hal::Rgb8> rgb;
    hal::Image<hal::Rgba8> rgba;
    const auto info = hal::inspectPng(png, limits);
    const bool decoded[] = {hal::decodePng(png, depth, limits).hasValue(), hal::decodePng(png, rgb, limits).hasValue(),
                            hal::decodePng(png, rgba, limits).hasValue()};
    for (const bool any : decoded) {
        if (any && !info) __builtin_trap();
    }
    if (decoded[1] &&
        rgb.pixels.size() != static_cast<std::size_t>(info->width) * static_cast<std::size_t>(info->height)) {
        __builtin_trap();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size > 1U << 16U) return 0;
    std::vector<std::uint8_t> png(data, data + size);
    decodeAll(std::as_bytes(std::span(png)));
    repairChecksums(png);
    decodeAll(std::as_bytes(std::span(png)));
    return 0;
}

namespace cheval::test {

std::vector<FuzzInput> fuzzSeeds() {
    std::vector<FuzzInput> seeds;
    const auto add = [&seeds](const auto& image) {
        std::vector<std::byte> png;
        if (!hal::encodePng(image.view(), png)) return;
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(png.data());
        seeds.emplace_back(bytes, bytes + png.size());
    };
    hal::Image<std::uint16_t> depth(9, 5, 1500);
    for (std::size_t i = 0; i < depth.pixels.size(); ++i)
        depth.pixels[i] = static_cast<std::uint16_t>(i * 1201);
    add(depth);
    add(hal::Image<hal::Rgb8>(7, 3, {.r = 200, .g = 100, .b = 50}));
    add(hal::Image<hal::Rgba8>(64, 64, {.r = 1, .g = 2, .b = 3, .a = 4}));
    return seeds;
}

}  // namespace cheval::test

#include "hal/png/png.h"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 11;

template <typename Pixel>
Image<Pixel> pattern();

template <>
Image<std::uint16_t> pattern() {
    Image<std::uint16_t> image(kWidth, kHeight);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = static_cast<std::uint16_t>(i * 2503);
    return image;
}
template <>
Image<Rgb8> pattern() {
    Image<Rgb8> image(kWidth, kHeight);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        image.pixels[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i * 7),
                           static_cast<std::uint8_t>(i * 31)};
    }
    return image;
}
template <>
Image<Rgba8> pattern() {
    Image<Rgba8> image(kWidth, kHeight);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        image.pixels[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i * 7),
                           static_cast<std::uint8_t>(i * 31), static_cast<std::uint8_t>(i * 5)};
    }
    return image;
}

template <typename Pixel>
std::vector<std::byte> encoded(const Image<Pixel>& image) {
    std::vector<std::byte> png;
    EXPECT_TRUE(encodePng(image.view(), png));
    return png;
}

template <typename Pixel>
class PngRoundTripTest : public testing::Test {};
using Pixels = testing::Types<std::uint16_t, Rgb8, Rgba8>;
TYPED_TEST_SUITE(PngRoundTripTest, Pixels);

TYPED_TEST(PngRoundTripTest, DecodesWhatItEncoded) {
    const auto image = pattern<TypeParam>();
    Image<TypeParam> back;
    ASSERT_TRUE(decodePng(encoded(image), back));
    EXPECT_EQ(back.width, kWidth);
    EXPECT_EQ(back.height, kHeight);
    EXPECT_EQ(back.pixels, image.pixels);
}

TYPED_TEST(PngRoundTripTest, OneFilterForAllRowsGivesTheSamePicture) {
    const auto image = pattern<TypeParam>();
    std::vector<std::byte> png;
    ASSERT_TRUE(encodePng(image.view(), png, {.compression = 1, .oneFilter = true}));
    Image<TypeParam> back;
    ASSERT_TRUE(decodePng(png, back));
    EXPECT_EQ(back.pixels, image.pixels);
}

TYPED_TEST(PngRoundTripTest, SamePictureGivesSameBytes) {
    const auto image = pattern<TypeParam>();
    EXPECT_EQ(encoded(image), encoded(image));
}

TYPED_TEST(PngRoundTripTest, WritesAViewWithGapsBetweenRows) {
    const auto image = pattern<TypeParam>();
    ImageView<const TypeParam> part = image.view();
    part.width = 20;
    std::vector<std::byte> png;
    ASSERT_TRUE(encodePng(part, png));
    Image<TypeParam> back;
    ASSERT_TRUE(decodePng(png, back));
    ASSERT_EQ(back.width, 20);
    for (int y = 0; y < kHeight; ++y) {
        EXPECT_TRUE(std::equal(part.row(y), part.row(y) + 20, back.view().row(y))) << "row " << y;
    }
}

TYPED_TEST(PngRoundTripTest, GoesThroughAFile) {
    const std::string path = testing::TempDir() + "png_test_" + std::to_string(sizeof(TypeParam)) + ".png";
    const auto image = pattern<TypeParam>();
    ASSERT_TRUE(writePng(path, image.view()));
    Image<TypeParam> back;
    ASSERT_TRUE(readPng(path, back));
    EXPECT_EQ(back.pixels, image.pixels);
    const auto info = inspectPngFile(path);
    ASSERT_TRUE(info);
    EXPECT_EQ(info->width, kWidth);
    EXPECT_EQ(info->height, kHeight);
    std::filesystem::remove(path);
}

TYPED_TEST(PngRoundTripTest, EveryTruncationIsRefused) {
    const std::vector<std::byte> png = encoded(pattern<TypeParam>());
    // The last four bytes are the checksum of the empty chunk that ends the file.
    for (std::size_t length = 0; length + 4 < png.size(); ++length) {
        Image<TypeParam> back;
        EXPECT_FALSE(decodePng(std::span(png).first(length), back)) << length << " of " << png.size() << " bytes";
    }
}

TYPED_TEST(PngRoundTripTest, DecodingTheSameSizeAgainTakesNoMemory) {
    const std::vector<std::byte> png = encoded(pattern<TypeParam>());
    Image<TypeParam> back;
    ASSERT_TRUE(decodePng(png, back));
    const auto* pixels = back.pixels.data();
    ASSERT_TRUE(decodePng(png, back));
    EXPECT_EQ(back.pixels.data(), pixels);
}

TYPED_TEST(PngRoundTripTest, APictureWithoutPixelsIsRefused) {
    std::vector<std::byte> png;
    const auto done = encodePng(ImageView<const TypeParam>{}, png);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::invalidInput);
}

TEST(PngTest, DepthInEightBitsIsRefusedWithAMend) {
    Image<std::uint16_t> depth;
    const auto done = decodePng(encoded(pattern<Rgb8>()), depth);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::invalidInput);
    EXPECT_EQ(done.error().cause, "the picture has 3 channel(s) of 8 bits");
    EXPECT_EQ(done.error().mend, "write depth as 16-bit grey PNG");
    EXPECT_FALSE(done.error().why.empty());
}

TEST(PngTest, ColourWithoutAlphaIsOpaque) {
    const auto image = pattern<Rgb8>();
    Image<Rgba8> back;
    ASSERT_TRUE(decodePng(encoded(image), back));
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        EXPECT_EQ(back.pixels[i], (Rgba8{image.pixels[i].r, image.pixels[i].g, image.pixels[i].b, 255}));
    }
}

TEST(PngTest, APictureLargerThanTheLimitsIsRefusedByItsHeader) {
    const std::vector<std::byte> png = encoded(pattern<Rgb8>());
    for (const PngLimits& limits :
         {PngLimits{.maxWidth = kWidth - 1}, PngLimits{.maxHeight = kHeight - 1},
          PngLimits{.maxPixels = kWidth * kHeight - 1}, PngLimits{.maxFileBytes = png.size() - 1}}) {
        Image<Rgb8> back;
        const auto done = decodePng(png, back, limits);
        ASSERT_FALSE(done);
        EXPECT_EQ(done.error().code, ErrorCode::invalidInput);
        EXPECT_FALSE(done.error().mend.empty());
        EXPECT_FALSE(done.error().why.empty());
        EXPECT_TRUE(back.pixels.empty());
    }
}

// CRC-32 of ISO 3309, as every PNG chunk carries it.
std::uint32_t crcOf(std::span<const std::byte> bytes) {
    std::uint32_t crc = 0xFFFFFFFFU;
    for (const std::byte byte : bytes) {
        crc ^= std::to_integer<std::uint32_t>(byte);
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    return ~crc;
}

void putBigEndian(std::byte* at, std::uint32_t value) {
    for (unsigned i = 0; i < 4; ++i)
        at[i] = static_cast<std::byte>(value >> (24U - 8U * i));
}

TEST(PngTest, AShortFileThatClaimsManyPixelsIsRefusedBeforeTheyAreAllocated) {
    std::vector<std::byte> png = encoded(pattern<std::uint16_t>());
    putBigEndian(png.data() + 16, 8000);
    putBigEndian(png.data() + 20, 4000);
    putBigEndian(png.data() + 29, crcOf(std::span(png).subspan(12, 17)));
    Image<std::uint16_t> back;
    const auto done = decodePng(png, back);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().cause, "the picture claims 8000 by 4000 pixels");
    EXPECT_TRUE(back.pixels.empty());
}

TEST(PngTest, AMissingFileIsNamed) {
    Image<Rgb8> back;
    const auto done = readPng("no/such/picture.png", back);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::notFound);
    EXPECT_EQ(done.error().file, "no/such/picture.png");
}

TEST(PngTest, AFolderIsNotAPicture) {
    Image<Rgb8> back;
    const auto done = readPng(testing::TempDir(), back);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::invalidInput);
}

TEST(PngTest, AFileThatIsNoPngIsNamed) {
    const std::string path = testing::TempDir() + "png_test_text.png";
    const std::string text = "not a picture at all, but long enough to be one";
    ASSERT_TRUE(writeBytes(path, std::as_bytes(std::span(text))));
    Image<Rgb8> back;
    const auto done = readPng(path, back);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().file, path);
    EXPECT_EQ(done.error().code, ErrorCode::invalidInput);
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace cheval::hal

#include "daemon/animated_picture.h"

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <webp/demux.h>

namespace cheval::daemon {
namespace {

using std::chrono::milliseconds;

struct DeleteDecoder {
    void operator()(WebPAnimDecoder* decoder) const { WebPAnimDecoderDelete(decoder); }
};

struct Decoded {
    int width = 0;
    int height = 0;
    int loops = -1;
    std::vector<int> ends;               ///< Milliseconds at which each picture gives way.
    std::vector<hal::Rgba8> firstPixel;  ///< The top left pixel of each picture.
};

Decoded decode(const std::vector<std::byte>& bytes) {
    const WebPData data{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
    const std::unique_ptr<WebPAnimDecoder, DeleteDecoder> decoder(WebPAnimDecoderNew(&data, nullptr));
    Decoded decoded;
    WebPAnimInfo info;
    if (!decoder || WebPAnimDecoderGetInfo(decoder.get(), &info) == 0) {
        return decoded;
    }
    decoded.width = static_cast<int>(info.canvas_width);
    decoded.height = static_cast<int>(info.canvas_height);
    decoded.loops = static_cast<int>(info.loop_count);
    std::uint8_t* canvas = nullptr;
    int end = 0;
    while (WebPAnimDecoderGetNext(decoder.get(), &canvas, &end) != 0) {
        decoded.ends.push_back(end);
        decoded.firstPixel.push_back({canvas[0], canvas[1], canvas[2], canvas[3]});
    }
    return decoded;
}

CompactPicture plain(int width, int height, hal::Rgba8 colour) {
    const hal::Image<hal::Rgba8> image(width, height, colour);
    auto picture = CompactPicture::create(image.view());
    EXPECT_TRUE(picture.hasValue());
    return std::move(picture).value();
}

TEST(AnimatedPicture, ShowsEachPictureFromItsTimeToTheNext) {
    const CompactPicture red = plain(32, 48, {200, 20, 20});
    const CompactPicture blue = plain(32, 48, {20, 20, 200});
    const hal::TimePoint start(milliseconds(7000));
    auto bytes =
        encodeAnimation({{&red, start}, {&blue, start + milliseconds(100)}, {&red, start + milliseconds(250)}}, 80.0F);
    ASSERT_TRUE(bytes.hasValue()) << bytes.error().message();
    const Decoded decoded = decode(*bytes);
    EXPECT_EQ(decoded.width, 32);
    EXPECT_EQ(decoded.height, 48);
    EXPECT_EQ(decoded.loops, 0);
    EXPECT_EQ(decoded.ends, (std::vector<int>{100, 250, 400}));
    ASSERT_EQ(decoded.firstPixel.size(), 3U);
    for (const std::size_t i : {0U, 2U}) {
        EXPECT_NEAR(decoded.firstPixel[i].r, 200, 6);
        EXPECT_NEAR(decoded.firstPixel[i].b, 20, 6);
    }
    EXPECT_NEAR(decoded.firstPixel[1].b, 200, 6);
}

TEST(AnimatedPicture, IsTheSameBytesEachTimeAndLeavesThePicturesAsTheyWere) {
    const CompactPicture red = plain(16, 16, {200, 20, 20});
    const CompactPicture green = plain(16, 16, {20, 200, 20});
    const std::vector<AnimationFrame> frames{{&red, hal::TimePoint(milliseconds(0))},
                                             {&green, hal::TimePoint(milliseconds(100))}};
    const auto first = encodeAnimation(frames, 60.0F);
    const auto second = encodeAnimation(frames, 60.0F);
    ASSERT_TRUE(first.hasValue() && second.hasValue());
    EXPECT_EQ(*first, *second);
}

TEST(AnimatedPicture, OnePictureIsAnAnimationToo) {
    const CompactPicture red = plain(16, 16, {200, 20, 20});
    const auto bytes = encodeAnimation({{&red, hal::TimePoint(milliseconds(40))}}, 60.0F);
    ASSERT_TRUE(bytes.hasValue());
    EXPECT_EQ(decode(*bytes).firstPixel.size(), 1U);
}

TEST(AnimatedPicture, RefusesNoPictureUnequalSizesAndTimesThatDoNotRise) {
    const CompactPicture small = plain(16, 16, {});
    const CompactPicture large = plain(16, 18, {});
    const hal::TimePoint zero{};
    EXPECT_EQ(encodeAnimation({}, 60.0F).error().code, ErrorCode::invalidInput);
    EXPECT_EQ(encodeAnimation({{&small, zero}, {&large, zero + milliseconds(100)}}, 60.0F).error().code,
              ErrorCode::invalidInput);
    EXPECT_EQ(encodeAnimation({{&small, zero}, {&small, zero}}, 60.0F).error().code, ErrorCode::invalidInput);
    EXPECT_EQ(encodeAnimation({{&small, zero}, {&small, zero - milliseconds(1)}}, 60.0F).error().code,
              ErrorCode::invalidInput);
}

TEST(AnimatedPicture, KeepsAPictureOfAnyStride) {
    hal::Image<hal::Rgba8> image(40, 20, {200, 20, 20});
    const hal::ImageView<const hal::Rgba8> right{image.pixels.data() + 20, 20, 20, 40};
    for (int y = 0; y < 20; ++y) {
        for (int x = 20; x < 40; ++x) {
            image.view().at(x, y) = {20, 20, 200};
        }
    }
    const auto picture = CompactPicture::create(right);
    ASSERT_TRUE(picture.hasValue());
    const auto bytes = encodeAnimation({{&*picture, hal::TimePoint{}}}, 90.0F);
    ASSERT_TRUE(bytes.hasValue());
    const Decoded decoded = decode(*bytes);
    ASSERT_EQ(decoded.firstPixel.size(), 1U);
    EXPECT_NEAR(decoded.firstPixel[0].b, 200, 6);
}

TEST(AnimatedPicture, RefusesAnEmptyPicture) {
    EXPECT_EQ(CompactPicture::create({}).error().code, ErrorCode::invalidInput);
}

}  // namespace
}  // namespace cheval::daemon

#include "daemon/animated_picture.h"

#include <chrono>
#include <cstring>
#include <string>
#include <utility>

#include <webp/encode.h>
#include <webp/mux.h>

namespace cheval::daemon {
namespace {

// The quickest method whose blocks do not show; 0 is a third quicker and a half larger.
constexpr int kMethod = 2;

struct DeleteEncoder {
    void operator()(WebPAnimEncoder* encoder) const { WebPAnimEncoderDelete(encoder); }
};

Error encoderError(const std::string& what) {
    return {.code = ErrorCode::resource, .cause = "the animated picture could not be encoded: " + what};
}

}  // namespace

void CompactPicture::Free::operator()(WebPPicture* picture) const {
    WebPPictureFree(picture);
    delete picture;
}

Expected<CompactPicture> CompactPicture::create(hal::ImageView<const hal::Rgba8> picture) {
    if (picture.empty() || picture.width > WEBP_MAX_DIMENSION || picture.height > WEBP_MAX_DIMENSION) {
        return Error{.code = ErrorCode::invalidInput, .cause = "a picture of this size cannot be kept as WebP"};
    }
    CompactPicture compact;
    compact.picture_.reset(new WebPPicture);
    if (WebPPictureInit(compact.picture_.get()) == 0) {
        return encoderError("libwebp is of another version than its headers");
    }
    compact.picture_->use_argb = 0;
    compact.picture_->width = picture.width;
    compact.picture_->height = picture.height;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(picture.data);
    const int strideBytes = static_cast<int>(picture.stride * static_cast<std::ptrdiff_t>(sizeof(hal::Rgba8)));
    if (WebPPictureImportRGBX(compact.picture_.get(), bytes, strideBytes) == 0) {
        return Error{.code = ErrorCode::resource, .cause = "there is no memory for a small copy of a picture"};
    }
    return compact;
}

Expected<std::vector<std::byte>> encodeAnimation(const std::vector<AnimationFrame>& frames, float quality) {
    if (frames.empty()) {
        return Error{.code = ErrorCode::invalidInput, .cause = "an animation needs a picture"};
    }
    WebPAnimEncoderOptions options;
    WebPConfig config;
    if (WebPAnimEncoderOptionsInit(&options) == 0 || WebPConfigInit(&config) == 0) {
        return encoderError("libwebp is of another version than its headers");
    }
    options.anim_params.loop_count = 0;  // For ever.
    options.kmin = 0;
    options.kmax = 0;  // Nobody seeks in a picture: key frames would only be encoded twice.
    config.method = kMethod;
    config.quality = quality;
    const int width = frames.front().picture->get().width;
    const int height = frames.front().picture->get().height;
    const std::unique_ptr<WebPAnimEncoder, DeleteEncoder> encoder(WebPAnimEncoderNew(width, height, &options));
    if (!encoder) {
        return encoderError("no memory");
    }

    const auto milliseconds = [&](hal::TimePoint time) {
        return static_cast<int>(
            std::chrono::duration_cast<std::chrono::milliseconds>(time - frames.front().time).count());
    };
    int last = -1;
    int step = 100;
    for (const AnimationFrame& frame : frames) {
        const int time = milliseconds(frame.time);
        if (time <= last || frame.picture->get().width != width || frame.picture->get().height != height) {
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "the pictures of an animation must be of one size and of rising times"};
        }
        step = last < 0 ? step : time - last;
        last = time;
        // A shallow view: the encoder converts what it is given in place, and the pictures are the caller's to use
        // again.
        WebPPicture view;
        if (WebPPictureInit(&view) == 0 || WebPPictureView(&frame.picture->get(), 0, 0, width, height, &view) == 0) {
            return encoderError("no memory");
        }
        const bool added = WebPAnimEncoderAdd(encoder.get(), &view, time, &config) != 0;
        WebPPictureFree(&view);
        if (!added) {
            return encoderError(WebPAnimEncoderGetError(encoder.get()));
        }
    }
    WebPData data;
    WebPDataInit(&data);
    if (WebPAnimEncoderAdd(encoder.get(), nullptr, last + step, nullptr) == 0 ||
        WebPAnimEncoderAssemble(encoder.get(), &data) == 0) {
        return encoderError(WebPAnimEncoderGetError(encoder.get()));
    }
    std::vector<std::byte> bytes(data.size);
    std::memcpy(bytes.data(), data.bytes, data.size);
    WebPDataClear(&data);
    return bytes;
}

}  // namespace cheval::daemon

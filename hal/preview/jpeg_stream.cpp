#include "hal/preview/jpeg_stream.h"

#include <algorithm>
#include <utility>

#include <turbojpeg.h>

#include "hal/shrink.h"

namespace cheval::hal {

JpegStream::JpegStream(PreviewDisplay& display, const DisplayMode& mode, int width, int quality)
    : display_(display), quality_(std::clamp(quality, 1, 100)) {
    const int smallWidth = std::clamp(width, 1, mode.width);
    small_.resize(smallWidth, std::max(1, static_cast<int>(std::int64_t{mode.height} * smallWidth / mode.width)));
    buffer_.resize(tjBufSize(small_.width, small_.height, TJSAMP_420));
    thread_ = std::thread([this] { run(); });
}

JpegStream::~JpegStream() {
    stop();
    thread_.join();
}

void JpegStream::stop() {
    display_.stop();
    {
        const std::lock_guard lock(mutex_);
        stopped_ = true;
    }
    changed_.notify_all();
}

std::shared_ptr<const JpegPicture> JpegStream::next(std::uint64_t after, Duration limit) {
    std::unique_lock lock(mutex_);
    const bool came = changed_.wait_for(lock, limit, [&] { return stopped_ || (latest_ && latest_->number > after); });
    return came && !stopped_ ? latest_ : nullptr;
}

std::shared_ptr<const JpegPicture> JpegStream::latest() {
    const std::lock_guard lock(mutex_);
    return latest_;
}

std::shared_ptr<const JpegPicture> JpegStream::encode(void* compressor, const PreviewDisplay::Picture& picture) {
    ImageView<const Rgba8> pixels = picture.pixels;
    if (pixels.width != small_.width || pixels.height != small_.height) {
        shrink(pixels, small_.view(), sums_);
        pixels = std::as_const(small_).view();
    }
    unsigned char* bytes = buffer_.data();
    auto size = static_cast<unsigned long>(buffer_.size());  // NOLINT(google-runtime-int): the library's type.
    const int pitch = static_cast<int>(pixels.stride * static_cast<std::ptrdiff_t>(sizeof(Rgba8)));
    if (tjCompress2(compressor, &pixels.data->r, pixels.width, pitch, pixels.height, TJPF_RGBX, &bytes, &size,
                    TJSAMP_420, quality_, TJFLAG_NOREALLOC) != 0) {
        return nullptr;
    }
    return std::make_shared<const JpegPicture>(JpegPicture{.bytes = {bytes, bytes + size}, .number = picture.number});
}

void JpegStream::run() {
    void* const compressor = tjInitCompress();
    PreviewDisplay::Picture picture;
    while (compressor != nullptr && display_.take(picture)) {
        auto jpeg = encode(compressor, picture);
        display_.giveBack();
        if (jpeg == nullptr) continue;
        {
            const std::lock_guard lock(mutex_);
            latest_ = std::move(jpeg);
        }
        changed_.notify_all();
    }
    if (compressor != nullptr) tjDestroy(compressor);
}

}  // namespace cheval::hal

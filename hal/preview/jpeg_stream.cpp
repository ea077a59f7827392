#include "hal/preview/jpeg_stream.h"

#include <algorithm>
#include <utility>

#include <turbojpeg.h>

namespace cheval::hal {

void shrink(ImageView<const Rgba8> from, ImageView<Rgba8> to, std::vector<std::uint32_t>& sums) {
    const auto sourceWidth = static_cast<std::size_t>(from.width);
    sums.resize(sourceWidth * 3);
    for (int y = 0; y < to.height; ++y) {
        const int top = static_cast<int>(std::int64_t{y} * from.height / to.height);
        const int bottom = static_cast<int>((std::int64_t{y} + 1) * from.height / to.height);
        std::fill(sums.begin(), sums.end(), 0U);
        for (int sourceY = top; sourceY < bottom; ++sourceY) {
            const Rgba8* const row = from.row(sourceY);
            for (std::size_t x = 0; x < sourceWidth; ++x) {
                sums[3 * x] += row[x].r;
                sums[3 * x + 1] += row[x].g;
                sums[3 * x + 2] += row[x].b;
            }
        }
        for (int x = 0; x < to.width; ++x) {
            const auto left = static_cast<std::size_t>(std::int64_t{x} * from.width / to.width);
            const auto right = static_cast<std::size_t>((std::int64_t{x} + 1) * from.width / to.width);
            std::uint32_t r = 0;
            std::uint32_t g = 0;
            std::uint32_t b = 0;
            for (std::size_t sourceX = left; sourceX < right; ++sourceX) {
                r += sums[3 * sourceX];
                g += sums[3 * sourceX + 1];
                b += sums[3 * sourceX + 2];
            }
            const auto count = static_cast<std::uint32_t>(right - left) * static_cast<std::uint32_t>(bottom - top);
            const auto mean = [count](std::uint32_t sum) {
                return static_cast<std::uint8_t>((sum + count / 2) / count);
            };
            to.at(x, y) = {.r = mean(r), .g = mean(g), .b = mean(b), .a = 255};
        }
    }
}

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

// Turns what a PreviewDisplay shows into JPEG pictures for any number of viewers, in a thread of its own, only while
// somebody looks.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "hal/clock.h"
#include "hal/preview/preview_display.h"

namespace cheval::hal {

/// A finished picture. Immutable.
struct JpegPicture {
    std::vector<unsigned char> bytes;
    std::uint64_t number = 0;  ///< PreviewDisplay::Picture::number.
};

/// The encoder. It keeps one picture; viewers that are slow miss those in between. Thread-safe.
class JpegStream {
  public:
    /// `width` of the pictures, at most the display's; `quality` 1 … 100.
    JpegStream(PreviewDisplay& display, const DisplayMode& mode, int width, int quality);
    ~JpegStream();
    JpegStream(const JpegStream&) = delete;
    JpegStream& operator=(const JpegStream&) = delete;

    /// The latest picture as soon as its number is greater than `after`; null after `limit` of real time or stop().
    std::shared_ptr<const JpegPicture> next(std::uint64_t after, Duration limit);
    /// The latest picture; null where there is none.
    std::shared_ptr<const JpegPicture> latest();
    /// Ends next(), now and later, and the thread.
    void stop();
    [[nodiscard]] int width() const { return small_.width; }
    [[nodiscard]] int height() const { return small_.height; }

  private:
    void run();
    std::shared_ptr<const JpegPicture> encode(void* compressor, const PreviewDisplay::Picture& picture);

    PreviewDisplay& display_;
    int quality_;
    Image<Rgba8> small_;
    std::vector<std::uint32_t> sums_;
    std::vector<unsigned char> buffer_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::shared_ptr<const JpegPicture> latest_;
    bool stopped_ = false;
    std::thread thread_;
};

}  // namespace cheval::hal

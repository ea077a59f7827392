// An animated WebP picture, through libwebp and libwebpmux.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "hal/clock.h"
#include "hal/expected.h"
#include "hal/image.h"

struct WebPPicture;

namespace cheval::daemon {

/// One picture at half the size of its pixels in memory: as YUV 4:2:0, which lossy WebP would make of it anyway.
/// Move-only value.
class CompactPicture {
  public:
    /// Errors: invalidInput (empty or larger than 16383 pixels either way), resource.
    static Expected<CompactPicture> create(hal::ImageView<const hal::Rgba8> picture);

    [[nodiscard]] const WebPPicture& get() const { return *picture_; }

  private:
    struct Free {
        void operator()(WebPPicture* picture) const;
    };
    std::unique_ptr<WebPPicture, Free> picture_;
};

/// One picture of an animation and when it appears.
struct AnimationFrame {
    const CompactPicture* picture = nullptr;  ///< Not owned; all of one size.
    hal::TimePoint time{};                    ///< Rising from frame to frame.
};

/// Encodes frames as an animation that repeats for ever. The last one shows for as long as the one before it.
/// @param quality 0…100 as libwebp has it.
/// Errors: invalidInput (no frame, sizes that differ, times that do not rise), resource.
Expected<std::vector<std::byte>> encodeAnimation(const std::vector<AnimationFrame>& frames, float quality);

}  // namespace cheval::daemon

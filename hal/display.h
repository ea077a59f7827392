// The one way to a display. A display lends its buffer to be drawn into; nothing copies a full screen.
#pragma once

#include <cstdint>

#include "hal/clock.h"
#include "hal/expected.h"
#include "hal/image.h"

namespace cheval::hal {

struct DisplayMode {
    int width = 1080;  ///< Pixels as the shopper sees them (portrait).
    int height = 1920;
    double refreshHz = 30.0;
};

/// A buffer on loan: draw into `pixels`, then present() it.
struct DisplayBuffer {
    ImageView<Rgba8> pixels;
    std::uint32_t slot = 0;  ///< The display's own name for it.
};

/// Counted since open.
struct DisplayStatistics {
    std::uint64_t presented = 0;
    std::uint64_t dropped = 0;  ///< Presented but never shown: replaced by a later one, or nobody looked.
    bool connected = true;
};

/// A display. Thread-bound, but for statistics(), which any thread may call.
class Display {
  public:
    virtual ~Display() = default;
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;

    virtual Expected<DisplayMode> open() = 0;
    virtual void close() = 0;
    /// A free buffer, waiting at most `timeout` for one. At most one is on loan at a time.
    virtual Expected<DisplayBuffer> lend(Duration timeout) = 0;
    /// Gives the buffer back to be shown. `time` is the capture time of what it shows. An unplugged display accepts and
    /// drops.
    virtual Expected<void> present(const DisplayBuffer& buffer, TimePoint time) = 0;
    [[nodiscard]] virtual DisplayStatistics statistics() const = 0;

  protected:
    Display() = default;
};

}  // namespace cheval::hal

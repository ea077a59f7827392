// A device's own time stamps on our time line.
#pragma once

#include <algorithm>
#include <optional>

#include "hal/clock.h"

namespace cheval::hal {

/// Frames arrive late by the transport's delay, which varies; the device's clock is even but starts anywhere and runs a
/// little fast or slow. The difference follows the least delay seen: at once where it would put a capture after its
/// arrival, else slowly, so that frames keep the device's even distance. Thread-bound.
class DeviceClock {
  public:
    /// Forgets the device: it was opened anew.
    void reset() { difference_.reset(); }

    /// When the frame was captured that the device stamped `stamp`, and that arrived at `arrival`. Never after it.
    TimePoint captureTime(Duration stamp, TimePoint arrival) {
        const Duration difference = arrival.time_since_epoch() - stamp;
        if (!difference_ || difference > *difference_ + kJump || difference < *difference_ - kJump) {
            difference_ = difference;
        } else if (difference < *difference_) {
            // An earlier arrival than was thought possible: by small steps, or the frames' distances would jump.
            difference_ = std::max(difference, *difference_ - kStep);
        } else {
            difference_ = std::min(difference, *difference_ + kDrift);
        }
        return std::min(TimePoint(stamp + *difference_), arrival);
    }

  private:
    static constexpr Duration kJump = std::chrono::milliseconds(500);  ///< The device's clock was set anew.
    static constexpr Duration kStep = std::chrono::microseconds(200);
    static constexpr Duration kDrift = std::chrono::microseconds(4);  ///< A frame: more than any quartz drifts.

    std::optional<Duration> difference_;
};

}  // namespace cheval::hal

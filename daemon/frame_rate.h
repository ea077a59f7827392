// How many pictures a second a sensor takes.
#pragma once

#include <chrono>
#include <cstdint>

#include "hal/clock.h"
#include "hal/frame.h"

namespace cheval::daemon {

/// By the sensor's own count and times, so that frames which this machine was too slow to take in are counted too.
/// Thread-bound; takes no heap memory.
class FrameRate {
  public:
    /// A frame that does not follow the one before, or time or count that runs backwards, begins anew.
    void add(const hal::DepthFrame& frame);
    /// Frames a second over the last whole span; 0: not known yet.
    [[nodiscard]] double hz() const { return hz_; }

    /// Over how long it is taken: late frames and jitter even out.
    static constexpr hal::Duration kSpan = std::chrono::seconds(2);

  private:
    hal::TimePoint since_{};
    std::uint64_t first_ = 0;
    bool begun_ = false;
    double hz_ = 0.0;
};

}  // namespace cheval::daemon

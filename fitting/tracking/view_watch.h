// Whether the sensor's view can show anybody at all.
#pragma once

#include <array>

#include "fitting/tracking/cloud.h"
#include "fitting/users.h"
#include "hal/clock.h"

namespace cheval::fitting::tracking {

/// Judges each frame's cloud, and believes what has lasted. Thread-bound.
class ViewWatch {
  public:
    void reset() { *this = ViewWatch{}; }
    /// Nothing in the cloud is changed. A frame that could not be read has no cloud: a null pointer.
    void update(const Cloud* cloud, hal::TimePoint time);
    [[nodiscard]] ViewFault fault() const { return fault_; }

    /// What one frame shows.
    static ViewFault judge(const Cloud& cloud);

    /// How long another verdict must have lasted: somebody who walks up to the glass is no fault.
    static constexpr double kBelievedAfter = 3.0;

  private:
    ViewFault fault_ = ViewFault::none;
    ViewFault seen_ = ViewFault::none;
    hal::TimePoint since_{};
};

}  // namespace cheval::fitting::tracking

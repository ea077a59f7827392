// The active user's two hands over time: place, speed, state.
#pragma once

#include <array>
#include <cstdint>

#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "fitting/tracking/hand_openness.h"
#include "fitting/users.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Openness over time with hysteresis, so that one ragged frame changes nothing. Thread-bound.
class HandStateFilter {
  public:
    void reset() { *this = HandStateFilter{}; }
    /// One reading; `elapsed` seconds since the last.
    void read(float value, float elapsed);
    /// Nothing could be read in this frame; after kPatience seconds of that the state is unknown.
    void miss(float elapsed);

    [[nodiscard]] HandState state() const { return state_; }
    [[nodiscard]] float confidence() const { return confidence_; }

    static constexpr float kPatience = 0.25F;

  private:
    HandState state_ = HandState::unknown;
    float level_ = 0.0F;
    float confidence_ = 0.0F;
    float missing_ = 0.0F;
    bool started_ = false;
};

/// Reads both hands of a skeleton. Thread-bound; takes no memory after construction.
class HandReader {
  public:
    void reset();
    /// Sets both hands of `hands`; gestures are left alone. `stature` in metres.
    void update(const hal::DepthFrame& frame, const Users& users, const Skeleton& skeleton,
                const SensorPlacement& placement, float stature, Hands& hands);

  private:
    void readHand(const hal::DepthFrame& frame, const Users& users, const Skeleton& skeleton,
                  const SensorPlacement& placement, Side side, float elapsed, Hand& hand);

    HandOpennessContext context_;
    std::array<HandStateFilter, kSideCount> states_;
    std::uint32_t userId_ = 0;
    hal::TimePoint lastTime_{};
};

}  // namespace cheval::fitting::tracking

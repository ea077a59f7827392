// Swipe, grab, raise and hold from how hands move (D2) and open and close (D3).
#pragma once

#include <array>
#include <cstdint>

#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "fitting/tracking/gesture_options.h"
#include "hal/clock.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Watches both hands. One gesture, one event, reported in the frame that completes it. Thread-bound.
class GestureReader {
  public:
    GestureReader() = default;
    explicit GestureReader(const GestureOptions& options) : options_(options) {}
    void reset();

    /// Appends this frame's gestures to `hands`, whose hands have been read, and sets Hand::holding. `stature` in
    /// metres. What does not fit into kMaximumGestures is dropped.
    void update(const hal::DepthFrame& frame, const Skeleton& skeleton, float stature, Hands& hands);

  private:
    struct Moment {
        hal::TimePoint time{};
        std::uint64_t frame = 0;
    };
    enum class Grab : std::uint8_t { idle, open, closed };
    struct HandWatch {
        // Swipe.
        bool stroke = false;
        float direction = 0.0F;  ///< +1: to the shopper's left.
        float peak = 0.0F;
        Eigen::Vector2f from = Eigen::Vector2f::Zero();  ///< Left and up of the neck, statures.
        Moment strokeStart;
        // Grab.
        Grab grab = Grab::idle;
        Moment grabStart;
        float sureness = 0.0F;  ///< Confidence that it is closed, summed over the seconds that it has been.
        // Raise.
        bool up = false, counted = false;
        Moment upSince, downSince;
        // Hold. Places are about the neck, in statures.
        bool still = false;
        Eigen::Vector3f stillAt = Eigen::Vector3f::Zero();
        Moment stillSince;
        bool spent = false, held = false;  ///< It has gestured here; the last gesture was a hold.
        Eigen::Vector3f spentAt = Eigen::Vector3f::Zero();
        bool lowered = true;
        Moment loweredSince;
        // Speed of the hand about the body.
        bool seen = false;
        Eigen::Vector2f last = Eigen::Vector2f::Zero();
        Eigen::Vector2f velocity = Eigen::Vector2f::Zero();
    };

    /// Both return whether this frame completed one.
    bool watchSwipe(HandWatch& watch, const Moment& now, const Eigen::Vector2f& at, bool raised, Side side,
                    Hands& hands) const;
    bool watchGrab(HandWatch& watch, const Moment& now, const Eigen::Vector2f& at, const Hand& hand, Side side,
                   Hands& hands) const;
    /// `about`: from the neck to the hand, statures. `gestured`: this frame completed another gesture of the hand.
    /// Returns what Hand::holding is.
    float watchHold(HandWatch& watch, const Moment& now, const Hand& hand, const Eigen::Vector3f& about, bool gestured,
                    Side side, Hands& hands) const;
    void watchRaise(HandWatch& watch, const Moment& now, bool up, Side side, Hands& hands) const;

    GestureOptions options_;
    std::array<HandWatch, kSideCount> watches_{};
    std::uint32_t userId_ = 0;
    hal::TimePoint lastTime_{};
    Eigen::Vector3f lastNeck_ = Eigen::Vector3f::Zero();
    Eigen::Vector3f neckVelocity_ = Eigen::Vector3f::Zero();  ///< Statures a second.
};

}  // namespace cheval::fitting::tracking

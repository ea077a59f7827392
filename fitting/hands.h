// What the shopper's hands do (D2, D3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "hal/clock.h"

namespace cheval::fitting {

enum class HandState : std::uint8_t { unknown, open, closed };

/// As tracks files and people name it.
constexpr std::string_view nameOf(HandState state) {
    switch (state) {
        case HandState::open:
            return "open";
        case HandState::closed:
            return "closed";
        case HandState::unknown:
            break;
    }
    return "unknown";
}

/// One hand. Mirror frame, metres.
struct Hand {
    HandState state = HandState::unknown;
    float confidence = 0.0F;                             ///< Of the state, 0…1.
    Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< Centre of the palm.
    bool raised = false;                                 ///< Held up as one does to point or grab.
    float holding = 0.0F;  ///< 0…1, how much of a hold is done; 1 from its event until the hand goes away or down.
};

enum class GestureKind : std::uint8_t {
    swipe,  ///< Sideways.
    grab,   ///< Closed, then open again.
    raise,  ///< Up above the shoulder.
    hold,   ///< Open and kept still: to confirm.
};
enum class SwipeDirection : std::uint8_t { left, right };  ///< As the shopper sees it.

/// One gesture, reported once, when it is complete.
struct GestureEvent {
    GestureKind kind = GestureKind::swipe;
    Side hand = Side::right;
    SwipeDirection direction = SwipeDirection::left;  ///< Swipes only.
    hal::TimePoint start{};
    hal::TimePoint end{};
    std::uint64_t startFrame = 0;  ///< DepthFrame::sourceIndex.
    std::uint64_t endFrame = 0;
};

inline constexpr std::size_t kMaximumGestures = 4;

/// Both hands in one frame, and the gestures that this frame completed.
struct Hands {
    std::array<Hand, kSideCount> hands{};
    std::array<GestureEvent, kMaximumGestures> gestures{};
    std::size_t gestureCount = 0;

    Hand& operator[](Side side) { return hands[index(side)]; }
    const Hand& operator[](Side side) const { return hands[index(side)]; }
};

}  // namespace cheval::fitting

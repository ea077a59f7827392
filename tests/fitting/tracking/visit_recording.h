// One visit of the simulated kiosk as the tracker saw it, frame by frame, beside what was really there.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "hal/sim/world.h"

namespace cheval::fitting::test {

inline constexpr double kVisitFramesPerSecond = 30.0;

/// Which figures stand where an active user is said to be.
inline constexpr int kNobody = -1;  ///< There is no active user in the picture …
inline constexpr int kRoom = -2;    ///< … or it is a piece of the room.

struct SeenFrame {
    double time = 0.0;  ///< Seconds of the world.
    // What is there.
    bool inRoom = false;        ///< The shopper.
    bool whollyInView = false;  ///< No part of the shopper beyond the picture's edge.
    bool torsoInPicture = false;
    Skeleton truth;  ///< The shopper's; mirror frame.
    std::array<bool, kJointCount> visible{};
    std::array<HandState, kSideCount> trueHands{};
    std::optional<Eigen::Vector3f> other;  ///< From the shopper's torso to that of the nearest other person in view.
    // What was seen.
    Skeleton tracked;
    Hands hands;
    std::uint32_t activeId = 0;
    int activeFigure = kNobody;  ///< Place in WorldTruth::figures of whom most of the active user's pixels show.
};

/// Whether the skeleton is the shopper's.
inline bool tracksShopper(const SeenFrame& frame) {
    return frame.tracked.present() && frame.activeFigure == 0;
}

/// Who comes: what the tracker finds easier or harder.
enum class ShopperKind : std::uint8_t { adult, child, seated };
inline constexpr std::size_t kShopperKindCount = 3;
inline constexpr std::array<const char*, kShopperKindCount> kShopperKindNames = {"adult", "child", "wheelchair"};

struct VisitRecording {
    hal::sim::Script script = hal::sim::Script::visit;
    std::uint32_t seed = 0;
    ShopperKind shopper = ShopperKind::adult;
    std::vector<SeenFrame> frames;
    std::vector<hal::sim::MeantGesture> meant;
};

/// Runs a fresh tracker over the first visit of a world of that seed.
VisitRecording recordVisit(hal::sim::Script script, std::uint32_t seed, double seconds);

/// Whether each joint can be seen, by the definition of shared/data/shoppers: in the picture, and the exact surface at
/// its pixel at most 150 mm before it; 250 mm where that surface is the joint's own body part, 60 mm for palms behind
/// anything but their own arm. `figure` is the owner's number in `exact`, counted from 1.
std::array<bool, kJointCount> visibleJoints(const Skeleton& skeleton, const SensorPlacement& placement,
                                            const hal::Intrinsics& intrinsics, const hal::sim::ExactView& exact,
                                            std::uint8_t figure);

}  // namespace cheval::fitting::test

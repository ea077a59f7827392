// Pre-rendered frames for the benchmarks of tracking, with the truth about them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fitting/skeleton.h"
#include "hal/frame.h"
#include "hal/image.h"
#include "hal/sim/world.h"

namespace cheval::bench {

/// One frame, kept, with the truth.
struct TrackingFrame {
    hal::Image<std::uint16_t> depth;  ///< As a noisy sensor reads it.
    hal::Image<std::uint16_t> exact;  ///< The same without noise, shadows and failures; empty unless asked for.
    hal::Image<std::uint8_t> owner;   ///< hal::sim::ExactView::owner; empty unless asked for.
    fitting::Skeleton skeleton;       ///< The shopper's, mirror frame; present while they are wholly in view.
    std::size_t people = 0;           ///< In the room.
    hal::DepthFrame frame;            ///< Its depth view is `depth`.
};

struct VisitRequest {
    hal::sim::Script script = hal::sim::Script::visit;
    std::uint32_t seed = 1;
    int first = 0;  ///< Frame numbers of the simulated kiosk, at thirty a second.
    int count = 0;
    int step = 1;
    bool exact = false;
};

/// Frames of the simulated kiosk.
std::vector<TrackingFrame> simulatedVisit(const VisitRequest& request);

/// Puts the shopper of each frame of `from` into the same frame of `into`, `right` pixels further to the right, before
/// or behind whoever is there. Both need the exact scene.
void addShopper(const std::vector<TrackingFrame>& from, int right, std::vector<TrackingFrame>& into);

/// The simulated kiosk's mount.
hal::Mount simulatedMount();

}  // namespace cheval::bench

#include "tests/bench/tracking_frames.h"

#include <utility>

#include "hal/sim/world.h"

namespace cheval::bench {
namespace {

constexpr double kFramesPerSecond = 30.0;
/// What is nearer than the empty room by this much is the shopper, millimetres.
constexpr int kBeforeTheRoom = 20;

}  // namespace

hal::Mount simulatedMount() {
    return hal::sim::WorldOptions{}.mount;
}

std::vector<TrackingFrame> simulatedVisit(const VisitRequest& request) {
    hal::sim::WorldOptions options{.seed = request.seed, .framesPerSecond = kFramesPerSecond, .colour = false};
    const auto world = hal::sim::makeWorld(options);
    options.sensorNoise = false;
    const auto quiet = hal::sim::makeWorld(options);
    hal::Image<hal::Rgb8> none;
    hal::Image<std::uint16_t> room;
    if (request.exact) {
        // In the middle of the pause between two visits.
        const double empty = options.visitSeconds + 0.5 * options.pauseSeconds;
        hal::sim::renderFrame(*quiet, static_cast<std::uint64_t>(empty * kFramesPerSecond), room, none);
    }
    std::vector<TrackingFrame> frames(static_cast<std::size_t>(request.count));
    int number = request.first;
    for (TrackingFrame& frame : frames) {
        const auto index = static_cast<std::uint64_t>(number);
        hal::sim::renderFrame(*world, index, frame.depth, none);
        const hal::sim::WorldTruth truth = hal::sim::truthAt(*world, world->timeOf(index));
        if (truth.present) frame.skeleton = truth.skeleton;
        if (request.exact) {
            hal::sim::renderFrame(*quiet, index, frame.exact, none);
            frame.person.resize(frame.exact.width, frame.exact.height);
            for (std::size_t i = 0; i < room.pixels.size(); ++i) {
                const int here = frame.exact.pixels[i];
                const int before = room.pixels[i];
                frame.person.pixels[i] = here != 0 && (before == 0 || here < before - kBeforeTheRoom) ? 1 : 0;
            }
        }
        frame.frame.sequence = frame.frame.sourceIndex = index;
        frame.frame.captureTime = hal::TimePoint(hal::fromSeconds(world->timeOf(index)));
        frame.frame.depth = std::as_const(frame.depth).view();
        number += request.step;
    }
    return frames;
}

}  // namespace cheval::bench

#include "tests/bench/tracking_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cheval::bench {

hal::Mount simulatedMount() {
    return hal::sim::WorldOptions{}.mount;
}

std::vector<TrackingFrame> simulatedVisit(const VisitRequest& request) {
    const auto world = hal::sim::makeWorld({.seed = request.seed, .colour = false, .script = request.script});
    hal::Image<hal::Rgb8> none;
    std::vector<TrackingFrame> frames(static_cast<std::size_t>(request.count));
    int number = request.first;
    for (TrackingFrame& frame : frames) {
        const auto index = static_cast<std::uint64_t>(number);
        number += request.step;
        hal::sim::renderFrame(*world, index, frame.depth, none);
        const hal::sim::WorldTruth truth = hal::sim::truthAt(*world, world->timeOf(index));
        if (truth.present) {
            frame.skeleton = truth.skeleton;
            frame.skeleton.userId = 1;
        }
        for (std::size_t i = 0; i < truth.figureCount; ++i) {
            const hal::sim::FigureTruth& figure = truth.figures[i];
            frame.people += figure.inRoom && figure.kind == hal::sim::FigureKind::shopper ? 1 : 0;
        }
        if (request.exact) {
            const hal::sim::ExactView exact = hal::sim::exactView(*world);
            hal::copyInto(exact.owner, frame.owner);
            frame.exact.resize(exact.depth.width, exact.depth.height);
            for (int y = 0; y < exact.depth.height; ++y) {
                std::transform(exact.depth.row(y), exact.depth.row(y) + exact.depth.width, frame.exact.view().row(y),
                               [](float depth) { return static_cast<std::uint16_t>(std::lround(depth)); });
            }
        }
        frame.frame.sequence = frame.frame.sourceIndex = index;
        frame.frame.captureTime = hal::TimePoint(hal::fromSeconds(world->timeOf(index)));
        frame.frame.depth = std::as_const(frame.depth).view();
    }
    return frames;
}

void addShopper(const std::vector<TrackingFrame>& from, int right, std::vector<TrackingFrame>& into) {
    for (std::size_t i = 0; i < std::min(from.size(), into.size()); ++i) {
        const TrackingFrame& other = from[i];
        TrackingFrame& frame = into[i];
        frame.people += other.people;
        for (int y = 0; y < frame.depth.height; ++y) {
            for (int x = std::max(0, -right); x < std::min(frame.depth.width, frame.depth.width - right); ++x) {
                if (other.owner.view().at(x, y) == 0) continue;
                std::uint16_t& exact = frame.exact.view().at(x + right, y);
                if (exact != 0 && exact < other.exact.view().at(x, y)) continue;
                exact = other.exact.view().at(x, y);
                frame.depth.view().at(x + right, y) = other.depth.view().at(x, y);
            }
        }
    }
}

}  // namespace cheval::bench

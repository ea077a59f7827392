// What measuring a shopper costs a frame, what the body's mesh costs from its parameters, and what is measured: mean
// error of the girths over the frames' shopper, beside the proportions alone (D12) in the same run.
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "fitting/body/body.h"
#include "fitting/body/body_estimator.h"
#include "fitting/body/body_measures.h"
#include "fitting/tracking/tracker.h"
#include "hal/sim/view.h"
#include "hal/sim/world.h"
#include "tests/support/allocation_counter.h"

namespace {

using namespace cheval;
using namespace cheval::fitting;

constexpr double kFramesPerSecond = 30.0;
constexpr std::uint64_t kFirstFrame = 150;  // The shopper stands before the glass …
constexpr std::uint64_t kFrames = 120;      // … and has begun to turn.

const Body& body() {
    static const Body kBody = [] {
        auto loaded = loadBody(std::string(CHEVAL_ASSETS) + "/body.glb");
        return loaded ? std::move(*loaded) : Body{};
    }();
    return kBody;
}

/// What the tracker says of one frame, kept.
struct Seen {
    hal::Image<std::uint16_t> depth;
    hal::Image<std::uint8_t> map;
    Users users;
    Skeleton skeleton;
    SensorPlacement placement;
    hal::DepthFrame frame;
};

struct Visit {
    std::vector<Seen> frames;
    std::array<float, kDimensionCount> truth{};
};

const Visit& visit() {
    static const Visit kVisit = [] {
        Visit made;
        const auto world = hal::sim::makeWorld({.seed = 50'002,
                                                .colour = false,
                                                .script = hal::sim::Script::measuring,
                                                .visitSeconds = 23.0,
                                                .clothing = hal::sim::Clothing::tight});
        Tracker tracker(TrackerOptions{.mount = world->options().mount});
        hal::Image<std::uint16_t> depth;
        hal::Image<hal::Rgb8> none;
        for (std::uint64_t i = 0; i < kFirstFrame + kFrames; ++i) {
            hal::sim::renderFrame(*world, i, depth, none);
            hal::DepthFrame frame{.sequence = i,
                                  .sourceIndex = i,
                                  .captureTime = hal::TimePoint(hal::fromSeconds(world->timeOf(i))),
                                  .restart = i == 0,
                                  .lastOfStill = true,
                                  .depth = depth.view()};
            tracker.track(frame);
            if (i < kFirstFrame) continue;
            Seen& seen = made.frames.emplace_back();
            seen.depth = depth;
            hal::copyInto(tracker.users().map, seen.map);
            seen.users = tracker.users();
            seen.skeleton = tracker.skeleton();
            seen.placement = tracker.placement();
            seen.frame = frame;
            seen.frame.restart = false;
        }
        for (Seen& seen : made.frames) {
            seen.frame.depth = std::as_const(seen.depth).view();
            seen.users.map = std::as_const(seen.map).view();
        }
        made.truth = hal::sim::truthAt(*world, world->timeOf(kFirstFrame)).figures[0].measurements;
        return made;
    }();
    return kVisit;
}

void measureFrame(benchmark::State& state, bool fitted) {
    const Visit& frames = visit();
    Body scaled;
    if (!fitted) {
        scaled = body();
        scaled.shapes = {};
    }
    BodyEstimator estimator(fitted ? body() : scaled, {});
    std::size_t next = 0;
    std::uint64_t taken = 0;
    for ([[maybe_unused]] auto _ : state) {
        const Seen& seen = frames.frames[next];
        const test::AllocationCounter counter;
        estimator.update(seen.frame, seen.users, seen.skeleton, seen.placement);
        taken += counter.count();
        next = (next + 1) % frames.frames.size();
    }
    state.counters["allocations"] = static_cast<double>(taken);
    double error = 0.0;
    int told = 0;
    for (const Dimension girth : {Dimension::chestGirth, Dimension::waistGirth, Dimension::hipGirth}) {
        const Measurement& measured = estimator.measurements()[girth];
        if (!measured.valid) continue;
        error += std::abs(static_cast<double>(measured.value - frames.truth[static_cast<std::size_t>(girth)]));
        ++told;
    }
    state.counters["girths_told"] = told;
    if (told > 0) state.counters["girth_error_mm"] = 1e3 * error / told;
    const Measurement& stature = estimator.measurements()[Dimension::stature];
    if (stature.valid)
        state.counters["stature_error_mm"] = 1e3 * std::abs(static_cast<double>(stature.value - frames.truth[0]));
}
BENCHMARK_CAPTURE(measureFrame, fitted, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(measureFrame, proportionsAlone, false)->Unit(benchmark::kMicrosecond);

/// Mesh, normals, cage and joints from parameters; `us_per_10000` is for 10 000 vertices.
void shapeFromParameters(benchmark::State& state, float share) {
    BodyShape shape{.parameters = body().shapes.mean, .fitted = share};
    ShapedBody shaped;
    shapeBody(body(), shape, shaped);
    for ([[maybe_unused]] auto _ : state) {
        shapeBody(body(), shape, shaped);
        benchmark::DoNotOptimize(shaped.positions.data());
    }
    const auto vertices = static_cast<double>(body().mesh.positions.size());
    state.counters["vertices"] = vertices;
    state.counters["per_10000_vertices"] = benchmark::Counter(
        vertices / 10'000.0, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(shapeFromParameters, fitted, 1.0F)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(shapeFromParameters, scaled, 0.0F)->Unit(benchmark::kMicrosecond);

void measureBody(benchmark::State& state) {
    const BodyMeasures measures(body());
    for ([[maybe_unused]] auto _ : state)
        benchmark::DoNotOptimize(measures.measure(body().mesh.positions, body().joints));
}
BENCHMARK(measureBody)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();

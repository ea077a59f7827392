// What it costs that the sensor lives in a process of its own: the hand-over of a frame, its latency beside that of the
// same camera read in this process, and the processor time of cheval-sensor, which pictures made beforehand keep apart
// from the cost of making them.
#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <unistd.h>

#include "hal/sensor_process/frame_ring.h"
#include "hal/sensor_process/process_camera.h"
#include "hal/sim/openni/sensor_spec.h"
#include "tests/support/sensor_world.h"

namespace {

using namespace cheval;

constexpr int kFrames = 600;
constexpr double kFramesPerSecond = 30.0;
constexpr const char* kPictures = "seed=2,noise=1,preload=30";

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// User and system time of a process, in seconds.
double processorSeconds(pid_t process) {
    std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
    std::string text((std::istreambuf_iterator<char>(stat)), {});
    text.erase(0, text.rfind(')') + 2);
    std::vector<std::string> fields;
    for (std::size_t begin = 0; begin < text.size(); begin = text.find(' ', begin) + 1) {
        fields.push_back(text.substr(begin, text.find(' ', begin) - begin));
        if (text.find(' ', begin) == std::string::npos) break;
    }
    return (std::stod(fields.at(11)) + std::stod(fields.at(12))) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// 640×480 depth and colour across the ring and back into view; beside it the bare copy of the same bytes.
void ring(benchmark::State& state) {
    auto memory = hal::RingMemory::create();
    auto other = hal::RingMemory::attach(hal::Descriptor(::dup(memory->descriptor())));
    hal::RingReader reader(std::move(*memory));
    hal::RingWriter writer(std::move(*other));
    hal::Image<std::uint16_t> depth(640, 480, 1500);
    hal::Image<hal::Rgb8> colour(640, 480, {.r = 1, .g = 2, .b = 3});
    hal::DepthFrame given{.depth = std::as_const(depth).view(), .colour = std::as_const(colour).view()};
    const hal::SteadyClock clock;
    std::vector<double> takes;
    for ([[maybe_unused]] auto each : state) {
        ++given.sequence;
        if (!writer.write(given, 1)) state.SkipWithError("refused");
        hal::DepthFrame frame;
        const hal::TimePoint before = clock.now();
        if (reader.take(frame) != hal::RingReader::Status::frame) state.SkipWithError("no frame");
        takes.push_back(hal::seconds(clock.now() - before) * 1e3);
        benchmark::DoNotOptimize(frame);
    }
    state.counters["take_ms"] = quantile(takes, 0.5);
}
BENCHMARK(ring)->Unit(benchmark::kMillisecond);

void bareCopy(benchmark::State& state) {
    const std::vector<std::byte> from(std::size_t{640} * 480 * 5);
    std::vector<std::byte> to(from.size());
    for ([[maybe_unused]] auto each : state) {
        std::memcpy(to.data(), from.data(), from.size());
        benchmark::ClobberMemory();
    }
}
BENCHMARK(bareCopy)->Unit(benchmark::kMillisecond);

/// Milliseconds from when each frame was due until it was there, and the share of frames that came.
struct Watched {
    std::vector<double> latencies;
    std::vector<double> handOvers;
    double share = 0.0;
};

Watched watch(hal::DepthCamera& camera, const hal::ProcessCamera* process, hal::TimePoint zero,
              const hal::Clock& clock) {
    Watched watched;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    for (int i = 0; i < kFrames; ++i) {
        hal::DepthFrame frame;
        if (camera.waitFrame(std::chrono::seconds(5), frame) != hal::FrameStatus::frame) break;
        const hal::TimePoint due = zero + hal::fromSeconds(static_cast<double>(frame.sequence) / kFramesPerSecond);
        watched.latencies.push_back(hal::seconds(clock.now() - due) * 1e3);
        if (process != nullptr) watched.handOvers.push_back(hal::seconds(process->handOver()) * 1e3);
        if (i == 0) first = frame.sequence;
        last = frame.sequence;
    }
    watched.share = static_cast<double>(watched.latencies.size()) / static_cast<double>(last - first + 1);
    return watched;
}

void split(benchmark::State& state) {
    hal::SteadyClock clock;
    const hal::TimePoint zero = clock.now();
    const std::string spec = test::SensorWorld::visitInProgress(kPictures, hal::seconds(clock.now() - zero));
    const test::SensorWorld world(spec);
    const hal::TimePoint start(hal::Duration(std::stoll(spec.substr(spec.find("start_ns=") + 9))));
    for ([[maybe_unused]] auto each : state) {
        const auto camera =
            hal::makeProcessCamera({.program = CHEVAL_SENSOR, .environment = world.environment()}, clock);
        if (!camera->open()) {
            state.SkipWithError("cheval-sensor does not open");
            return;
        }
        const double before = processorSeconds(camera->process());
        const hal::TimePoint began = clock.now();
        const Watched watched = watch(*camera, camera.get(), start, clock);
        const double wall = hal::seconds(clock.now() - began);
        state.counters["sensor_core_percent"] = 100.0 * (processorSeconds(camera->process()) - before) / wall;
        state.counters["latency_p50_ms"] = quantile(watched.latencies, 0.5);
        state.counters["latency_p99_ms"] = quantile(watched.latencies, 0.99);
        state.counters["hand_over_p50_ms"] = quantile(watched.handOvers, 0.5);
        state.counters["hand_over_p99_ms"] = quantile(watched.handOvers, 0.99);
        state.counters["frames_share"] = watched.share;
    }
}
BENCHMARK(split)->Iterations(1)->Unit(benchmark::kSecond)->UseRealTime();

/// The baseline: the same pictures at the same times, read in this process, without OpenNI2 and without a ring.
void together(benchmark::State& state) {
    hal::SteadyClock clock;
    const std::string text = test::SensorWorld::visitInProgress(kPictures, 0.0);
    const hal::TimePoint start(hal::Duration(std::stoll(text.substr(text.find("start_ns=") + 9))));
    for ([[maybe_unused]] auto each : state) {
        const auto spec = hal::sim::parseSensorSpec(text);
        std::shared_ptr<hal::sim::World> world;
        const auto camera = hal::sim::makeSpecCamera(*spec, world, clock);
        if (!camera || !(*camera)->open()) {
            state.SkipWithError("the camera does not open");
            return;
        }
        const Watched watched = watch(**camera, nullptr, start, clock);
        state.counters["latency_p50_ms"] = quantile(watched.latencies, 0.5);
        state.counters["latency_p99_ms"] = quantile(watched.latencies, 0.99);
        state.counters["frames_share"] = watched.share;
    }
}
BENCHMARK(together)->Iterations(1)->Unit(benchmark::kSecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();

// What seeing costs: track() and readHands() at 640×480 on one core, and how far the joints are from the truth, beside
// a baseline that only knows where the person is. Counters:
//   p50_ms, p99_ms      processor time of a frame with that many people in the room, joints and hands together,
//   wall_p99_ms         the same by the wall's clock, which other programs delay,
//   users, allocations  a frame: how many were found, and how often memory was taken,
//   joints_mm, standing_mm
//                       mean distance of a joint from the truth: as tracked, and for a figure of usual proportions that
//                       stands upright, arms down, where the user map has the person,
//   in_PART_ms          where the time goes: mean processor time of a frame spent in that class of fitting/tracking, by
//                       samples of the stack; the rest is the user map.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include "fitting/tracking/tracker.h"
#include "hal/replay/replay_camera.h"
#include "tests/bench/stack_sampler.h"
#include "tests/bench/tracking_frames.h"
#include "tests/support/allocation_counter.h"

namespace {

using namespace cheval;
using fitting::Joint;

double processorMilliseconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

/// Someone of this stature who stands upright where the person's points are: heights and breadths by Drillis and
/// Contini, in Winter, Biomechanics and Motor Control of Human Movement. What joints are worth must show against it.
fitting::Skeleton standingFigure(const fitting::User& user) {
    struct Place {
        float height, left;  ///< Shares of the stature, from the floor and from the middle.
    };
    constexpr std::array<Place, fitting::kJointCount> kPlaces = {{{0.936F, 0.0F},
                                                                  {0.850F, 0.0F},
                                                                  {0.690F, 0.0F},
                                                                  {0.818F, 0.115F},
                                                                  {0.630F, 0.135F},
                                                                  {0.430F, 0.150F},
                                                                  {0.818F, -0.115F},
                                                                  {0.630F, -0.135F},
                                                                  {0.430F, -0.150F},
                                                                  {0.530F, 0.055F},
                                                                  {0.285F, 0.060F},
                                                                  {0.039F, 0.065F},
                                                                  {0.530F, -0.055F},
                                                                  {0.285F, -0.060F},
                                                                  {0.039F, -0.065F}}};
    fitting::Skeleton figure;
    const float stature = user.upper.y();
    for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
        // Who faces the glass has the left at −X; the surface that is seen lies before the joints.
        figure.joints[i].position = {user.centroid.x() - kPlaces[i].left * stature, kPlaces[i].height * stature,
                                     user.centroid.z() + 0.06F};
    }
    return figure;
}

/// What one run through a row of frames gives.
struct Findings {
    std::vector<double> processor, wall;  ///< Milliseconds, of the frames that count.
    std::uint64_t users = 0;              ///< Found in them.
    double joints = 0.0, standing = 0.0;  ///< Sums, metres.
    std::uint64_t jointCount = 0;
    std::uint64_t allocations = 0, frames = 0;

    void compare(const fitting::Tracker& tracker, const fitting::Skeleton& truth, const std::vector<bool>& visible) {
        const fitting::User* active = tracker.users().active();
        if (active == nullptr || !tracker.skeleton().present() || !truth.present()) return;
        // Of several people the one who is tracked may be another than the one whose joints are known.
        if ((active->centroid - truth[Joint::torso].position).norm() > 0.4F) return;
        const fitting::Skeleton figure = standingFigure(*active);
        for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
            if (!visible[i]) continue;
            joints += (tracker.skeleton().joints[i].position - truth.joints[i].position).norm();
            standing += (figure.joints[i].position - truth.joints[i].position).norm();
            ++jointCount;
        }
    }
    [[nodiscard]] double meanMilliseconds() const {
        return std::accumulate(processor.begin(), processor.end(), 0.0) /
               static_cast<double>(std::max<std::size_t>(processor.size(), 1));
    }
    void report(benchmark::State& state) const {
        const auto mean = [](double sum, std::uint64_t count) {
            return sum / static_cast<double>(std::max<std::uint64_t>(count, 1));
        };
        state.counters["frames"] = static_cast<double>(processor.size());
        state.counters["users"] = mean(static_cast<double>(users), processor.size());
        state.counters["p50_ms"] = quantile(processor, 0.5);
        state.counters["p99_ms"] = quantile(processor, 0.99);
        state.counters["wall_p99_ms"] = quantile(wall, 0.99);
        state.counters["allocations"] = mean(static_cast<double>(allocations), frames);
        state.counters["joints_mm"] = mean(1e3 * joints, jointCount);
        state.counters["standing_mm"] = mean(1e3 * standing, jointCount);
    }
};

/// Takes one frame through the tracker; its time counts if `counts`.
void take(fitting::Tracker& tracker, const hal::DepthFrame& frame, bool counts, Findings& findings) {
    const test::AllocationCounter allocations;
    const auto wall = std::chrono::steady_clock::now();
    const double processor = processorMilliseconds();
    tracker.track(frame);
    tracker.readHands(frame);
    const double took = processorMilliseconds() - processor;
    const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - wall;
    findings.allocations += allocations.count();
    ++findings.frames;
    if (!counts) return;
    findings.users += tracker.users().count;
    findings.processor.push_back(took);
    findings.wall.push_back(passed.count());
}

/// A shopper's visit, alone or with two others who come at the same time and stay, to either side.
std::vector<bench::TrackingFrame> visitOf(std::size_t people, std::uint32_t seed) {
    constexpr int kFrames = 420;
    constexpr int kApart = 205;  ///< Pixels, which are a metre where they stand.
    const bool others = people == 3;
    std::vector<bench::TrackingFrame> visit = bench::simulatedVisit({.seed = seed, .count = kFrames, .exact = others});
    for (const int side : {-1, 1}) {
        if (!others) break;
        const std::uint32_t own = 10 * seed + (side < 0 ? 1U : 2U);
        bench::addShopper(
            bench::simulatedVisit({.script = hal::sim::Script::resting, .seed = own, .count = kFrames, .exact = true}),
            side * kApart, visit);
    }
    return visit;
}

/// Frames with `people` in the room count.
void simulated(benchmark::State& state, std::size_t people) {
    const std::vector<bool> all(fitting::kJointCount, true);
    std::vector<std::vector<bench::TrackingFrame>> visits;
    for (const std::uint32_t seed : {1U, 2U, 3U})
        visits.push_back(visitOf(people, seed));
    Findings findings;
    for ([[maybe_unused]] auto each : state) {
        for (const std::vector<bench::TrackingFrame>& visit : visits) {
            fitting::Tracker tracker({.mount = bench::simulatedMount()});
            for (const bench::TrackingFrame& frame : visit) {
                take(tracker, frame.frame, frame.people == people, findings);
                findings.compare(tracker, frame.skeleton, all);
            }
        }
    }
    findings.report(state);

    // Once more, and again, to look where the time of those frames goes.
    constexpr double kSampledMilliseconds = 8000.0;
    Findings sampled;
    bench::StackSampler sampler;
    for (const double began = processorMilliseconds(); processorMilliseconds() - began < kSampledMilliseconds;) {
        for (const std::vector<bench::TrackingFrame>& visit : visits) {
            fitting::Tracker tracker({.mount = bench::simulatedMount()});
            for (const bench::TrackingFrame& frame : visit) {
                sampler.look(frame.people == people);
                take(tracker, frame.frame, frame.people == people, sampled);
            }
        }
    }
    for (const auto& [part, share] : sampler.shares("cheval::fitting::tracking::")) {
        if (share >= 0.005)
            state.counters["in_" + (part.empty() ? "rest" : part) + "_ms"] = share * sampled.meanMilliseconds();
    }
}

void oneUser(benchmark::State& state) {
    simulated(state, 1);
}
void threeUsers(benchmark::State& state) {
    simulated(state, 3);
}
BENCHMARK(oneUser)->Iterations(1)->Unit(benchmark::kMillisecond)->Name("tracking/one_user");
BENCHMARK(threeUsers)->Iterations(1)->Unit(benchmark::kMillisecond)->Name("tracking/three_users");

/// The five recordings: people and a sensor that are not ours. Joints that can be seen count.
void recordings(benchmark::State& state) {
    const std::filesystem::path folder = std::filesystem::path(CHEVAL_DATA) / "shoppers";
    Findings findings;
    for ([[maybe_unused]] auto each : state) {
        for (const char* sequence : {"seq01", "seq02", "seq03", "seq04", "seq05"}) {
            hal::VirtualClock clock;
            auto camera = hal::makeReplayCamera({.folder = (folder / sequence).string()}, clock);
            std::ifstream file(folder / sequence / "truth.json");
            const nlohmann::json truth = nlohmann::json::parse(file, nullptr, false);
            if (!camera || !(*camera)->open() || truth.is_discarded()) {
                state.SkipWithError("CHEVAL_DATA has no such recording");
                return;
            }
            fitting::Tracker tracker({.mount = (*camera)->info().mount});
            hal::DepthFrame frame;
            while ((*camera)->waitFrame(std::chrono::seconds(5), frame) == hal::FrameStatus::frame) {
                take(tracker, frame, true, findings);
                const nlohmann::json& at = truth["truth"][frame.sourceIndex];
                fitting::Skeleton expected;
                expected.userId = 1;
                std::vector<bool> visible(fitting::kJointCount);
                for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
                    const std::string name(fitting::kJointNames[i]);
                    const nlohmann::json& where = at["joints"][name];
                    visible[i] = at["visible"][name].get<bool>();
                    expected.joints[i].position = tracker.placement().toMirror(
                        Eigen::Vector3f(where[0].get<float>(), where[1].get<float>(), where[2].get<float>()));
                }
                findings.compare(tracker, expected, visible);
            }
        }
    }
    findings.report(state);
}

BENCHMARK(recordings)->Iterations(1)->Unit(benchmark::kMillisecond)->Name("tracking/recordings");

}  // namespace

BENCHMARK_MAIN();

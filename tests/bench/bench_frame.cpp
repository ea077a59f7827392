// The frame budget, measured: pre-rendered frames of the simulated shopper through the mirror's own chain and renderer,
// 1080×1920 out, one garment, both views. Every figure is a counter, in milliseconds, counts or megabytes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <unistd.h>

#include "config/settings_table.h"
#include "daemon/mirror.h"
#include "daemon/room_options.h"
#include "hal/headless/headless_display.h"
#include "hal/sim/world.h"
#include "tests/support/allocation_counter.h"

namespace {

using namespace cheval;

/// One frame, kept.
struct Recorded {
    hal::DepthFrame frame;
    hal::Image<std::uint16_t> depth;
    hal::Image<hal::Rgb8> colour;
};

/// A visit of the simulated shopper, rendered once, so that the world's own cost is not the mirror's.
const std::vector<Recorded>& recordedVisit() {
    static const std::vector<Recorded> kVisit = [] {
        constexpr int kFrames = 300;
        std::vector<Recorded> visit(kFrames);
        hal::VirtualClock clock;
        const auto world = hal::sim::makeWorld(daemon::worldOptions(config::defaultSettings()));
        const auto camera = hal::sim::makeSimulatedCamera(world, clock);
        if (!camera->open()) std::abort();
        for (Recorded& recorded : visit) {
            hal::DepthFrame frame;
            while (camera->waitFrame(std::chrono::seconds(1), frame) != hal::FrameStatus::frame) {
            }
            hal::copyInto(frame.depth, recorded.depth);
            hal::copyInto(frame.colour, recorded.colour);
            recorded.frame = frame;
        }
        return visit;
    }();
    return kVisit;
}

/// Plays the visit; it ends with the last frame.
class VisitCamera final : public hal::DepthCamera {
  public:
    explicit VisitCamera(hal::Clock& clock) : clock_(clock) {}
    ~VisitCamera() override { close(); }
    VisitCamera(const VisitCamera&) = delete;
    VisitCamera& operator=(const VisitCamera&) = delete;

  protected:
    Expected<hal::CameraInfo> doOpen() override {
        return hal::CameraInfo{.name = "pre-rendered visit", .mount = hal::sim::WorldOptions{}.mount, .colour = true};
    }
    void doClose() override {}
    hal::FrameStatus doWaitFrame(hal::Duration, hal::DepthFrame& frame, hal::Interrupt& interrupt) override {
        const std::vector<Recorded>& visit = recordedVisit();
        if (next_ == visit.size()) return hal::FrameStatus::ended;
        const Recorded& recorded = visit[next_++];
        frame = recorded.frame;
        frame.depth = recorded.depth.view();
        frame.colour = recorded.colour.view();
        clock_.waitUntil(frame.captureTime, interrupt);
        return hal::FrameStatus::frame;
    }

  private:
    hal::Clock& clock_;
    std::size_t next_ = 0;
};

double residentMegabytes() {
    std::ifstream statm("/proc/self/statm");
    long total = 0;
    long resident = 0;
    statm >> total >> resident;
    return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// Milliseconds, sorted once for both quantiles.
class Readings {
  public:
    void add(hal::Duration duration) { values_.push_back(hal::seconds(duration) * 1e3); }
    [[nodiscard]] double quantile(double share) {
        if (values_.empty()) return 0.0;
        std::sort(values_.begin(), values_.end());
        const auto rank = static_cast<std::size_t>(std::lround(share * static_cast<double>(values_.size() - 1)));
        return values_[rank];
    }

  private:
    std::vector<double> values_;
};

/// Per task the scheduler's own figures (mean, and p99 to six per cent); the whole loop and the renderer exactly, over
/// the frames in which the shopper is dressed.
void frame(benchmark::State& state, bool avatar) {
    config::Settings settings = config::defaultSettings();
    settings.wardrobe.folder = CHEVAL_ASSETS;
    settings.render.view = avatar ? config::StartView::avatar : config::StartView::mirror;
    const daemon::Wardrobe wardrobe = daemon::loadWardrobe(daemon::wardrobeOptions(settings));
    recordedVisit();
    Readings loop;
    Readings render;
    std::uint64_t loopAllocations = 0;
    std::uint64_t pictureAllocations = 0;
    std::uint64_t pictureNews = 0;
    std::uint64_t steadyFrames = 0;
    std::uint64_t dressed = 0;
    std::vector<daemon::TaskStatistics> tasks;
    for ([[maybe_unused]] auto _ : state) {
        hal::VirtualClock clock;
        const hal::VirtualClock still;
        const hal::SteadyClock cost;
        const std::unique_ptr<hal::Display> display = hal::makeHeadlessDisplay({.mode = daemon::displayMode(settings)});
        if (!display->open()) {
            state.SkipWithError("no display");
            return;
        }
        Expected<std::unique_ptr<daemon::Mirror>> made = daemon::Mirror::create(
            settings, {.camera = [&clock]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
                           return std::unique_ptr<hal::DepthCamera>(std::make_unique<VisitCamera>(clock));
                       },
                       .display = display.get(),
                       .mode = daemon::displayMode(settings),
                       .clock = &clock,
                       .admission = &still,
                       .cost = &cost,
                       .wardrobe = &wardrobe,
                       .runToTheEnd = true});
        if (!made) {
            state.SkipWithError(made.error().message().c_str());
            return;
        }
        daemon::Mirror& mirror = **made;
        // Each frame is taken twice through the counter: the loop alone, then the loop and its picture.
        bool drawNow = true;
        const std::function<bool(const hal::DepthFrame&)> draw = [&drawNow](const hal::DepthFrame&) { return drawNow; };
        for (std::size_t i = 0; i < recordedVisit().size(); ++i) {
            drawNow = i % 2 == 0;
            const bool steady = mirror.status().state == daemon::SessionState::wearing;
            const cheval::test::AllocationCounter counter;
            const Expected<daemon::StepResult> step = mirror.step(draw);
            const std::uint64_t taken = counter.count();
            const std::uint64_t takenByNew = counter.countNew();
            if (!step) {
                state.SkipWithError(step.error().message().c_str());
                return;
            }
            if (!steady) continue;
            const daemon::MirrorStatus status = mirror.status();
            ++steadyFrames;
            ++dressed;
            loop.add(status.loopTime);
            if (drawNow) {
                render.add(status.renderTime);
                pictureAllocations += taken;
                pictureNews += takenByNew;
            } else {
                loopAllocations += taken;
            }
        }
        tasks = mirror.statistics();
        state.SetLabel(mirror.rendererDescription());
    }
    for (const daemon::TaskStatistics& row : tasks) {
        if (row.name.ends_with("whole frame") || row.runs == 0) continue;
        std::string name(row.name);
        std::replace(name.begin(), name.end(), ' ', '_');
        state.counters[name + "_mean_ms"] = hal::seconds(row.mean) * 1e3;
        state.counters[name + "_p99_ms"] = hal::seconds(row.p99) * 1e3;
    }
    state.counters["loop_median_ms"] = loop.quantile(0.5);
    state.counters["loop_p99_ms"] = loop.quantile(0.99);
    state.counters["render_median_ms"] = render.quantile(0.5);
    state.counters["render_p99_ms"] = render.quantile(0.99);
    state.counters["frames_dressed"] = static_cast<double>(dressed);
    const double half = std::max(1.0, static_cast<double>(steadyFrames) / 2.0);
    state.counters["loop_allocations_per_frame"] = static_cast<double>(loopAllocations) / half;
    // Most of ours are calls of operator new; most of the rest is the GL driver's.
    state.counters["picture_allocations_per_frame"] = static_cast<double>(pictureAllocations) / half;
    state.counters["picture_allocations_by_new_per_frame"] = static_cast<double>(pictureNews) / half;
    // The pre-rendered frames are the benchmark's own.
    double recording = 0.0;
    for (const Recorded& recorded : recordedVisit()) {
        recording += static_cast<double>(recorded.depth.pixels.size() * sizeof(std::uint16_t) +
                                         recorded.colour.pixels.size() * sizeof(hal::Rgb8)) /
                     1e6;
    }
    state.counters["resident_mb"] = residentMegabytes() - recording;
}

void mirrorView(benchmark::State& state) {
    frame(state, false);
}
void avatarView(benchmark::State& state) {
    frame(state, true);
}

BENCHMARK(mirrorView)->Unit(benchmark::kMillisecond)->Iterations(1)->Name("frame/mirror/tshirt/1080x1920");
BENCHMARK(avatarView)->Unit(benchmark::kMillisecond)->Iterations(1)->Name("frame/avatar/tshirt/1080x1920");

}  // namespace

BENCHMARK_MAIN();

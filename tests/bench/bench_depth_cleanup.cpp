// D10, the source's clean-up beside the one that keeps edges, and OpenCV's filters beside both: milliseconds a frame,
// and how far from the truth the shopper's surface is. Counters in millimetres RMS and per cent:
//   inner      where no edge of depth or outline is within three pixels,
//   edge       where there is one,
//   holes      pixels of the shopper without a reading: how many are given a value within 30 mm (filled_right), another
//              (filled_wrong), or none,
//   invented   values where the shopper is not, in per cent of the shopper's area.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "fitting/tracking/depth_cleanup.h"
#include "tests/bench/tracking_frames.h"

namespace {

using namespace cheval;
using fitting::tracking::DepthCleanupJob;
using fitting::tracking::SurfaceCleanupJob;

constexpr std::uint8_t kLabel = 1;
constexpr std::uint8_t kShopper = 1;  ///< As owner: the first figure.
constexpr int kEdgeReach = 3;
constexpr int kEdgeStep = 50;  ///< Millimetres between neighbours of two surfaces.
constexpr int kRight = 30;     ///< A filled pixel this near to the truth is right.

/// A frame, the shopper's pixels that have a reading, and which of the shopper's are near an edge.
struct Case {
    bench::TrackingFrame frame;
    hal::Image<std::uint8_t> map;
    hal::Image<std::uint8_t> edge;
};

bool nearEdge(const bench::TrackingFrame& frame, int x, int y) {
    const int here = frame.exact.view().at(x, y);
    for (int v = std::max(0, y - kEdgeReach); v <= std::min(frame.exact.height - 1, y + kEdgeReach); ++v) {
        for (int u = std::max(0, x - kEdgeReach); u <= std::min(frame.exact.width - 1, x + kEdgeReach); ++u) {
            const int apart = std::max(std::abs(u - x), std::abs(v - y));
            if (std::abs(frame.exact.view().at(u, v) - here) > kEdgeStep * std::max(1, apart)) return true;
        }
    }
    return false;
}

/// Four shoppers, half a second apart through their visits, nearer and further, dark clothes and hair among them.
const std::vector<Case>& cases() {
    static const std::vector<Case> kCases = [] {
        std::vector<Case> all;
        for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
            std::vector<bench::TrackingFrame> visit =
                bench::simulatedVisit({.seed = seed, .first = 75, .count = 32, .step = 15, .exact = true});
            for (bench::TrackingFrame& frame : visit) {
                if (!frame.skeleton.present()) continue;
                Case one;
                one.map.resize(frame.depth.width, frame.depth.height);
                one.edge.resize(frame.depth.width, frame.depth.height);
                for (int y = 0; y < frame.depth.height; ++y) {
                    for (int x = 0; x < frame.depth.width; ++x) {
                        if (frame.owner.view().at(x, y) != kShopper) continue;
                        one.map.view().at(x, y) = frame.depth.view().at(x, y) != 0 ? kLabel : 0;
                        one.edge.view().at(x, y) = nearEdge(frame, x, y) ? 1 : 0;
                    }
                }
                one.frame = std::move(frame);
                all.push_back(std::move(one));
            }
        }
        return all;
    }();
    return kCases;
}

struct Scores {
    double inner = 0, edge = 0, holeError = 0;
    long innerCount = 0, edgeCount = 0, holes = 0, right = 0, wrong = 0, invented = 0, person = 0;

    void add(const Case& one, const hal::Image<std::uint16_t>& cleaned) {
        for (std::size_t i = 0; i < cleaned.pixels.size(); ++i) {
            const int value = cleaned.pixels[i];
            if (one.frame.owner.pixels[i] != kShopper) {
                invented += value != 0 ? 1 : 0;
                continue;
            }
            ++person;
            const double error = value - static_cast<int>(one.frame.exact.pixels[i]);
            if (one.map.pixels[i] == 0) {
                ++holes;
                if (value == 0) continue;
                (std::abs(error) <= kRight ? right : wrong) += 1;
                holeError += error * error;
            } else if (value != 0) {
                const bool rim = one.edge.pixels[i] != 0;
                (rim ? edge : inner) += error * error;
                (rim ? edgeCount : innerCount) += 1;
            }
        }
    }
    void report(benchmark::State& state) const {
        const auto rms = [](double sum, long count) {
            return std::sqrt(sum / static_cast<double>(std::max(count, 1L)));
        };
        const auto share = [](long part, long whole) {
            return 100.0 * static_cast<double>(part) / static_cast<double>(std::max(whole, 1L));
        };
        state.counters["inner_mm"] = rms(inner, innerCount);
        state.counters["edge_mm"] = rms(edge, edgeCount);
        state.counters["holes_%"] = share(holes, person);
        state.counters["filled_right_%"] = share(right, holes);
        state.counters["filled_wrong_%"] = share(wrong, holes);
        state.counters["filled_mm"] = rms(holeError, right + wrong);
        state.counters["invented_%"] = share(invented, person);
    }
};

/// One frame an iteration; the scores are of all frames.
template <typename Clean>
void cleanUp(benchmark::State& state, const Clean& clean) {
    const std::vector<Case>& all = cases();
    hal::Image<std::uint16_t> cleaned(640, 480);
    std::vector<float> scratch(cleaned.pixels.size());
    std::size_t next = 0;
    for ([[maybe_unused]] auto each : state) {
        clean(all[next], cleaned, scratch);
        benchmark::ClobberMemory();
        next = (next + 1) % all.size();
    }
    Scores scores;
    for (const Case& one : all) {
        clean(one, cleaned, scratch);
        scores.add(one, cleaned);
    }
    scores.report(state);
}

void asItCame(benchmark::State& state) {
    cleanUp(state, [](const Case& one, hal::Image<std::uint16_t>& cleaned, std::vector<float>&) {
        for (std::size_t i = 0; i < cleaned.pixels.size(); ++i)
            cleaned.pixels[i] = one.map.pixels[i] != 0 ? one.frame.depth.pixels[i] : std::uint16_t{0};
    });
}

void fillAndGaussian(benchmark::State& state) {
    cleanUp(state, [](const Case& one, hal::Image<std::uint16_t>& cleaned, std::vector<float>& scratch) {
        DepthCleanupJob job{.depth = one.frame.depth.view(),
                            .userMap = one.map.view(),
                            .label = kLabel,
                            .scratch = scratch,
                            .cleaned = cleaned.view()};
        if (job.isValid()) job.run();
    });
}

void surface(benchmark::State& state) {
    cleanUp(state, [&state](const Case& one, hal::Image<std::uint16_t>& cleaned, std::vector<float>& scratch) {
        SurfaceCleanupJob job{.depth = one.frame.depth.view(),
                              .userMap = one.map.view(),
                              .label = kLabel,
                              .widestHole = static_cast<int>(state.range(0)),
                              .scratch = scratch,
                              .cleaned = cleaned.view()};
        if (job.isValid()) job.run();
    });
}

/// The shopper's readings as OpenCV's filters take them, elsewhere `fill`.
cv::Mat readings(const Case& one, float fill) {
    cv::Mat picture(one.map.height, one.map.width, CV_32F);
    for (std::size_t i = 0; i < one.map.pixels.size(); ++i)
        picture.ptr<float>()[i] = one.map.pixels[i] != 0 ? static_cast<float>(one.frame.depth.pixels[i]) : fill;
    return picture;
}

void store(const cv::Mat& picture, const Case& one, hal::Image<std::uint16_t>& cleaned) {
    for (std::size_t i = 0; i < cleaned.pixels.size(); ++i) {
        cleaned.pixels[i] = one.map.pixels[i] != 0 ? static_cast<std::uint16_t>(std::lround(picture.ptr<float>()[i]))
                                                   : std::uint16_t{0};
    }
}

void openCvBilateral(benchmark::State& state) {
    cv::setNumThreads(1);
    cleanUp(state, [](const Case& one, hal::Image<std::uint16_t>& cleaned, std::vector<float>&) {
        cv::Mat smooth;
        cv::bilateralFilter(readings(one, 0.0F), smooth, 7, 25.0, 1.6, cv::BORDER_REFLECT_101);
        store(smooth, one, cleaned);
    });
}

void openCvMedian(benchmark::State& state) {
    cv::setNumThreads(1);
    cleanUp(state, [](const Case& one, hal::Image<std::uint16_t>& cleaned, std::vector<float>&) {
        cv::Mat smooth;
        cv::medianBlur(readings(one, 0.0F), smooth, 5);
        store(smooth, one, cleaned);
    });
}

BENCHMARK(asItCame)->Unit(benchmark::kMillisecond)->Name("depth_cleanup/none");
BENCHMARK(fillAndGaussian)->Unit(benchmark::kMillisecond)->Name("depth_cleanup/fill_and_gaussian");
BENCHMARK(surface)->Unit(benchmark::kMillisecond)->Arg(0)->Arg(8)->Arg(16)->Arg(32)->Name("depth_cleanup/surface");
BENCHMARK(openCvBilateral)->Unit(benchmark::kMillisecond)->Name("depth_cleanup/opencv_bilateral");
BENCHMARK(openCvMedian)->Unit(benchmark::kMillisecond)->Name("depth_cleanup/opencv_median");

}  // namespace

BENCHMARK_MAIN();

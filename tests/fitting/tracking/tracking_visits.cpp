// Judges the tracker by seeded visits of the simulated kiosk, whose people, clothes and sensor are not of its making.
//
//     tracking_visits [--visits N] [--only SCRIPT] [--seed N] [--threads N] [--json FILE] [--misses] [--details]
//
// Prints what the goals ask for, with Wilson's 95 % bounds for rates. The same arguments give the same figures on any
// number of threads. A report: the exit status tells only whether it could be made.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "daemon/guarded_main.h"
#include "tests/fitting/tracking/visit_figures.h"
#include "tests/fitting/tracking/visit_recording.h"
#include "tests/fitting/tracking/visit_report.h"

namespace cheval::fitting::test {
namespace {

using hal::sim::Script;

/// How often each script is played in a whole run and how long its visit is.
struct Share {
    Script script;
    int visits;
    double seconds;
};
/// All but Script::measuring, which judges the body's measurement: body_visits.
constexpr std::array<Share, hal::sim::kScriptCount - 1> kShares = {{{Script::visit, 12, 16.0},
                                                                    {Script::resting, 32, 7.6},
                                                                    {Script::pacing, 24, 9.0},
                                                                    {Script::gestures, 36, 18.0},
                                                                    {Script::fidgeting, 32, 20.0},
                                                                    {Script::passersBy, 34, 16.0},
                                                                    {Script::occlusion, 30, 9.0},
                                                                    {Script::mannequin, 12, 9.0},
                                                                    {Script::dog, 12, 7.5}}};
constexpr int kWholeRun = 224;

struct Arguments {
    int visits = kWholeRun;
    std::string only, json;
    std::uint32_t seed = 1000;  ///< Of the first visit of each script.
    unsigned threads = 2;
    bool misses = false, details = false;
};

[[noreturn]] void usage(const char* complaint) {
    std::fprintf(stderr,
                 "tracking_visits: %s\nusage: tracking_visits [--visits N] [--only SCRIPT] [--seed N] [--threads N] "
                 "[--json FILE] [--misses] [--details]\nscripts:",
                 complaint);
    for (const Share& share : kShares)
        std::fprintf(stderr, " %s", nameOf(share.script));
    std::fprintf(stderr, "\n");
    std::exit(2);
}

Arguments argumentsOf(int count, char** words) {
    Arguments arguments;
    for (int i = 1; i < count; ++i) {
        const std::string word = words[i];
        const auto value = [&]() -> const char* {
            if (i + 1 >= count) usage((word + " needs a value").c_str());
            return words[++i];
        };
        if (word == "--visits") {
            arguments.visits = std::max(1, std::atoi(value()));
        } else if (word == "--only") {
            arguments.only = value();
        } else if (word == "--seed") {
            arguments.seed = static_cast<std::uint32_t>(std::atoi(value()));
        } else if (word == "--threads") {
            arguments.threads = static_cast<unsigned>(std::clamp(std::atoi(value()), 1, 64));
        } else if (word == "--json") {
            arguments.json = value();
        } else if (word == "--misses") {
            arguments.misses = true;
        } else if (word == "--details") {
            arguments.details = true;
        } else {
            usage(("unknown argument " + word).c_str());
        }
    }
    const auto known = [&](const Share& share) { return arguments.only == nameOf(share.script); };
    if (!arguments.only.empty() && std::none_of(kShares.begin(), kShares.end(), known))
        usage(("no script is called " + arguments.only).c_str());
    return arguments;
}

struct Task {
    Script script;
    std::uint32_t seed;
    double seconds;
};

/// All visits in their shares, or those of one script alone.
std::vector<Task> tasksOf(const Arguments& arguments) {
    std::vector<Task> tasks;
    for (const Share& share : kShares) {
        if (!arguments.only.empty() && arguments.only != nameOf(share.script)) continue;
        const int visits = std::max(
            1, static_cast<int>(std::lround(static_cast<double>(share.visits) * arguments.visits / kWholeRun)));
        // No two visits of a whole run share a shop.
        const std::uint32_t first = arguments.seed + 1000 * static_cast<std::uint32_t>(share.script);
        for (int i = 0; i < visits; ++i)
            tasks.push_back({share.script, first + static_cast<std::uint32_t>(i), share.seconds});
    }
    return tasks;
}

VisitFigures runAll(const std::vector<Task>& tasks, unsigned threads) {
    std::vector<VisitFigures> results(tasks.size());
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t i = next++; i < tasks.size(); i = next++)
            results[i] = figuresOf(recordVisit(tasks[i].script, tasks[i].seed, tasks[i].seconds));
    };
    {
        std::vector<std::jthread> workers;
        for (unsigned i = 1; i < threads; ++i)
            workers.emplace_back(work);
        work();
    }
    VisitFigures sum;
    for (const VisitFigures& result : results)
        sum.add(result);
    return sum;
}

int run(int count, char** words) {
    const Arguments arguments = argumentsOf(count, words);
    const std::vector<Task> tasks = tasksOf(arguments);
    const auto began = std::chrono::steady_clock::now();
    const VisitFigures figures = runAll(tasks, arguments.threads);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    double played = 0.0;
    for (const Task& task : tasks)
        played += task.seconds;

    const std::vector<ReportRow> rows = reportRows(figures);
    printReport(rows, stdout);
    if (arguments.details) printDetails(figures, stdout);
    if (arguments.misses) {
        std::printf("\n%zu misses\n", figures.misses.size());
        for (const std::string& miss : figures.misses)
            std::printf("%s\n", miss.c_str());
    }
    std::printf("\n%zu visits, %.0f s of them at %.0f frames a second, took %.0f s on %u threads\n", tasks.size(),
                played, kVisitFramesPerSecond, took, arguments.threads);
    if (arguments.json.empty()) return 0;
    std::FILE* file = std::fopen(arguments.json.c_str(), "w");
    const std::string json = jsonOf(rows);
    if (file == nullptr || std::fputs(json.c_str(), file) < 0 || std::fclose(file) != 0) {
        std::fprintf(stderr, "tracking_visits: cannot write %s: %s\n", arguments.json.c_str(), std::strerror(errno));
        return 1;
    }
    return 0;
}

}  // namespace
}  // namespace cheval::fitting::test

int main(int count, char** words) {
    return cheval::daemon::guardedMain(cheval::fitting::test::run, count, words, 1);
}

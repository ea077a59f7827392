// Judges the measurement of the body by seeded visits of the simulated kiosk, whose people are lofts of its own and no
// shapes of the model that is fitted to them.
//
//     body_visits [--visits N] [--seed N] [--threads N] [--clothing KIND] [--noise X] [--everybody] [--until SECONDS]
//                 [--sure] [--body FILE] [--json FILE]
//
// KIND: bare, tight, ordinary, loose or wide. --until ends each visit after so many seconds of facing the glass.
// --sure counts only what was told without a doubt. The same arguments give the same figures on any number of threads.
// A report: the exit status tells only whether it could be made.
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "daemon/guarded_main.h"
#include "tests/fitting/body/measured_figures.h"
#include "tests/fitting/body/measured_visit.h"

namespace cheval::fitting::test {
namespace {

using hal::sim::Clothing;

constexpr std::array<Clothing, 5> kClothing = {Clothing::bare, Clothing::tight, Clothing::ordinary, Clothing::loose,
                                               Clothing::wide};

struct Arguments {
    int visits = 200;
    unsigned threads = 2;
    MeasuredOptions options{.seed = 50'000};
    bool sure = false;
    std::string body = CHEVAL_ASSETS "/body.glb";
    std::string json;
};

[[noreturn]] void usage(const std::string& complaint) {
    std::fprintf(stderr,
                 "body_visits: %s\nusage: body_visits [--visits N] [--seed N] [--threads N] [--clothing KIND] "
                 "[--noise X] [--everybody] [--until SECONDS] [--sure] [--body FILE] [--json FILE]\nkinds:",
                 complaint.c_str());
    for (const Clothing kind : kClothing)
        std::fprintf(stderr, " %s", nameOf(kind));
    std::fprintf(stderr, "\n");
    std::exit(2);
}

Clothing clothingOf(const std::string& word) {
    const auto* kind =
        std::find_if(kClothing.begin(), kClothing.end(), [&](Clothing one) { return word == nameOf(one); });
    if (kind == kClothing.end()) usage("no kind of clothes is called " + word);
    return *kind;
}

Arguments argumentsOf(int count, char** words) {
    Arguments arguments;
    for (int i = 1; i < count; ++i) {
        const std::string word = words[i];
        const auto value = [&]() -> const char* {
            if (i + 1 >= count) usage(word + " needs a value");
            return words[++i];
        };
        if (word == "--visits") {
            arguments.visits = std::max(1, std::atoi(value()));
        } else if (word == "--seed") {
            arguments.options.seed = static_cast<std::uint32_t>(std::atoi(value()));
        } else if (word == "--threads") {
            arguments.threads = static_cast<unsigned>(std::clamp(std::atoi(value()), 1, 64));
        } else if (word == "--clothing") {
            arguments.options.clothing = clothingOf(value());
        } else if (word == "--noise") {
            arguments.options.noiseScale = static_cast<float>(std::atof(value()));
        } else if (word == "--everybody") {
            arguments.options.everybody = true;
        } else if (word == "--until") {
            arguments.options.facingSeconds = std::atof(value());
        } else if (word == "--sure") {
            arguments.sure = true;
        } else if (word == "--body") {
            arguments.body = value();
        } else if (word == "--json") {
            arguments.json = value();
        } else {
            usage("unknown argument " + word);
        }
    }
    return arguments;
}

std::vector<MeasuredVisit> runAll(const Arguments& arguments, const Body& body) {
    std::vector<MeasuredVisit> visits(static_cast<std::size_t>(arguments.visits));
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t i = next++; i < visits.size(); i = next++) {
            MeasuredOptions options = arguments.options;
            options.seed += static_cast<std::uint32_t>(i);
            visits[i] = measureVisit(body, options);
        }
    };
    std::vector<std::jthread> workers;
    for (unsigned i = 1; i < arguments.threads; ++i)
        workers.emplace_back(work);
    work();
    workers.clear();
    return visits;
}

int run(int count, char** words) {
    const Arguments arguments = argumentsOf(count, words);
    const auto body = loadBody(arguments.body);
    if (!body) {
        std::fprintf(stderr, "body_visits: %s\n", body.error().message().c_str());
        return 1;
    }
    const auto began = std::chrono::steady_clock::now();
    const std::vector<MeasuredVisit> visits = runAll(arguments, *body);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    std::printf("%zu visits in %s clothes, seeds from %u, noise %.2f, took %.0f s on %u threads\n\n%s", visits.size(),
                nameOf(arguments.options.clothing), arguments.options.seed,
                static_cast<double>(arguments.options.noiseScale), took, arguments.threads,
                tableOf(figuresOf(visits, arguments.sure)).c_str());
    if (arguments.json.empty()) return 0;
    std::FILE* file = std::fopen(arguments.json.c_str(), "w");
    const std::string json = jsonOf(visits);
    if (file == nullptr || std::fputs(json.c_str(), file) < 0 || std::fclose(file) != 0) {
        std::fprintf(stderr, "body_visits: cannot write %s: %s\n", arguments.json.c_str(), std::strerror(errno));
        return 1;
    }
    return 0;
}

}  // namespace
}  // namespace cheval::fitting::test

int main(int count, char** words) {
    return cheval::daemon::guardedMain(cheval::fitting::test::run, count, words, 1);
}

// A simulated shop day: visit after visit on virtual time. Tells the resident memory after the first minute and at the
// end and fails when it grew: a mirror runs for months.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

#include <unistd.h>

#include "config/settings_table.h"
#include "daemon/devices.h"
#include "daemon/mirror.h"
#include "daemon/room_options.h"

namespace {

using namespace cheval;

/// Growth that may be the allocator's or the driver's own, in megabytes.
constexpr double kAllowedGrowth = 8.0;
constexpr double kAllowedResident = 300.0;

double residentMegabytes() {
    std::ifstream statm("/proc/self/statm");
    long total = 0;
    long resident = 0;
    statm >> total >> resident;
    return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

int fail(const Error& error) {
    std::fprintf(stderr, "error: %s\n", error.message().c_str());
    return 1;
}

/// Draws every `every`-th picture: software GL is most of the time, and what leaks in it leaks in a tenth as well.
int soak(double minutes, std::uint64_t every) {
    config::Settings settings = config::defaultSettings();
    settings.wardrobe.folder = CHEVAL_ASSETS;
    const daemon::Wardrobe wardrobe = daemon::loadWardrobe(daemon::wardrobeOptions(settings));
    hal::VirtualClock clock;
    const hal::VirtualClock still;
    const hal::SteadyClock cost;
    Expected<std::unique_ptr<daemon::Screen>> screen = daemon::Screen::open(settings, clock);
    if (!screen) return fail(screen.error());
    daemon::FrameSource source = daemon::makeFrameSource(settings, clock);
    Expected<std::unique_ptr<daemon::Mirror>> mirror =
        daemon::Mirror::create(settings, {.camera = source.camera,
                                          .buttons = {source.buttons.get()},
                                          .display = &(*screen)->display(),
                                          .mode = (*screen)->mode(),
                                          .clock = &clock,
                                          .admission = &still,
                                          .cost = &cost,
                                          .wardrobe = &wardrobe,
                                          .runToTheEnd = true});
    if (!mirror) return fail(mirror.error());
    const auto draw = [every](const hal::DepthFrame& frame) { return frame.sequence % every == 0; };
    double first = 0.0;
    int told = 0;
    while (hal::seconds(clock.now()) < minutes * 60.0) {
        const Expected<daemon::StepResult> step = (*mirror)->step(draw);
        if (!step) return fail(step.error());
        const double now = hal::seconds(clock.now());
        if (first == 0.0 && now >= 60.0) first = residentMegabytes();
        if (now >= 300.0 * (told + 1)) {
            ++told;
            std::printf("%5.0f min: %.1f MB resident, %llu visits\n", now / 60.0, residentMegabytes(),
                        static_cast<unsigned long long>((*mirror)->status().visits));
            std::fflush(stdout);
        }
    }
    const double last = residentMegabytes();
    const daemon::MirrorStatus status = (*mirror)->status();
    std::printf("simulated minutes %.0f, frames %llu, pictures %llu, visits %llu\n", minutes,
                static_cast<unsigned long long>(status.frames), static_cast<unsigned long long>(status.pictures),
                static_cast<unsigned long long>(status.visits));
    std::printf("resident after the first minute %.1f MB, at the end %.1f MB, growth %.1f MB (allowed %.1f)\n", first,
                last, last - first, kAllowedGrowth);
    const bool good = last - first <= kAllowedGrowth && last <= kAllowedResident && status.visits > 0;
    std::printf("%s\n", good ? "passed" : "FAILED");
    return good ? 0 : 1;
}

}  // namespace

/// soak_visits [SIMULATED_MINUTES [EVERY]]: 60 minutes, every tenth picture drawn, if nothing is said.
int main(int argc, char** argv) {
    const double minutes = argc > 1 ? std::strtod(argv[1], nullptr) : 60.0;
    const long every = argc > 2 ? std::strtol(argv[2], nullptr, 10) : 10;
    if (!(minutes > 1.0) || every < 1) {
        std::fprintf(stderr,
                     "usage: soak_visits [SIMULATED_MINUTES [EVERY]], more than 1 minute and every at least 1\n");
        return 2;
    }
    return soak(minutes, static_cast<std::uint64_t>(every));
}

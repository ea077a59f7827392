// A visit through the whole real way, with a sensor that fails again and again: killed, stalled, unplugged. Tells how
// long the mirror took to dress the shopper again from the moment that frames could flow, and whether it stayed lit.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/settings_table.h"
#include "daemon/mirror.h"
#include "daemon/room_options.h"
#include "hal/headless/headless_display.h"
#include "hal/sensor_process/process_camera.h"
#include "tests/support/sensor_world.h"

namespace {

using namespace cheval;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr double kGoalSeconds = 2.0;  ///< Dressed again, from when frames can flow.
constexpr double kDarkSeconds = 1.0;  ///< Longer between two pictures, and the mirror was not lit.
constexpr int kDarkestPicture = 8;    ///< Mean brightness of a picture that shows something.
constexpr hal::Duration kGiveUp = seconds(60);

enum class Fault { kill, stall, unplug };
constexpr std::array<Fault, 3> kFaults = {Fault::kill, Fault::stall, Fault::unplug};

const char* nameOf(Fault fault) {
    switch (fault) {
        case Fault::kill:
            return "kill -9";
        case Fault::stall:
            return "stall";
        case Fault::unplug:
            return "unplug";
    }
    return "";
}

/// What the renderer's thread saw. Thread-safe.
class Witness {
  public:
    explicit Witness(const hal::Clock& clock) : clock_(clock) {}

    void see(const daemon::FramePacket& packet, hal::ImageView<const hal::Rgba8> picture) {
        const hal::TimePoint now = clock_.now();
        const std::lock_guard lock(mutex_);
        if (pictures_ > 0) longestGap_ = std::max(longestGap_, hal::seconds(now - last_));
        last_ = now;
        ++pictures_;
        if (packet.hud.screen == render::Screen::service) ++servicePictures_;
        darkest_ = std::min(darkest_, brightness(picture));
        dressedNow_ = packet.dressed;
        if (packet.dressed && packet.captureTime >= asked_ && answered_ == hal::TimePoint{}) answered_ = now;
    }
    /// From now on: when was the first dressed picture of a frame that was captured after `since`?
    void ask(hal::TimePoint since) {
        const std::lock_guard lock(mutex_);
        asked_ = since;
        answered_ = {};
    }
    [[nodiscard]] hal::TimePoint answered() const {
        const std::lock_guard lock(mutex_);
        return answered_;
    }
    /// In the last picture.
    [[nodiscard]] bool dressedNow() const {
        const std::lock_guard lock(mutex_);
        return dressedNow_;
    }
    [[nodiscard]] double longestGap() const {
        const std::lock_guard lock(mutex_);
        return longestGap_;
    }
    [[nodiscard]] int darkest() const {
        const std::lock_guard lock(mutex_);
        return darkest_;
    }
    [[nodiscard]] std::uint64_t servicePictures() const {
        const std::lock_guard lock(mutex_);
        return servicePictures_;
    }

  private:
    static int brightness(hal::ImageView<const hal::Rgba8> picture) {
        long sum = 0;
        long count = 0;
        for (int y = 0; y < picture.height; y += 16) {
            for (int x = 0; x < picture.width; x += 16, ++count)
                sum += picture.at(x, y).g;
        }
        return static_cast<int>(sum / std::max(1L, count));
    }

    const hal::Clock& clock_;
    mutable std::mutex mutex_;
    hal::TimePoint last_{};
    hal::TimePoint asked_{};
    hal::TimePoint answered_{};
    bool dressedNow_ = false;
    std::uint64_t pictures_ = 0;
    std::uint64_t servicePictures_ = 0;
    double longestGap_ = 0.0;
    int darkest_ = 255;
};

/// The sensor process of the camera that the mirror has at the moment.
class CurrentCamera {
  public:
    void set(hal::ProcessCamera* camera) { camera_.store(camera); }
    [[nodiscard]] pid_t process() const {
        const hal::ProcessCamera* camera = camera_.load();
        return camera == nullptr ? -1 : camera->process();
    }

  private:
    std::atomic<hal::ProcessCamera*> camera_{nullptr};
};

/// True when `done` came true in time.
bool waitFor(hal::Clock& clock, hal::Duration limit, const auto& done) {
    hal::Interrupt never;
    const hal::TimePoint end = clock.now() + limit;
    while (!done()) {
        if (clock.now() >= end) return false;
        clock.waitUntil(clock.now() + milliseconds(5), never);
    }
    return true;
}

/// After faults of one kind.
struct Recoveries {
    std::vector<double> dressedAgain;  ///< Seconds.
    int never = 0;
};

struct Outcome {
    std::array<Recoveries, kFaults.size()> after;  ///< By Fault.
    double longestGap = 0.0;
    int darkest = 255;
    std::uint64_t servicePictures = 0;
    std::array<std::uint64_t, daemon::kRecoveryRungCount> rungs{};
};

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

int fail(const Error& error) {
    std::fprintf(stderr, "error: %s\n", error.message().c_str());
    return EXIT_FAILURE;
}

/// Visits of this length follow each other; in this part of each the shopper stands before the glass, long enough for
/// the longest fault and for what comes after it. Seconds.
struct Visits {
    int length;
    double begun;  ///< How much of the first is over at the start.
    double faultsFrom, faultsTo;
};
constexpr Visits kManyVisits{.length = 40, .begun = 0.0, .faultsFrom = 7.0, .faultsTo = 24.0};
/// One that three faults fit into: to wait for the next would take longer than all of them.
constexpr Visits kOneLongVisit{.length = 80, .begun = 10.0, .faultsFrom = 14.0, .faultsTo = 48.0};

/// `rounds` of these faults, one after another, each while a shopper is dressed.
Expected<Outcome> outcomeOf(std::span<const Fault> faults, int rounds, const Visits& visits, unsigned seed) {
    const hal::TimePoint zero = hal::SteadyClock().now() - hal::fromSeconds(visits.begun);
    test::SensorWorld world(test::SensorWorld::visitInProgress(
        "seed=4,noise=1,pause_s=0,visit_s=" + std::to_string(visits.length), visits.begun));
    config::Settings settings = config::defaultSettings();
    settings.sensor.source = config::SensorSource::openni;
    settings.wardrobe.folder = CHEVAL_ASSETS;
    settings.display.width = 540;
    settings.display.height = 960;
    const daemon::Wardrobe wardrobe = daemon::loadWardrobe(daemon::wardrobeOptions(settings));
    hal::SteadyClock clock;
    Witness witness(clock);
    CurrentCamera current;
    const auto display = hal::makeHeadlessDisplay({.mode = daemon::displayMode(settings)});
    if (auto opened = display->open(); !opened) return std::move(opened).error();
    hal::ProcessCameraOptions sensor = daemon::sensorProcessOptions(settings, {});
    sensor.program = CHEVAL_SENSOR;
    sensor.environment = world.environment();
    auto mirror = daemon::Mirror::create(
        settings, {.camera = [&]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
                       auto camera = hal::makeProcessCamera(sensor, clock);
                       current.set(camera.get());
                       return std::unique_ptr<hal::DepthCamera>(std::move(camera));
                   },
                   .display = display.get(),
                   .mode = daemon::displayMode(settings),
                   .clock = &clock,
                   .cost = &clock,
                   .wardrobe = &wardrobe,
                   .observer = [&](const daemon::FramePacket& packet,
                                   hal::ImageView<const hal::Rgba8> picture) { witness.see(packet, picture); }});
    if (!mirror) return std::move(mirror).error();
    if (auto started = (*mirror)->start(); !started) return std::move(started).error();
    witness.ask(clock.now());
    if (!waitFor(clock, kGiveUp, [&] { return witness.answered() != hal::TimePoint{}; }))
        return Error{.code = ErrorCode::timedOut, .cause = "nobody was dressed in the first minute"};

    Outcome outcome;
    std::mt19937 random(seed);
    const auto between = [&](int low, int high) {
        return milliseconds(low + static_cast<int>(random() % static_cast<unsigned>(high - low)));
    };
    hal::Interrupt never;
    for (std::size_t turn = 0; turn < static_cast<std::size_t>(rounds) * faults.size(); ++turn) {
        const Fault fault = faults[turn % faults.size()];
        Recoveries& after = outcome.after[static_cast<std::size_t>(fault)];
        clock.waitUntil(clock.now() + between(1000, 3000), never);
        const auto phase = [&] { return std::fmod(hal::seconds(clock.now() - zero), visits.length); };
        const auto dressedNow = [&] {
            return phase() > visits.faultsFrom && phase() < visits.faultsTo && witness.dressedNow();
        };
        if (!waitFor(clock, kGiveUp, dressedNow)) {
            ++after.never;
            continue;
        }
        if (fault == Fault::kill) {
            if (const pid_t process = current.process(); process > 0) ::kill(process, SIGKILL);
        } else {
            world.tell(fault == Fault::stall ? "stall" : "unplug");
            clock.waitUntil(clock.now() + between(100, 4000), never);
            world.tell(fault == Fault::stall ? "resume" : "plug");
        }
        const hal::TimePoint canFlow = clock.now();
        witness.ask(canFlow);
        if (waitFor(clock, kGiveUp, [&] { return witness.answered() != hal::TimePoint{}; })) {
            after.dressedAgain.push_back(hal::seconds(witness.answered() - canFlow));
        } else {
            ++after.never;
        }
    }
    outcome.longestGap = witness.longestGap();
    outcome.darkest = witness.darkest();
    outcome.servicePictures = witness.servicePictures();
    outcome.rungs = (*mirror)->status().recovery;
    (*mirror)->stop();
    mirror->reset();
    display->close();
    return outcome;
}

/// With `goal` the goal itself is held, which an idle machine meets; else that it happens at all.
bool judge(std::span<const Fault> faults, const Outcome& outcome, bool goal) {
    bool good = outcome.darkest >= kDarkestPicture && (!goal || outcome.longestGap <= kDarkSeconds);
    for (const Fault fault : faults) {
        const Recoveries& after = outcome.after[static_cast<std::size_t>(fault)];
        const std::vector<double>& again = after.dressedAgain;
        const auto late = std::count_if(again.begin(), again.end(), [](double took) { return took > kGoalSeconds; });
        std::printf("%-8s %7d %9.2f %9.2f %9.2f %9ld %9d %9.2f %9d\n", nameOf(fault),
                    static_cast<int>(again.size()) + after.never, quantile(again, 0.5), quantile(again, 0.95),
                    quantile(again, 1.0), static_cast<long>(late), after.never, outcome.longestGap, outcome.darkest);
        good = good && after.never == 0 && (!goal || late == 0);
    }
    std::printf("         rungs:");
    for (std::size_t rung = 0; rung < outcome.rungs.size(); ++rung) {
        const std::string_view rungName = daemon::name(static_cast<daemon::RecoveryRung>(rung));
        std::printf(" %.*s %llu", static_cast<int>(rungName.size()), rungName.data(),
                    static_cast<unsigned long long>(outcome.rungs[rung]));
    }
    std::printf("; service screen in %llu pictures\n", static_cast<unsigned long long>(outcome.servicePictures));
    std::fflush(stdout);
    return good;
}

void printHead() {
    std::printf("%-8s %7s %9s %9s %9s %9s %9s %9s %9s\n", "fault", "rounds", "p50 s", "p95 s", "max s", "over 2 s",
                "never", "gap s", "darkest");
}

int conclude(bool good) {
    std::printf("%s\n", good ? "passed" : "FAILED");
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}

/// Each kind by itself, over many visits, held to the goals.
int runLong(unsigned seed) {
    constexpr int kRounds = 100;
    bool good = true;
    printHead();
    for (const Fault& fault : kFaults) {
        const std::span<const Fault> one(&fault, 1);
        const Expected<Outcome> outcome = outcomeOf(one, kRounds, kManyVisits, seed);
        if (!outcome) return fail(outcome.error());
        good = judge(one, *outcome, true) && good;
    }
    return conclude(good);
}

/// All kinds in turn, in one visit where they fit.
int runShort(int rounds, unsigned seed) {
    printHead();
    const Expected<Outcome> outcome = outcomeOf(kFaults, rounds, kOneLongVisit, seed);
    if (!outcome) return fail(outcome.error());
    return conclude(judge(kFaults, *outcome, false));
}

}  // namespace

/// soak_sensor_faults [ROUNDS [SEED]]: 100 of each fault, held to the goals, if nothing is said; with ROUNDS, so many
/// of each in turn, and only that the shopper is dressed again each time and the mirror never dark.
int main(int argc, char** argv) {
    const int rounds = argc > 1 ? std::atoi(argv[1]) : 0;
    const unsigned seed = argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1U;
    if (argc > 1 && rounds < 1) {
        std::fprintf(stderr, "usage: soak_sensor_faults [ROUNDS [SEED]], at least one round\n");
        return 2;
    }
    return argc > 1 ? runShort(rounds, seed) : runLong(seed);
}

// What `chevalctl status` says: for people, and as JSON for programs.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hal/clock.h"

namespace cheval::daemon {

/// A running mirror as its bus tells it; see mirror_interface.h. Plain values.
struct MirrorReport {
    struct Outfit {
        std::string id;
        std::string name;
    };
    struct Health {
        std::string part;
        std::string state;  ///< As name(HealthState).
        std::string reason;
        std::chrono::system_clock::time_point since;  ///< By the calendar as it stood then.
        hal::Duration age{};                          ///< By the steady clock: right even where the calendar was set.
    };
    struct Task {
        std::string name;
        hal::Duration budget{};
        hal::Duration minimum{};
        hal::Duration mean{};
        hal::Duration p99{};
        hal::Duration maximum{};
        std::uint64_t runs = 0;
        std::uint64_t overruns = 0;
        std::uint64_t skips = 0;
        bool wholeFrame = false;
    };
    std::string version;
    std::uint64_t uptimeSeconds = 0;
    std::string state;
    std::string outfit;  ///< Its id; empty: none.
    std::string view;
    std::vector<Outfit> outfits;
    double framesPerSecond = 0.0;
    std::uint32_t degradeLevel = 0;
    std::string degradeName;
    std::uint64_t visits = 0;
    std::uint64_t frames = 0;
    std::uint64_t pictures = 0;
    std::string renderer;
    std::string overall;
    std::vector<Health> health;
    std::vector<Task> tasks;
    std::vector<std::pair<std::string, std::uint64_t>> recovery;

    /// Some part is at fault.
    [[nodiscard]] bool atFault() const;
};

/// "just now", "12 s", "12 min", "3 h 5 min", "4 days": as long as people want to know it.
std::string ageInWords(hal::Duration age);

/// Aligned, with a line's end at the end; `colour` for a terminal that shows it (ECMA-48).
std::string statusForPeople(const MirrorReport& report, bool colour);

/// One JSON object, indented. Keys, which stay as they are once shipped:
///   version, uptime_s, state, outfit, view, outfits: [{id, name}], frames_per_second, degrade: {level, name}, visits,
///   frames, pictures, renderer, overall, health: [{part, state, reason, since (UTC, ISO 8601), for_s}],
///   tasks: [{name, budget_ms, min_ms, mean_ms, p99_ms, max_ms (null where runs is 0), runs, overruns, skips,
///   whole_frame}], recovery: {rung: count}
std::string statusAsJson(const MirrorReport& report);

}  // namespace cheval::daemon

#include "daemon/status_report.h"

#include <algorithm>
#include <ctime>
#include <iterator>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "daemon/health.h"

namespace cheval::daemon {

namespace {

double milliseconds(hal::Duration duration) {
    return hal::seconds(duration) * 1e3;
}

std::string_view colourOf(std::string_view state) {
    if (state == name(HealthState::ok)) return "\033[32m";
    if (state == name(HealthState::degraded)) return "\033[33m";
    if (state == name(HealthState::fault)) return "\033[1;31m";
    return "\033[2m";
}

/// Padded first and coloured then: escapes have no width.
std::string painted(std::string_view state, std::size_t width, bool colour) {
    std::string text = fmt::format("{:<{}}", state, width);
    return colour ? fmt::format("{}{}\033[0m", colourOf(state), text) : text;
}

std::string trimmed(std::string line) {
    line.erase(line.find_last_not_of(' ') + 1);
    return line + '\n';
}

std::string whatItDoes(const MirrorReport& report) {
    std::string text = report.state;
    const auto chosen = std::find_if(report.outfits.begin(), report.outfits.end(),
                                     [&](const MirrorReport::Outfit& outfit) { return outfit.id == report.outfit; });
    if (chosen != report.outfits.end()) text += fmt::format(", {} ({})", chosen->name, chosen->id);
    if (!report.view.empty()) text += report.view == "avatar" ? ", on the mannequin" : ", in the mirror";
    return text;
}

std::string isoTime(std::chrono::system_clock::time_point time) {
    const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                       parts.tm_hour, parts.tm_min, parts.tm_sec);
}

}  // namespace

bool MirrorReport::atFault() const {
    return overall == name(HealthState::fault);
}

std::string ageInWords(hal::Duration age) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(age).count();
    if (seconds < 2) return "just now";
    if (seconds < 120) return fmt::format("{} s", seconds);
    if (seconds < 7200) return fmt::format("{} min", seconds / 60);
    if (seconds < 172'800) return fmt::format("{} h {} min", seconds / 3600, seconds / 60 % 60);
    return fmt::format("{} days", seconds / 86'400);
}

std::string statusForPeople(const MirrorReport& report, bool colour) {
    std::string text;
    auto out = std::back_inserter(text);
    out = fmt::format_to(out, "Cheval {}, running for {}: {}\n", report.version,
                         ageInWords(std::chrono::seconds(report.uptimeSeconds)), painted(report.overall, 0, colour));
    out = fmt::format_to(out, "  {:<10}{}\n", "now", whatItDoes(report));
    out = fmt::format_to(out, "  {:<10}{:.1f} a second, {}\n", "pictures", report.framesPerSecond,
                         report.degradeLevel == 0 ? "all details" : "plainer: " + report.degradeName);
    out = fmt::format_to(out, "  {:<10}{} visits, {} frames, {} pictures\n", "so far", report.visits, report.frames,
                         report.pictures);
    if (!report.renderer.empty()) out = fmt::format_to(out, "  {:<10}{}\n", "renderer", report.renderer);

    text += "\nHealth\n";
    for (const MirrorReport::Health& part : report.health) {
        const std::string age = ageInWords(part.age);
        text += trimmed(fmt::format("  {:<10}{}{:<16}{}", part.part, painted(part.state, 18, colour),
                                    age == "just now" ? age : age + " ago", part.reason));
    }

    if (!report.tasks.empty()) {
        text += "\nTasks";
        text +=
            fmt::format("{:>29}{:>10}{:>10}{:>10}{:>10}{:>8}\n", "budget", "mean", "p99", "overruns", "skips", "runs");
    }
    for (const MirrorReport::Task& task : report.tasks) {
        std::string line = fmt::format("  {:<24}{:>5.1f} ms", task.name, milliseconds(task.budget));
        line += task.runs == 0 ? fmt::format("{:>10}{:>10}", "-", "-")
                               : fmt::format("{:>7.2f} ms{:>7.2f} ms", milliseconds(task.mean), milliseconds(task.p99));
        text += line + fmt::format("{:>10}{:>10}{:>8}\n", task.overruns, task.skips, task.runs);
    }

    if (!report.recovery.empty()) {
        text += "\nRecovery of the sensor\n";
        for (const auto& [rung, count] : report.recovery)
            text += fmt::format("  {:<24}{:>8}\n", rung, count);
    }
    return text;
}

std::string statusAsJson(const MirrorReport& report) {
    using Json = nlohmann::ordered_json;
    Json outfits = Json::array();
    for (const MirrorReport::Outfit& outfit : report.outfits)
        outfits.push_back({{"id", outfit.id}, {"name", outfit.name}});
    Json health = Json::array();
    for (const MirrorReport::Health& part : report.health) {
        health.push_back({{"part", part.part},
                          {"state", part.state},
                          {"reason", part.reason},
                          {"since", isoTime(part.since)},
                          {"for_s", hal::seconds(part.age)}});
    }
    Json tasks = Json::array();
    for (const MirrorReport::Task& task : report.tasks) {
        const auto time = [&](hal::Duration duration) { return task.runs > 0 ? Json(milliseconds(duration)) : Json(); };
        tasks.push_back({{"name", task.name},
                         {"budget_ms", milliseconds(task.budget)},
                         {"min_ms", time(task.minimum)},
                         {"mean_ms", time(task.mean)},
                         {"p99_ms", time(task.p99)},
                         {"max_ms", time(task.maximum)},
                         {"runs", task.runs},
                         {"overruns", task.overruns},
                         {"skips", task.skips},
                         {"whole_frame", task.wholeFrame}});
    }
    Json recovery = Json::object();
    for (const auto& [rung, count] : report.recovery)
        recovery[rung] = count;
    const Json root = {{"version", report.version},
                       {"uptime_s", report.uptimeSeconds},
                       {"state", report.state},
                       {"outfit", report.outfit},
                       {"view", report.view},
                       {"outfits", outfits},
                       {"frames_per_second", report.framesPerSecond},
                       {"degrade", {{"level", report.degradeLevel}, {"name", report.degradeName}}},
                       {"visits", report.visits},
                       {"frames", report.frames},
                       {"pictures", report.pictures},
                       {"renderer", report.renderer},
                       {"overall", report.overall},
                       {"health", health},
                       {"tasks", tasks},
                       {"recovery", recovery}};
    return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cheval::daemon

#include "tests/fitting/tracking/visit_report.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>

#include <nlohmann/json.hpp>

namespace cheval::fitting::test {

namespace {

[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...) {
    char line[256];
    std::va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    return line;
}

/// A share with Wilson's bounds, in per cent.
ReportRow rateRow(std::string what, std::string goal, const Rate& rate, std::optional<bool> met, const char* unit) {
    const auto [low, high] = rate.bounds();
    return {.what = std::move(what),
            .goal = std::move(goal),
            .reached = rate.count > 0 ? text("%.1f %%", 100.0 * rate.share()) : "-",
            .count = text("%ld %s", rate.count, unit),
            .bounds = rate.count > 0 ? text("%.1f to %.1f %%", 100.0 * low, 100.0 * high) : "",
            .met = rate.count > 0 ? met : std::nullopt};
}

/// The least time within which that share of them came.
double cameWithin(std::vector<double> times, double share) {
    if (times.empty()) return 0.0;
    std::sort(times.begin(), times.end());
    return times[static_cast<std::size_t>(std::ceil(share * static_cast<double>(times.size()))) - 1];
}

std::string secondsText(double time) {
    return time < kNever ? text("%.2f s", time) : "never";
}

ReportRow timeRow(std::string what, std::string goal, const std::vector<double>& times, double limit) {
    const double p95 = cameWithin(times, 0.95);
    const auto never = std::count(times.begin(), times.end(), kNever);
    Rate within;
    for (const double time : times)
        within.add(time <= limit);
    const auto [low, high] = within.bounds();
    ReportRow row{.what = std::move(what),
                  .goal = std::move(goal),
                  .reached = "p50 " + secondsText(cameWithin(times, 0.5)) + ", p95 " + secondsText(p95) +
                             (never > 0 ? text(", %ld never", static_cast<long>(never)) : ""),
                  .count = text("%zu visits", times.size()),
                  .bounds = text("in time %.1f %%, %.1f to %.1f %%", 100.0 * within.share(), 100.0 * low, 100.0 * high),
                  .met = p95 <= limit};
    if (times.empty()) row.met = std::nullopt;
    return row;
}

double rmsMm(const VisitFigures& figures, std::size_t joint) {
    const long frames = figures.restFrames[joint];
    return frames > 0 ? 1e3 * std::sqrt(figures.restSquares[joint] / static_cast<double>(frames)) : 0.0;
}

ReportRow jitterRow(const VisitFigures& figures) {
    std::size_t worst = 0;
    double squares = 0.0;
    long frames = 0;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        if (rmsMm(figures, i) > rmsMm(figures, worst)) worst = i;
        squares += figures.restSquares[i];
        frames += figures.restFrames[i];
    }
    ReportRow row{.what = "jitter at rest at 2.5 m",
                  .goal = "<= 4 mm RMS, each joint",
                  .reached = text("worst %.1f mm (%s), all %.1f mm", rmsMm(figures, worst),
                                  std::string(kJointNames[worst]).c_str(),
                                  1e3 * std::sqrt(squares / static_cast<double>(std::max(1L, frames)))),
                  .count = text("%zu joints in visits", figures.restRms.size()),
                  .bounds = text("joints in visits: p95 %.1f mm", quantile(figures.restRms, 0.95)),
                  .met = rmsMm(figures, worst) <= 4.0};
    if (frames == 0) row.met = std::nullopt;
    return row;
}

struct JointGroup {
    const char* name;
    std::vector<Joint> joints;
};
std::vector<JointGroup> jointGroups() {
    return {{"head, neck, torso", {Joint::head, Joint::neck, Joint::torso}},
            {"shoulders, hips", {Joint::leftShoulder, Joint::rightShoulder, Joint::leftHip, Joint::rightHip}},
            {"elbows", {Joint::leftElbow, Joint::rightElbow}},
            {"hands", {Joint::leftHand, Joint::rightHand}},
            {"knees", {Joint::leftKnee, Joint::rightKnee}},
            {"feet", {Joint::leftFoot, Joint::rightFoot}}};
}

ReportRow lagRow(const char* how, const std::array<LagCurve, kJointCount>& curves) {
    ReportRow row{.what = text("lag at 1 m/s, %s", how), .goal = "<= 40 ms, each group of joints", .met = true};
    long frames = 0;
    double worst = -1e9;
    for (const JointGroup& group : jointGroups()) {
        LagCurve sum;
        for (const Joint joint : group.joints)
            sum.add(curves[index(joint)]);
        if (sum.frames == 0) continue;
        frames += sum.frames;
        const double lag = sum.bestMs();
        if (lag > worst) {
            worst = lag;
            row.reached = text("worst %.0f ms (%s)", lag, group.name);
        }
        row.met = *row.met && lag <= 40.0;
        row.bounds += text("%s%s %.0f", row.bounds.empty() ? "" : "; ", group.name, lag);
    }
    row.count = text("%ld joints in frames", frames);
    if (frames == 0) {
        row.reached = "-";
        row.met = std::nullopt;
    }
    return row;
}

ReportRow eventsRow(std::string what, std::string goal, long events, double seconds, std::optional<double> limit) {
    const double scale = seconds > 0.0 ? 600.0 / seconds : 0.0;
    const auto [low, high] = poissonBounds(events);
    ReportRow row{.what = std::move(what),
                  .goal = std::move(goal),
                  .reached = text("%.1f in 10 minutes", static_cast<double>(events) * scale),
                  .count = text("%ld in %.1f minutes", events, seconds / 60.0),
                  .bounds = text("%.1f to %.1f", low * scale, high * scale)};
    if (limit && seconds > 0.0) row.met = static_cast<double>(events) * scale <= *limit;
    return row;
}

}  // namespace

std::vector<ReportRow> reportRows(const VisitFigures& f) {
    std::vector<ReportRow> rows;
    rows.push_back(timeRow("first full skeleton after entry", "p95 <= 0.5 s", f.firstFull, 0.5));
    rows.push_back(timeRow("recovery after 1 s hidden", "p95 <= 0.3 s", f.recovery, 0.3));
    rows.push_back(rateRow("same ID after it", "", f.samePersonAfter, std::nullopt, "occlusions"));
    constexpr std::array<const char*, kPassCount> kWays = {"before", "behind", "beside"};
    for (std::size_t i = 0; i < kPassCount; ++i) {
        ReportRow row = rateRow(text("active user kept, others %s", kWays[i]), ">= 99 %", f.kept[i],
                                f.kept[i].share() >= 0.99, "frames");
        row.count += text(" of %ld passes, %ld whole", f.passes[i].count, f.passes[i].hits);
        rows.push_back(std::move(row));
    }
    rows.push_back(jitterRow(f));
    rows.push_back(lagRow("facing", f.lagFacing));
    rows.push_back(lagRow("in profile", f.lagAside));
    rows.push_back(rateRow("swipes found", ">= 95 %", f.swipes, f.swipes.share() >= 0.95, "swipes"));
    rows.push_back(rateRow("grabs found", ">= 95 %", f.grabs, f.grabs.share() >= 0.95, "grabs"));
    rows.push_back(
        eventsRow("events invented while fidgeting", "<= 1 in 10 minutes", f.falseEvents, f.fidgetSeconds, 1.0));
    rows.push_back(eventsRow("events invented beside gestures", "", f.strayGestures, f.gestureSeconds, std::nullopt));
    const JointErrors all = f.allErrors();
    rows.push_back({.what = "visible joints, mean error",
                    .goal = "",
                    .reached = text("%.1f mm", all.meanMm()),
                    .count = text("%ld joints in frames", all.count + all.missed),
                    .bounds = text("%ld missed", all.missed)});
    rows.push_back(rateRow("visible joints within 100 mm", "", all.rate(), std::nullopt, "joints in frames"));
    rows.push_back(rateRow("left and right exchanged", "", f.swaps, std::nullopt, "frames"));
    rows.push_back(
        rateRow("hidden joints with confidence >= 0.5", "", f.hiddenClaims, std::nullopt, "joints in frames"));
    rows.push_back(rateRow("raised open hands read as open", "", f.openHands, std::nullopt, "hands"));
    rows.push_back(rateRow("raised closed hands read as closed", "", f.closedHands, std::nullopt, "hands"));
    rows.push_back(rateRow("raised hands answered unknown", "", f.unknownHands, std::nullopt, "hands"));
    rows.push_back(
        rateRow("the mannequin is active", "never", f.mannequinActive, f.mannequinActive.hits == 0, "frames"));
    rows.push_back(
        rateRow("somebody is active, only a dog is there", "never", f.dogActive, f.dogActive.hits == 0, "frames"));
    std::erase_if(rows, [](const ReportRow& row) { return row.count.starts_with("0 ") && !row.met; });
    return rows;
}

void printReport(const std::vector<ReportRow>& rows, std::FILE* out) {
    std::fprintf(out, "%-40s %-31s %-36s %-44s %-34s %s\n", "what", "goal", "reached", "of", "95 % bounds", "met");
    for (const ReportRow& row : rows) {
        std::fprintf(out, "%-40s %-31s %-36s %-44s %-34s %s\n", row.what.c_str(), row.goal.c_str(), row.reached.c_str(),
                     row.count.c_str(), row.bounds.c_str(), row.met ? (*row.met ? "yes" : "NO") : "");
    }
}

void printDetails(const VisitFigures& figures, std::FILE* out) {
    std::fprintf(out, "\nVisible joints by script: mean error in mm (share within 100 mm in %%)\n%-12s", "");
    for (const std::string_view name : kJointNames)
        std::fprintf(out, " %14s", std::string(name).c_str());
    for (const auto& [script, joints] : figures.errors) {
        std::fprintf(out, "\n%-12s", script.c_str());
        for (const JointErrors& joint : joints)
            std::fprintf(out, "   %5.0f (%3.0f %%)", joint.meanMm(), 100.0 * joint.rate().share());
    }
    std::fprintf(out, "\nBy shopper\n");
    for (std::size_t i = 0; i < kShopperKindCount; ++i) {
        const JointErrors& errors = figures.errorsByShopper[i];
        const Rate& full = figures.fullInTime[i];
        std::fprintf(out,
                     "%-12s mean error %.1f mm, within 100 mm %.1f %% of %ld joints in frames; full skeleton in time "
                     "in %ld of %ld visits\n",
                     kShopperKindNames[i], errors.meanMm(), 100.0 * errors.rate().share(), errors.rate().count,
                     full.hits, full.count);
    }
    const auto line = [&](const char* name, const auto& value) {
        std::fprintf(out, "\n%-12s", name);
        for (std::size_t i = 0; i < kJointCount; ++i)
            std::fprintf(out, " %14.1f", value(i));
    };
    std::fprintf(out, "Jitter, mm RMS, and lag, ms");
    line("at rest", [&](std::size_t i) { return rmsMm(figures, i); });
    line("facing",
         [&](std::size_t i) { return figures.lagFacing[i].frames > 0 ? figures.lagFacing[i].bestMs() : 0.0; });
    line("in profile",
         [&](std::size_t i) { return figures.lagAside[i].frames > 0 ? figures.lagAside[i].bestMs() : 0.0; });
    std::fprintf(out, "\n");
}

std::string jsonOf(const std::vector<ReportRow>& rows) {
    nlohmann::json all = nlohmann::json::array();
    for (const ReportRow& row : rows) {
        nlohmann::json one = {{"what", row.what},   {"goal", row.goal},     {"reached", row.reached},
                              {"count", row.count}, {"bounds", row.bounds}, {"met", nullptr}};
        if (row.met) one["met"] = *row.met;
        all.push_back(std::move(one));
    }
    return all.dump(1) + "\n";
}

}  // namespace cheval::fitting::test

#include "daemon/budget_table.h"

#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace cheval::daemon {
namespace {

double milliseconds(hal::Duration duration) {
    return hal::seconds(duration) * 1e3;
}

}  // namespace

std::string budgetMarkdown(const BudgetTable& table) {
    std::string text = fmt::format(
        "# {}: frame budget\n\n{} frames shown in {:.1f} s. Milliseconds; an overrun is a run that took longer than "
        "its "
        "budget, a skip is one that was put off for want of time.\n\n"
        "| task | budget | mean | p99 | max | runs | overruns | skips |\n"
        "|---|---:|---:|---:|---:|---:|---:|---:|\n",
        table.title, table.frames, hal::seconds(table.visit));
    for (const TaskStatistics& task : table.tasks) {
        auto out = std::back_inserter(text);
        out = fmt::format_to(out, "| {} | {:.2f} | ", task.name, milliseconds(task.budget));
        if (task.runs > 0) {
            out = fmt::format_to(out, "{:.2f} | {:.2f} | {:.2f}", milliseconds(task.mean), milliseconds(task.p99),
                                 milliseconds(task.maximum));
        } else {
            out = fmt::format_to(out, "– | – | –");
        }
        fmt::format_to(out, " | {} | {} | {} |\n", task.runs, task.overruns, task.skips);
    }
    return text;
}

std::string budgetJson(const BudgetTable& table) {
    nlohmann::ordered_json tasks = nlohmann::ordered_json::array();
    for (const TaskStatistics& task : table.tasks) {
        const auto time = [&](hal::Duration duration) {
            return task.runs > 0 ? nlohmann::ordered_json(milliseconds(duration)) : nlohmann::ordered_json();
        };
        tasks.push_back({{"name", task.name},
                         {"budget_ms", milliseconds(task.budget)},
                         {"runs", task.runs},
                         {"mean_ms", time(task.mean)},
                         {"p99_ms", time(task.p99)},
                         {"max_ms", time(task.maximum)},
                         {"min_ms", time(task.minimum)},
                         {"overruns", task.overruns},
                         {"skips", task.skips}});
    }
    const nlohmann::ordered_json root = {
        {"title", table.title}, {"frames", table.frames}, {"visit_s", hal::seconds(table.visit)}, {"tasks", tasks}};
    // Names are ours, the title may be anybody's: what is not UTF-8 is replaced, never thrown over.
    return root.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace cheval::daemon

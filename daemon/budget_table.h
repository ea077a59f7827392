// The frame-budget table as people read it (Markdown) and as programs do (JSON).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/scheduler.h"
#include "hal/clock.h"

namespace cheval::daemon {

/// What a table is made of.
struct BudgetTable {
    std::string title;
    std::int64_t frames = 0;  ///< Shown to the shopper.
    hal::Duration visit{};    ///< From the first of them to the last.
    std::vector<TaskStatistics> tasks;
};

/// One row a task, in the given order; milliseconds to two decimals. A task that never ran has dashes for its times.
std::string budgetMarkdown(const BudgetTable& table);

/// `{"title", "frames", "visit_s", "tasks": [{"name", "budget_ms", "runs", "mean_ms", "p99_ms", "max_ms", "min_ms",
/// "overruns", "skips"}]}`, indented; times of a task that never ran are null.
std::string budgetJson(const BudgetTable& table);

}  // namespace cheval::daemon

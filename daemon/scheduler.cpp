#include "daemon/scheduler.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace cheval::daemon {

namespace {

Error badTable(const Task& task, std::string cause) {
    return Error{.code = ErrorCode::internal,
                 .cause = std::move(cause),
                 .why = "a task table is checked when it is put to use",
                 .key = std::string(task.name)};
}

hal::Duration scaled(hal::Duration duration, double factor) {
    return hal::Duration(static_cast<hal::Duration::rep>(std::llround(static_cast<double>(duration.count()) * factor)));
}

}  // namespace

Expected<Scheduler> Scheduler::create(std::span<const Task> table, const SchedulerOptions& options,
                                      const hal::Clock& admission, const hal::Clock& cost) {
    if (table.empty() || table.size() > kMaximumTasks) {
        return Error{.code = ErrorCode::internal,
                     .cause = "a task table has 1 to " + std::to_string(kMaximumTasks) + " rows"};
    }
    if (options.framePeriod <= hal::Duration::zero() || !(options.budgetScale > 0.0)) {
        return Error{.code = ErrorCode::internal, .cause = "the frame period and the budget scale must be positive"};
    }
    for (std::size_t i = 0; i < table.size(); ++i) {
        const Task& task = table[i];
        if (task.name.empty()) return badTable(task, "row " + std::to_string(i) + " has no name");
        if (task.work == nullptr) return badTable(task, "the task has no work");
        if (task.budget <= hal::Duration::zero()) return badTable(task, "the task has no budget");
        if (!(task.rateHz >= 0.0)) return badTable(task, "the task's rate is not a rate");
        if (i > 0 && task.priority <= table[i - 1].priority)
            return badTable(task, "the table is not in order of priority");
    }
    return Scheduler(table, options, admission, cost);
}

Scheduler::Scheduler(std::span<const Task> table, const SchedulerOptions& options, const hal::Clock& admission,
                     const hal::Clock& cost)
    : table_(table), options_(options), admission_(&admission), cost_(&cost), rows_(table.size()) {
    setFramePeriod(options.framePeriod);
    for (Row& row : rows_)
        row.waited = row.interval;  // Everything is due in the first frame.
}

void Scheduler::setFramePeriod(hal::Duration period) {
    period_ = period;
    frame_.budget = period;
    const double factor =
        static_cast<double>(period.count()) / static_cast<double>(kReferencePeriod.count()) * options_.budgetScale;
    hal::Duration mandatory{};
    for (std::size_t i = rows_.size(); i-- > 0;) {
        Row& row = rows_[i];
        row.budget = scaled(table_[i].budget, factor);
        row.laterMandatory = mandatory;
        if (table_[i].skip == SkipPolicy::never) mandatory += row.budget;
        const double frames = table_[i].rateHz > 0.0 ? 1.0 / (table_[i].rateHz * hal::seconds(period)) : 1.0;
        row.interval = static_cast<std::uint64_t>(std::clamp(std::round(frames), 1.0, 1e9));
    }
}

hal::Duration Scheduler::timeLeft() const {
    return limit_ - admission_->now();
}

hal::Duration Scheduler::runFrame(hal::TimePoint started, void* context) {
    limit_ = started + period_;
    const hal::TimePoint frameStart = cost_->now();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const Task& task = table_[i];
        Row& row = rows_[i];
        if (++row.waited < row.interval) continue;
        if (task.wanted != nullptr && !task.wanted(context)) continue;
        if (task.skip == SkipPolicy::whenLate && row.budget + row.laterMandatory > timeLeft()) {
            ++row.skips;
            continue;
        }
        row.waited = 0;
        const hal::TimePoint begin = cost_->now();
        task.work(context);
        const hal::Duration taken = cost_->now() - begin;
        row.times.add(taken);
        if (taken > row.budget) ++row.overruns;
    }
    const hal::Duration taken = cost_->now() - frameStart;
    frame_.times.add(taken);
    if (taken > period_) ++frame_.overruns;
    return taken;
}

TaskStatistics Scheduler::describe(std::string_view name, const Row& row) {
    return {.name = name,
            .budget = row.budget,
            .runs = row.times.count(),
            .skips = row.skips,
            .overruns = row.overruns,
            .minimum = row.times.minimum(),
            .mean = row.times.mean(),
            .p99 = row.times.percentile(0.99),
            .maximum = row.times.maximum()};
}

TaskStatistics Scheduler::statistics(std::size_t task) const {
    return describe(table_[task].name, rows_[task]);
}

TaskStatistics Scheduler::frameStatistics() const {
    return describe("frame", frame_);
}

}  // namespace cheval::daemon

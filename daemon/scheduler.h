// Runs a frame's tasks within the frame's time: admission by what is left, accounting of what was used. It never
// pre-empts: a budget is a promise that is counted, a hang is the watchdog's business. After ArduPilot's AP_Scheduler.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "daemon/duration_histogram.h"
#include "hal/clock.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// What happens to a task that is due when its budget no longer fits.
enum class SkipPolicy : std::uint8_t {
    never,     ///< It runs all the same: without it there is no picture.
    whenLate,  ///< It waits for the next frame, where it is due again.
};

/// One row of a task table. Tables are const and in the order of the data's way.
struct Task {
    std::string_view name;
    double rateHz = 0.0;  ///< 0: every frame. Otherwise at most this often, counted in frames.
    hal::Duration
        budget{};      ///< At the reference period; scales with the frame period and SchedulerOptions::budgetScale.
    int priority = 0;  ///< Lower runs earlier; strictly rising down the table.
    SkipPolicy skip = SkipPolicy::never;
    void (*work)(void* context) = nullptr;
    /// Null: always. Otherwise the task is not due where it returns false (layering, when nothing changed).
    bool (*wanted)(const void* context) = nullptr;
};

inline constexpr std::size_t kMaximumTasks = 16;
/// The period that the budgets in daemon/ARCHITECTURE.md are for.
inline constexpr hal::Duration kReferencePeriod{33'333'333};

struct SchedulerOptions {
    hal::Duration framePeriod = kReferencePeriod;
    double budgetScale = 1.0;  ///< For machines slower or faster than the reference.
};

/// Counted since the start, as `chevalctl status` and the metrics show it.
struct TaskStatistics {
    std::string_view name;
    hal::Duration budget{};  ///< As scaled now.
    std::uint64_t runs = 0;
    std::uint64_t skips = 0;     ///< Due, and put off for want of time.
    std::uint64_t overruns = 0;  ///< Took longer than its budget.
    hal::Duration minimum{};
    hal::Duration mean{};
    hal::Duration p99{};
    hal::Duration maximum{};
};

/// Thread-bound. After create() no call takes heap memory.
class Scheduler {
  public:
    /// Borrows the table and the clocks. `admission` decides what still fits; in replay and simulation it is virtual,
    /// so nothing is ever shed and results do not depend on the machine. `cost` measures what tasks take. Refuses a
    /// table that is empty, too long, not in order of priority, or has a row without work, name or budget.
    static Expected<Scheduler> create(std::span<const Task> table, const SchedulerOptions& options,
                                      const hal::Clock& admission, const hal::Clock& cost);

    /// Runs what is due. `started` is when the frame's time began to run, by the admission clock; the frame's limit is
    /// one period later. A task may be put off only if its own budget and the budgets of the rows below that may not be
    /// put off do not fit into what is left. Returns what the whole frame took, by the cost clock.
    hal::Duration runFrame(hal::TimePoint started, void* context);

    /// What is left of the current frame; negative when late. For tasks that can shed work of their own.
    [[nodiscard]] hal::Duration timeLeft() const;
    /// Another period (the degrade ladder's frame rate): budgets and rates follow.
    void setFramePeriod(hal::Duration period);
    [[nodiscard]] hal::Duration framePeriod() const { return period_; }

    [[nodiscard]] std::size_t taskCount() const { return table_.size(); }
    [[nodiscard]] TaskStatistics statistics(std::size_t task) const;
    /// The whole frame, as one more row named "frame" with the period as its budget.
    [[nodiscard]] TaskStatistics frameStatistics() const;

  private:
    struct Row {
        hal::Duration budget{};
        hal::Duration laterMandatory{};  ///< Budgets of the rows below that are never put off.
        std::uint64_t interval = 1;      ///< Frames between runs.
        std::uint64_t waited = 0;        ///< Frames since the last run.
        std::uint64_t skips = 0;
        std::uint64_t overruns = 0;
        DurationHistogram times;
    };

    Scheduler(std::span<const Task> table, const SchedulerOptions& options, const hal::Clock& admission,
              const hal::Clock& cost);
    static TaskStatistics describe(std::string_view name, const Row& row);

    std::span<const Task> table_;
    SchedulerOptions options_;
    const hal::Clock* admission_;
    const hal::Clock* cost_;
    hal::Duration period_{};
    hal::TimePoint limit_{};
    std::vector<Row> rows_;
    Row frame_;
};

}  // namespace cheval::daemon

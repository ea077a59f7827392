// Time for the whole program. The product runs on SteadyClock; simulation, replay and tests run on VirtualClock, so
// that a day can pass in minutes and no watchdog, dwell or back-off depends on the machine's speed.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>

namespace cheval::hal {

using Duration = std::chrono::nanoseconds;

/// Tag of the program's time line; its zero is the start of the steady clock, or of the simulated world.
struct TimeLine {
    using duration = Duration;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::time_point<TimeLine>;
    static constexpr bool is_steady = true;  // NOLINT(readability-identifier-naming): the standard's name.
};
using TimePoint = TimeLine::time_point;

/// Seconds as a real number, for arithmetic that is not about deadlines.
constexpr double seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}
constexpr double seconds(TimePoint time) {
    return seconds(time.time_since_epoch());
}
/// The Duration nearest to a real number of seconds.
constexpr Duration fromSeconds(double value) {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(value));
}

/// Ends a wait from another thread. Thread-safe.
class Interrupt {
  public:
    /// Every wait with this interrupt, now and later, returns at once.
    void raise();
    /// Waits wait again.
    void clear();
    [[nodiscard]] bool raised() const { return raised_.load(std::memory_order_acquire); }

  private:
    friend class SteadyClock;
    std::atomic<bool> raised_{false};
    std::mutex mutex_;
    std::condition_variable changed_;
};

/// A source of time. Thread-safe.
class Clock {
  public:
    virtual ~Clock() = default;
    [[nodiscard]] virtual TimePoint now() const = 0;
    /// Returns true when `deadline` is reached, false as soon as `interrupt` is raised. Never waits past the deadline.
    virtual bool waitUntil(TimePoint deadline, Interrupt& interrupt) = 0;

  protected:
    Clock() = default;
    Clock(const Clock&) = default;
    Clock& operator=(const Clock&) = default;
};

/// CLOCK_MONOTONIC.
class SteadyClock final : public Clock {
  public:
    [[nodiscard]] TimePoint now() const override;
    bool waitUntil(TimePoint deadline, Interrupt& interrupt) override;
};

/// Time that moves only when somebody waits for it or advances it: waiting is instant. Starts at zero.
class VirtualClock final : public Clock {
  public:
    [[nodiscard]] TimePoint now() const override { return TimePoint(Duration(now_.load(std::memory_order_acquire))); }
    /// Moves time to `deadline` if that lies ahead.
    bool waitUntil(TimePoint deadline, Interrupt& interrupt) override;
    void advance(Duration duration) { now_.fetch_add(duration.count(), std::memory_order_acq_rel); }

  private:
    std::atomic<Duration::rep> now_{0};
};

}  // namespace cheval::hal

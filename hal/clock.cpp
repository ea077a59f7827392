#include "hal/clock.h"

namespace cheval::hal {

void Interrupt::raise() {
    {
        const std::lock_guard lock(mutex_);
        raised_.store(true, std::memory_order_release);
    }
    changed_.notify_all();
}

void Interrupt::clear() {
    raised_.store(false, std::memory_order_release);
}

TimePoint SteadyClock::now() const {
    return TimePoint(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

bool SteadyClock::waitUntil(TimePoint deadline, Interrupt& interrupt) {
    const std::chrono::steady_clock::time_point until(
        std::chrono::duration_cast<std::chrono::steady_clock::duration>(deadline.time_since_epoch()));
    std::unique_lock lock(interrupt.mutex_);
    return !interrupt.changed_.wait_until(lock, until, [&] { return interrupt.raised(); });
}

bool VirtualClock::waitUntil(TimePoint deadline, Interrupt& interrupt) {
    if (interrupt.raised()) return false;
    const Duration::rep target = deadline.time_since_epoch().count();
    Duration::rep current = now_.load(std::memory_order_acquire);
    while (current < target && !now_.compare_exchange_weak(current, target, std::memory_order_acq_rel)) {
    }
    return true;
}

}  // namespace cheval::hal

#include "hal/preview/button_queue.h"

namespace cheval::hal {

void ButtonQueue::press(const ButtonEvent& event) {
    const std::lock_guard lock(mutex_);
    if (count_ == kCapacity) {
        first_ = (first_ + 1) % kCapacity;
        --count_;
        dropped_.fetch_add(1, std::memory_order_relaxed);
    }
    events_[(first_ + count_) % kCapacity] = event;
    ++count_;
    pressed_.fetch_add(1, std::memory_order_relaxed);
}

Expected<std::size_t> ButtonQueue::doPoll(std::span<ButtonEvent> events) {
    const std::lock_guard lock(mutex_);
    std::size_t given = 0;
    while (given < events.size() && count_ > 0) {
        events[given++] = events_[first_];
        first_ = (first_ + 1) % kCapacity;
        --count_;
    }
    return given;
}

}  // namespace cheval::hal

#include "hal/gpiod/button_filter.h"

#include <algorithm>

namespace cheval::hal {

void ButtonFilter::begin(bool active, TimePoint now) {
    accepted_ = raw_ = active;
    changed_ = pressed_ = advanced_ = now;
    reported_ = false;
    longReported_ = active;
    stuck_ = false;
}

std::optional<ButtonEvent> ButtonFilter::advance(TimePoint time) {
    advanced_ = std::max(advanced_, time);
    // What was held before the level changed is older than the change.
    const TimePoint heldUntil = raw_ ? time : std::min(time, changed_);
    if (accepted_ && !longReported_ && heldUntil - pressed_ >= times_.longPress) {
        longReported_ = true;
        return ButtonEvent{.action = ButtonAction::longPressed, .time = pressed_ + times_.longPress};
    }
    if (accepted_ && heldUntil - pressed_ >= times_.stuck) stuck_ = true;
    if (raw_ == accepted_ || time - changed_ < times_.debounce) return std::nullopt;
    accepted_ = raw_;
    if (accepted_) {
        pressed_ = changed_;
        reported_ = true;
        longReported_ = false;
        return ButtonEvent{.action = ButtonAction::pressed, .time = changed_};
    }
    stuck_ = false;
    if (!reported_) return std::nullopt;
    reported_ = false;
    return ButtonEvent{.action = ButtonAction::released, .time = changed_};
}

void ButtonFilter::edge(bool active, TimePoint time) {
    // Two edges of one direction: the one between was lost, and with it a level too short to count.
    if (active == raw_) return;
    raw_ = active;
    changed_ = std::max(time, advanced_);
}

std::optional<ButtonEvent> ButtonFilter::end(TimePoint now) {
    const bool reported = reported_;
    begin(false, now);
    if (!reported) return std::nullopt;
    return ButtonEvent{.action = ButtonAction::released, .time = now};
}

}  // namespace cheval::hal

#include "hal/gpiod/power_line.h"

#include <utility>

namespace cheval::hal {

PowerLine::PowerLine(PowerLineOptions options, std::unique_ptr<LineProvider> provider, const Clock& clock)
    : options_(std::move(options)), provider_(std::move(provider)), clock_(clock) {}

PowerLine::~PowerLine() {
    // A sensor must not stay dark because the mirror ended in the middle.
    if (off_ && line_ != nullptr) static_cast<void>(line_->set(true));
}

Expected<void> PowerLine::hold() {
    if (line_ != nullptr) return {};
    Expected<std::unique_ptr<OutputLine>> line = provider_->output(options_.line, true);
    if (!line) return std::move(line).error().within("the sensor's power");
    line_ = std::move(*line);
    return {};
}

Expected<void> PowerLine::cycle() {
    Expected<void> held = hold();
    if (!held) return held;
    const TimePoint now = clock_.now();
    if (!off_) {
        Expected<void> switched = drive(false);
        if (!switched) return switched;
        off_ = true;
        onAt_ = now + options_.off;
    }
    if (now < onAt_) return Error{.code = ErrorCode::timedOut, .cause = "the sensor's power is off for a moment"};
    Expected<void> switched = drive(true);
    if (switched) off_ = false;
    return switched;
}

Expected<void> PowerLine::drive(bool active) {
    Expected<void> driven = line_->set(active);
    // One whose chip is gone is asked for anew.
    if (!driven) line_.reset();
    return driven;
}

}  // namespace cheval::hal

#include "daemon/recovery.h"

#include <algorithm>

namespace cheval::daemon {

namespace {

/// The order in which rungs are taken while nothing helps. The dear ones come after the cheap ones have had two tries,
/// and the end of the list goes on at kAgain.
constexpr std::array kLadder = {RecoveryRung::restartStream, RecoveryRung::reopenDevice, RecoveryRung::reopenDevice,
                                RecoveryRung::recycle,       RecoveryRung::recycle,      RecoveryRung::resetUsb,
                                RecoveryRung::powerCycle};
constexpr std::size_t kAgain = 3;
/// A device that was reset, or whose power was switched, is on the bus again within this time.
constexpr hal::Duration kEnumeration = std::chrono::seconds(10);
/// A new process did not help so often: the next thing is a new machine.
constexpr std::uint32_t kRestartsBeforeReboot = 3;

constexpr std::array<std::string_view, kRecoveryRungCount> kRungNames = {"retry", "stream", "device", "process",
                                                                         "usb",   "power",  "daemon", "machine"};
constexpr std::array<std::string_view, 7> kStateNames = {"closed",   "opening", "unproven", "streaming",
                                                         "doubtful", "resting", "ended"};
constexpr std::array<std::string_view, 9> kEventNames = {"begin", "opened",  "prepared", "refused", "frame",
                                                         "lost",  "arrived", "timer",    "ended"};

}  // namespace

std::string_view name(RecoveryRung rung) {
    return kRungNames[static_cast<std::size_t>(rung)];
}
std::string_view name(RecoveryState state) {
    return kStateNames[static_cast<std::size_t>(state)];
}
std::string_view name(RecoveryEvent event) {
    return kEventNames[static_cast<std::size_t>(event)];
}

RecoveryMachine::RecoveryMachine(const RecoveryOptions& options) : options_(options) {
    forget();
}

void RecoveryMachine::forget() {
    position_ = 0;
    attempts_ = 0;
    pause_ = options_.firstPause;
}

RecoveryAction RecoveryMachine::enter(RecoveryState state, hal::TimePoint deadline) {
    state_ = state;
    deadline_ = deadline;
    return RecoveryAction::none;
}

RecoveryAction RecoveryMachine::open(hal::TimePoint now) {
    enter(RecoveryState::opening, now + options_.openLimit);
    return RecoveryAction::open;
}

RecoveryAction RecoveryMachine::frame(hal::TimePoint now) {
    lastGood_ = now;
    if (state_ != RecoveryState::streaming && state_ != RecoveryState::doubtful) streamingSince_ = now;
    // One frame is not health: a sensor that dies after each would be reopened without a pause for ever.
    if (now - streamingSince_ >= options_.healthy) forget();
    return enter(RecoveryState::streaming, options_.silence ? now + *options_.silence / 2 : hal::TimePoint::max());
}

bool RecoveryMachine::allowed(RecoveryRung rung) const {
    if (rung > options_.highest) return false;
    return rung <= RecoveryRung::recycle || (options_.available && options_.available(rung));
}

RecoveryRung RecoveryMachine::choose(RecoveryRung lowest, hal::TimePoint now) {
    if (now - lastGood_ >= options_.restartAfter) {
        if (options_.restartsBefore >= kRestartsBeforeReboot && allowed(RecoveryRung::reboot))
            return RecoveryRung::reboot;
        if (allowed(RecoveryRung::restartDaemon)) return RecoveryRung::restartDaemon;
    }
    // At most once around: recycle is always allowed, unless the settings stop below it.
    for (std::size_t tries = 0; tries < 2 * kLadder.size(); ++tries) {
        if (position_ == kLadder.size()) position_ = kAgain;
        const RecoveryRung next = kLadder[position_++];
        if (next >= lowest && allowed(next)) return next;
    }
    return RecoveryRung::reopenDevice;
}

RecoveryAction RecoveryMachine::climb(RecoveryRung lowest, hal::TimePoint now) {
    rung_ = choose(lowest, now);
    // The first thing is done at once: most often it helps.
    if (attempts_++ == 0) return take(now);
    enter(RecoveryState::resting, now + pause_);
    pause_ = std::min(pause_ * 2, options_.longestPause);
    return RecoveryAction::none;
}

RecoveryAction RecoveryMachine::take(hal::TimePoint now) {
    ++counts_[static_cast<std::size_t>(rung_)];
    if (rung_ > RecoveryRung::recycle) ownDoing_ = now + options_.openLimit + kEnumeration;
    enter(RecoveryState::opening, now + options_.openLimit);
    return RecoveryAction::perform;
}

RecoveryAction RecoveryMachine::arrival(hal::TimePoint now) {
    // Whatever was plugged in: it has had no chance yet. But a reset or a power cycle makes the device arrive too, and
    // must not begin the ladder anew.
    if (now >= ownDoing_) forget();
    if (state_ != RecoveryState::resting) return RecoveryAction::none;
    rung_ = RecoveryRung::reopenDevice;
    ++attempts_;
    return take(now);
}

RecoveryAction RecoveryMachine::on(RecoveryEvent event, hal::TimePoint now) {
    if (state_ == RecoveryState::ended) return RecoveryAction::none;
    switch (event) {
        case RecoveryEvent::begin:
            if (state_ != RecoveryState::closed) return RecoveryAction::none;
            lastGood_ = now;
            ++attempts_;
            return open(now);
        case RecoveryEvent::opened:
            if (state_ != RecoveryState::opening) return RecoveryAction::none;
            return enter(RecoveryState::unproven, options_.silence
                                                      ? now + std::max(options_.firstFrame, *options_.silence)
                                                      : hal::TimePoint::max());
        case RecoveryEvent::prepared:
            if (state_ != RecoveryState::opening) return RecoveryAction::none;
            ownDoing_ = now + kEnumeration;
            return enter(RecoveryState::opening, now + options_.openLimit);
        case RecoveryEvent::refused:
            // A restart that cannot be had must not keep the other rungs from their turn.
            if (state_ == RecoveryState::opening && rung_ >= RecoveryRung::restartDaemon) lastGood_ = now;
            return state_ == RecoveryState::opening ? climb(RecoveryRung::reopenDevice, now) : RecoveryAction::none;
        case RecoveryEvent::frame:
            return frame(now);
        case RecoveryEvent::lost:
            return state_ == RecoveryState::resting ? RecoveryAction::none : climb(RecoveryRung::reopenDevice, now);
        case RecoveryEvent::arrived:
            return arrival(now);
        case RecoveryEvent::ended:
            return enter(RecoveryState::ended, hal::TimePoint::max());
        case RecoveryEvent::timer:
            break;
    }
    if (now < deadline_) return RecoveryAction::none;
    switch (state_) {
        case RecoveryState::streaming:
            ++counts_[static_cast<std::size_t>(RecoveryRung::retryRead)];
            return enter(RecoveryState::doubtful, now + *options_.silence / 2);
        case RecoveryState::doubtful:
        case RecoveryState::unproven:
            return climb(RecoveryRung::restartStream, now);
        case RecoveryState::opening:
            return climb(RecoveryRung::recycle, now);
        case RecoveryState::resting:
            return take(now);
        case RecoveryState::closed:
        case RecoveryState::ended:
            break;
    }
    return RecoveryAction::none;
}

}  // namespace cheval::daemon

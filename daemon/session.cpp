#include "daemon/session.h"

#include <algorithm>

namespace cheval::daemon {

std::string_view name(SessionState state) {
    switch (state) {
        case SessionState::idle:
            return "idle";
        case SessionState::approaching:
            return "approaching";
        case SessionState::acquiring:
            return "acquiring";
        case SessionState::wearing:
            return "wearing";
        case SessionState::leaving:
            return "leaving";
    }
    return "";
}

Session::Session(const SessionOptions& options) : options_(options) {
    startAnew();
}

void Session::startAnew() {
    outfit_ = options_.startOutfit < options_.outfitCount ? options_.startOutfit : 0;
    avatarView_ = options_.startInAvatarView;
    userId_ = 0;
    jointsSeen_ = false;
    newcomer_ = true;
}

void Session::reset() {
    startAnew();
    state_ = SessionState::idle;
    // The next frame's time may lie before the last one's: a still starts its own time.
    now_ = hal::TimePoint{};
    entered_ = now_;
    lastSeen_ = now_;
}

void Session::step(std::ptrdiff_t by) {
    const auto count = static_cast<std::ptrdiff_t>(options_.outfitCount);
    if (count == 0) return;
    outfit_ = static_cast<std::size_t>((static_cast<std::ptrdiff_t>(outfit_) + by + count) % count);
}

void Session::press(const hal::ButtonEvent& event) {
    if (event.action != hal::ButtonAction::pressed) return;
    switch (event.button) {
        case hal::Button::next:
            step(1);
            break;
        case hal::Button::previous:
            step(-1);
            break;
        case hal::Button::view:
            changeView();
            break;
        case hal::Button::service:
            serviceScreen_ = !serviceScreen_;
            break;
        case hal::Button::wake:
            serviceScreen_ = false;
            break;
    }
}

void Session::choose(std::size_t outfit) {
    if (outfit < options_.outfitCount) outfit_ = outfit;
}

void Session::obey(const RemoteCommand& command) {
    switch (command.kind) {
        case RemoteCommand::Kind::next:
            step(1);
            break;
        case RemoteCommand::Kind::previous:
            step(-1);
            break;
        case RemoteCommand::Kind::choose:
            choose(command.outfit);
            break;
        case RemoteCommand::Kind::mirrorView:
            showAvatar(false);
            break;
        case RemoteCommand::Kind::avatarView:
            showAvatar(true);
            break;
    }
}

void Session::understand(const fitting::GestureEvent& gesture) {
    switch (gesture.kind) {
        case fitting::GestureKind::swipe: {
            const bool left = gesture.direction == fitting::SwipeDirection::left;
            step(left == options_.swipeLeftIsNext ? 1 : -1);
            break;
        }
        case fitting::GestureKind::hold:
            if (options_.holdChangesView) changeView();
            break;
        case fitting::GestureKind::grab:
        case fitting::GestureKind::raise:
            break;
    }
}

void Session::enter(SessionState state, hal::TimePoint time) {
    if (state == SessionState::wearing && newcomer_) {
        ++visits_;
        newcomer_ = false;
    }
    if (state == SessionState::idle) startAnew();
    if (state == SessionState::acquiring) jointsSeen_ = false;
    state_ = state;
    entered_ = time;
}

void Session::update(const SessionInput& input) {
    now_ = std::max(now_, input.time);
    for (const hal::ButtonEvent& event : input.buttons)
        press(event);
    for (const RemoteCommand& command : input.commands)
        obey(command);
    // Hands speak for the dressed alone: whoever walks in with swinging arms chooses nothing.
    if (state_ == SessionState::wearing) {
        for (const fitting::GestureEvent& gesture : input.gestures)
            understand(gesture);
    }
    if (input.userId != 0) lastSeen_ = now_;
    // Walking in, a dwell of zero and the joints all at once make two steps; more cannot follow from one frame.
    if (advance(input)) advance(input);
}

bool Session::advance(const SessionInput& input) {
    const bool seen = input.userId != 0;
    const hal::Duration here = now_ - entered_;
    switch (state_) {
        case SessionState::idle:
            if (!seen) return false;
            userId_ = input.userId;
            enter(SessionState::approaching, now_);
            return true;
        case SessionState::approaching:
            if (!seen) {
                enter(SessionState::idle, now_);
                return false;
            }
            userId_ = input.userId;
            if (here < options_.approach) return false;
            enter(SessionState::acquiring, now_);
            return true;
        case SessionState::acquiring: {
            if (!seen) {
                jointsSeen_ = false;
                if (now_ - lastSeen_ >= options_.leave) enter(SessionState::idle, now_);
                return false;
            }
            userId_ = input.userId;
            if (!input.jointsSeen) {
                jointsSeen_ = false;
                return false;
            }
            if (!jointsSeen_) jointsSince_ = now_;
            jointsSeen_ = true;
            const bool steady = now_ - jointsSince_ >= options_.acquire;
            if (!steady || !(input.measured || here >= options_.acquireLimit)) return false;
            enter(SessionState::wearing, now_);
            return false;
        }
        case SessionState::wearing:
            if (!seen) {
                if (now_ - lastSeen_ < options_.leave) return false;
                enter(SessionState::leaving, now_);
                return true;
            }
            if (input.userId == userId_) return false;
            // Another number so soon is most often the same person, lost and found: the choice stays.
            userId_ = input.userId;
            enter(SessionState::acquiring, now_);
            return true;
        case SessionState::leaving:
            if (seen) {
                const bool same = input.userId == userId_;
                userId_ = input.userId;
                enter(same ? SessionState::wearing : SessionState::acquiring, now_);
                return !same;
            }
            if (here >= options_.gone) enter(SessionState::idle, now_);
            return false;
    }
    return false;
}

}  // namespace cheval::daemon

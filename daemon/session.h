// Who is at the mirror and what they chose: idle, approaching, acquiring, wearing, leaving. Times are the frames'
// capture times, so that replays and simulated days behave as the shop does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "daemon/remote_commands.h"
#include "fitting/hands.h"
#include "hal/clock.h"
#include "hal/event.h"

namespace cheval::daemon {

enum class SessionState : std::uint8_t {
    idle,         ///< Nobody is in the zone.
    approaching,  ///< Somebody is, but perhaps only walks by.
    acquiring,    ///< Somebody stands there; joints and size are being found.
    wearing,      ///< Dressed.
    leaving,      ///< Out of sight; comes back, or is gone.
};

std::string_view name(SessionState state);

/// Dwell times, and how gestures are meant.
struct SessionOptions {
    hal::Duration approach = hal::fromSeconds(0.3);      ///< Seen in the zone before it counts as coming.
    hal::Duration acquire = hal::fromSeconds(0.3);       ///< Joints seen before dressing.
    hal::Duration acquireLimit = hal::fromSeconds(2.0);  ///< Dressed after this long without a measurement.
    hal::Duration leave = hal::fromSeconds(1.0);         ///< Unseen before the clothes come off.
    hal::Duration gone = hal::fromSeconds(2.0);          ///< Leaving before the visit is over.
    bool swipeLeftIsNext =
        true;  ///< The hand pushes the row of clothes: pushed to the left, the next comes from the right.
    bool holdChangesView = true;  ///< A hand held still is the view button of who has none.
    std::size_t outfitCount = 0;
    std::size_t startOutfit = 0;
    bool startInAvatarView = false;
};

/// What one frame, or one time-out without a frame, says.
struct SessionInput {
    hal::TimePoint time{};
    std::uint32_t userId = 0;  ///< The active user in the zone; 0: nobody.
    bool jointsSeen = false;   ///< Enough joints for clothes to hang on.
    bool measured = false;     ///< There is a body to dress.
    std::span<const hal::ButtonEvent> buttons;
    std::span<const RemoteCommand> commands;  ///< After the buttons.
    std::span<const fitting::GestureEvent> gestures;
};

/// Thread-bound. No call takes heap memory.
class Session {
  public:
    explicit Session(const SessionOptions& options);

    /// At most two states change in one call (a dwell of zero passes at once). Time that runs backwards counts as none.
    void update(const SessionInput& input);
    /// Nobody is there and nothing was chosen (a recording's next still, a sensor reopened).
    void reset();
    /// Wears this outfit from now to the end of the visit; a number that no outfit has changes nothing.
    void choose(std::size_t outfit);
    /// Shows the mannequin, or the mirror, from now to the end of the visit.
    void showAvatar(bool avatar) { avatarView_ = avatar; }

    [[nodiscard]] SessionState state() const { return state_; }
    /// Clothes are drawn.
    [[nodiscard]] bool dressed() const { return state_ == SessionState::wearing; }
    [[nodiscard]] std::size_t outfit() const { return outfit_; }
    [[nodiscard]] bool avatarView() const { return avatarView_; }
    [[nodiscard]] bool serviceScreen() const { return serviceScreen_; }
    /// Visits since the start: rises when somebody is dressed for the first time after idle.
    [[nodiscard]] std::uint64_t visits() const { return visits_; }

  private:
    void enter(SessionState state, hal::TimePoint time);
    void startAnew();
    void press(const hal::ButtonEvent& event);
    void changeView() { avatarView_ = !avatarView_; }
    void understand(const fitting::GestureEvent& gesture);
    void obey(const RemoteCommand& command);
    void step(std::ptrdiff_t by);
    bool advance(const SessionInput& input);

    SessionOptions options_;
    SessionState state_ = SessionState::idle;
    hal::TimePoint now_{};
    hal::TimePoint entered_{};      ///< When the state began.
    hal::TimePoint lastSeen_{};     ///< When the person was last in the zone.
    hal::TimePoint jointsSince_{};  ///< Since when the joints have been seen without a gap.
    bool jointsSeen_ = false;
    std::uint32_t userId_ = 0;  ///< Whose visit it is.
    std::size_t outfit_ = 0;
    bool avatarView_ = false;
    bool serviceScreen_ = false;
    bool newcomer_ = true;  ///< Not yet dressed in this visit.
    std::uint64_t visits_ = 0;
};

}  // namespace cheval::daemon

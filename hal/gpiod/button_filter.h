// From the edges of one line to presses: debounce, long press, stuck. Pure; times are the edges' own.
#pragma once

#include <optional>

#include "hal/clock.h"
#include "hal/event.h"

namespace cheval::hal {

struct ButtonTimes {
    Duration debounce = std::chrono::milliseconds(20);  ///< A level that lasts less is contact bounce.
    Duration longPress = std::chrono::milliseconds(800);
    Duration stuck = std::chrono::seconds(30);  ///< Nobody presses for so long.
};

/// Thread-bound.
class ButtonFilter {
  public:
    explicit ButtonFilter(const ButtonTimes& times) : times_(times) {}

    /// The line is read from here on, at this level. Held from before: no press, and its release is none.
    void begin(bool active, TimePoint now);
    /// What `time`, later than all before, brings about by itself: call until it says nothing, before each edge with
    /// the edge's time and at the end with the present.
    std::optional<ButtonEvent> advance(TimePoint time);
    /// An edge; advance(time) has been emptied before. One that is told late counts from when it was told.
    void edge(bool active, TimePoint time);
    /// The line cannot be read any more: the release of what was told as pressed. Goes on with begin().
    std::optional<ButtonEvent> end(TimePoint now);

    [[nodiscard]] bool stuck() const { return stuck_; }

  private:
    ButtonTimes times_;
    bool accepted_ = false;  ///< The debounced level.
    bool raw_ = false;
    TimePoint changed_{};  ///< When the raw level last changed.
    TimePoint pressed_{};
    TimePoint advanced_{};   ///< How far time has come.
    bool reported_ = false;  ///< The press was told, so that its release is.
    bool longReported_ = false;
    bool stuck_ = false;
};

}  // namespace cheval::hal

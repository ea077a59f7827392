// The one way to buttons: GPIO lines, the preview page or a script.
#pragma once

#include <cstddef>
#include <span>

#include "hal/event.h"
#include "hal/expected.h"

namespace cheval::hal {

/// A set of buttons. Thread-bound. Never waits.
class Buttons {
  public:
    virtual ~Buttons() = default;
    Buttons(const Buttons&) = delete;
    Buttons& operator=(const Buttons&) = delete;

    /// Moves what happened since the last call into `events`, oldest first, and returns how many. What does not fit is
    /// delivered by the next call, up to a bound of 64 waiting events; beyond it the oldest are dropped and counted.
    Expected<std::size_t> poll(std::span<ButtonEvent> events) { return doPoll(events); }
    /// Events dropped since the start because nobody polled.
    [[nodiscard]] virtual std::uint64_t dropped() const { return 0; }

  protected:
    Buttons() = default;
    virtual Expected<std::size_t> doPoll(std::span<ButtonEvent> events) = 0;
};

}  // namespace cheval::hal

// What a person presses.
#pragma once

#include <cstdint>

#include "hal/clock.h"

namespace cheval::hal {

enum class Button : std::uint8_t { next, previous, view, service, wake };
enum class ButtonAction : std::uint8_t { pressed, longPressed, released };

struct ButtonEvent {
    Button button = Button::next;
    ButtonAction action = ButtonAction::pressed;
    TimePoint time{};
};

}  // namespace cheval::hal

// Says on the screen what the session is about.
#pragma once

#include <string>
#include <string_view>

#include "daemon/session.h"
#include "daemon/wardrobe.h"
#include "fitting/advice.h"
#include "fitting/body.h"
#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "hal/expected.h"
#include "hal/frame.h"
#include "render/hud_state.h"
#include "render/mirror_mapping.h"

namespace cheval::daemon {

/// What the head-up display is made from; all borrowed.
struct HudSources {
    const Session* session = nullptr;
    const Wardrobe* wardrobe = nullptr;
    const fitting::Hands* hands = nullptr;
    const fitting::SensorPlacement* placement = nullptr;
    const fitting::SizeAdvice* advice = nullptr;          ///< Null: none is told.
    const fitting::Measurements* measurements = nullptr;  ///< For the service screen alone; null: none are made.
    hal::Intrinsics intrinsics;
    const render::MirrorMapping* mapping = nullptr;  ///< From the sensor's picture to the display.
    int displayWidth = 1080;
    int displayHeight = 1920;
    std::string_view fault;   ///< Why there are no frames; empty: there are, or people need not be told.
    bool away = false;        ///< For a moment there are none.
    std::string_view notice;  ///< What a technician should know besides (refused settings, refused garments).
    bool showNotice = false;  ///< Opens the service screen while nobody is being dressed.
};

/// "file: cause. Mend: …" for a service screen, with the file's name alone: its folders would crowd out the mend.
std::string serviceText(const Error& error);

/// The carousel's names; needed once, and again when the wardrobe changes.
void writeCarousel(const Wardrobe& wardrobe, render::HudState& hud);
/// Everything else, each frame. Takes no heap memory. Lengths and girths go onto the service screen while a technician
/// has it open, and nowhere else.
void writeHud(const HudSources& sources, render::HudState& hud);

}  // namespace cheval::daemon

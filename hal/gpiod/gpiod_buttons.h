// Push buttons on GPIO lines.
#pragma once

#include <memory>
#include <vector>

#include "hal/buttons.h"
#include "hal/gpiod/button_filter.h"
#include "hal/gpiod/line_provider.h"

namespace cheval::hal {

struct ButtonWiring {
    Button button = Button::next;
    LineWiring line;
};

struct GpiodButtonsOptions {
    std::vector<ButtonWiring> wirings;
    ButtonTimes times;
    Duration firstPause = std::chrono::milliseconds(500);  ///< Before lines that failed are asked for again; doubles …
    Duration longestPause = std::chrono::seconds(30);      ///< … up to this.
};

/// Lines are requested by the first poll, and each again after a failure: a line that is absent, busy or lost is an
/// error of poll() for as long as it lasts, the others work on, and so does the mirror. `clock` is on the time line of
/// the provider's edges (SteadyClock for the kernel's). A button that is stuck is an error too.
class GpiodButtons : public Buttons {
  public:
    /// True while this button has been held longer than anybody would.
    [[nodiscard]] virtual bool stuck(Button button) const = 0;
};

std::unique_ptr<GpiodButtons> makeGpiodButtons(const GpiodButtonsOptions& options,
                                               std::unique_ptr<LineProvider> provider, const Clock& clock);

}  // namespace cheval::hal

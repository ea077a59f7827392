// A GPIO line that switches a sensor's power.
#pragma once

#include <memory>

#include "hal/clock.h"
#include "hal/expected.h"
#include "hal/gpiod/line_provider.h"

namespace cheval::hal {

struct PowerLineOptions {
    LineWiring line;                         ///< Active: the sensor has power.
    Duration off = std::chrono::seconds(3);  ///< Long enough for its capacitors to empty.
};

/// Thread-bound. Holds the line, active, from the first success of hold() on.
class PowerLine {
  public:
    PowerLine(PowerLineOptions options, std::unique_ptr<LineProvider> provider, const Clock& clock);
    ~PowerLine();
    PowerLine(const PowerLine&) = delete;
    PowerLine& operator=(const PowerLine&) = delete;

    /// Takes the line and sees to it that the sensor has power. Errors: as LineProvider::output.
    Expected<void> hold();
    /// Off, a pause, on again; never waits. ErrorCode::timedOut: it is at work; call again until it says something
    /// else.
    Expected<void> cycle();

  private:
    Expected<void> drive(bool active);

    PowerLineOptions options_;
    std::unique_ptr<LineProvider> provider_;
    const Clock& clock_;
    std::unique_ptr<OutputLine> line_;
    bool off_ = false;
    TimePoint onAt_{};
};

}  // namespace cheval::hal

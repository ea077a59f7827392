// sensor.json: what a technician wrote down of the sensor that made a recording.
#pragma once

#include <string>
#include <string_view>

#include "hal/expected.h"
#include "hal/frame.h"

namespace cheval::hal {

/// The content of sensor.json.
struct SensorDescription {
    Intrinsics intrinsics;        ///< `width`, `height`, `fx`, `fy`, `cx`, `cy`: required.
    double depthUnitMm = 1.0;     ///< `depth_unit_mm`: millimetres of one unit in the pictures.
    double framesPerSecond = 30;  ///< `fps`.
    Mount mount;                  ///< `mount`: `height_mm`, `tilt_deg`, `roll_deg`; known when it is there.
    bool independent = false;     ///< `independent`: stills that do not follow each other in time.
};

/// Parses and checks the text of a sensor.json; `file` is its name for messages. An unknown key is an error, since a
/// misspelt one would silently fall back to its default. Errors: invalidInput, with file, line (of a syntax error) and
/// key.
Expected<SensorDescription> parseSensorJson(std::string_view text, const std::string& file);

/// The text of a sensor.json that parses back to `description`.
std::string formatSensorJson(const SensorDescription& description);

}  // namespace cheval::hal

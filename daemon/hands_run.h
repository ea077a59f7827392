// `chevalctl hands`: what the reading of hands makes of pictures of one hand.
#pragma once

#include <string>
#include <vector>

#include "fitting/hands.h"
#include "hal/expected.h"

namespace cheval::daemon {

struct HandReading {
    std::string name;  ///< File of the picture, without the folder.
    fitting::HandState state = fitting::HandState::unknown;
    float confidence = 0.0F;  ///< 0…1.
    int fingers = 0;          ///< Stretched ones.
};

struct HandsReport {
    std::vector<HandReading> readings;  ///< One a picture, in the pictures' order.
    std::vector<std::string> warnings;
};

/// Reads every picture of a folder with a sensor.json (as `chevalctl replay` takes it) once, each for itself. Refuses a
/// folder that is no recording.
Expected<HandsReport> readHands(const std::string& folder);

}  // namespace cheval::daemon

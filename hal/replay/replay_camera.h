// Plays a folder of 16-bit PNGs in natural order with its sensor.json, optionally colour, as a camera.
#pragma once

#include <memory>
#include <string>

#include "hal/clock.h"
#include "hal/depth_camera.h"
#include "hal/expected.h"

namespace cheval::hal {

struct ReplayOptions {
    std::string folder;
    int stillRepeats = 45;  ///< How often each still of an `independent` set is shown, so that averages converge.
    bool loop = false;      ///< Start again at the end instead of ending.
};

/// Checks the folder (sensor.json, sizes, bit depth of the first picture) and makes the camera. Frame times follow
/// sensor.json's fps on `clock`. Refusals carry cause, mend, why and the file. A gap in the numbers is a warning, kept
/// for warnings().
Expected<std::unique_ptr<DepthCamera>> makeReplayCamera(const ReplayOptions& options, Clock& clock);

}  // namespace cheval::hal

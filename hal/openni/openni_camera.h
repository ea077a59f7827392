// A depth sensor, or a recording of one, through OpenNI2. Its calls may hang or crash, which is why only the sensor
// process links this.
#pragma once

#include <memory>
#include <string>

#include "hal/depth_camera.h"

namespace cheval::hal {

struct OpenNiOptions {
    std::string device;     ///< OpenNI2's URI of the device; empty: the first that there is.
    std::string recording;  ///< An .oni file, played in place of a device.
    bool colour = true;     ///< Ask for a colour picture registered to depth, where the device has one.
};

/// Thread-bound, one a process: OpenNI2 is global.
class OpenNiCamera : public DepthCamera {
  public:
    /// What could not be had and was done without, in words: colour, registration, the full picture. Of the last
    /// open().
    [[nodiscard]] virtual const std::string& compromises() const = 0;
};

/// Live: the profile ladder takes the first mode that the device offers: 640×480 at 30 Hz and above, at 15 Hz and
/// above, then 320×240, each pixel doubled both ways. Depth in millimetres or tenths of them. Mirroring and cropping
/// are off. Capture times are the device's own, moved onto CLOCK_MONOTONIC by the least delay seen.
/// A recording is read frame by frame, as fast as it is asked for: captureTime counts from its first frame. It ends
/// after as many depth frames as it says it has, or where its times begin again.
Expected<std::unique_ptr<OpenNiCamera>> makeOpenNiCamera(const OpenNiOptions& options);

}  // namespace cheval::hal

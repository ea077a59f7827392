// Plays a folder of 16-bit PNGs in natural order with its sensor.json, optionally colour, as a camera. The folder's
// format is in this folder's README.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "hal/clock.h"
#include "hal/depth_camera.h"
#include "hal/expected.h"

namespace cheval::hal {

struct ReplayOptions {
    std::string folder;
    int stillRepeats = 45;  ///< How often each still of an `independent` set is shown, so that averages converge.
    bool loop = false;      ///< Start again at the end instead of ending.
};

/// A recording as a camera. What it plays depends on the folder alone, never on how fast it is read: no frame is
/// dropped. On a virtual clock it plays as fast as it is read; on a steady clock at its own pace, and a reader that is
/// late gets the frames that are due one after another without waiting, each with the time at which it was due.
/// Thread-bound, but for close().
class ReplayCamera : public DepthCamera {
  public:
    /// Depth pictures in the folder, the unreadable ones included.
    [[nodiscard]] virtual std::size_t pictureCount() const = 0;
    /// File name (without the folder) of a DepthFrame's sourceIndex.
    [[nodiscard]] virtual const std::string& pictureName(std::size_t sourceIndex) const = 0;
    /// What is odd but does not stop the replay, each a sentence for people: gaps in the numbers, colour that is
    /// missing, and, as playing meets them, pictures left out because they cannot be used. At most 64 are kept; a last
    /// one counts the rest.
    [[nodiscard]] virtual std::vector<std::string> warnings() const = 0;
};

/// Checks the folder (sensor.json, size and bit depth of the first picture) and makes the camera. Frame times follow
/// sensor.json's fps on `clock`, which must outlive the camera; the first frame is due at open(). A gap in the numbers
/// is a gap in time and in DepthFrame::sequence, and a warning. Repetitions of an independent still come 30 times a
/// second, whatever fps says, as a still person before a sensor would. A picture that cannot be used (unreadable, 8
/// bits, another size) is left out with a warning and counts as a lost frame; when no picture of a whole pass can be
/// used, the camera is lost. Refusals carry cause, mend, why and the file.
Expected<std::unique_ptr<ReplayCamera>> makeReplayCamera(const ReplayOptions& options, Clock& clock);

}  // namespace cheval::hal

// A depth camera that lives in a process of its own, which may hang, leak or die without taking the mirror along.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

#include "hal/depth_camera.h"

namespace cheval::hal {

struct ProcessCameraOptions {
    std::string program;                   ///< cheval-sensor.
    std::vector<std::string> arguments;    ///< What it opens, as its --help says.
    std::vector<std::string> environment;  ///< "NAME=value", on top of this process's own.
    /// How long one open() waits. A sensor's firmware may need seconds: then open() answers timedOut, and the next call
    /// goes on waiting for the same opening.
    Duration openWait = std::chrono::seconds(15);
    bool loop = false;  ///< A recording starts again at its end.
};

/// The process is started by the first open() and stays over close() and open(); destruction ends it. A live sensor
/// needs a SteadyClock, on whose time line its capture times are; a recording (.oni) plays on any clock, without
/// losing a frame, at its own pace. A wait in progress ends within 20 ms of close().
class ProcessCamera : public DepthCamera {
  public:
    /// The sensor process; −1 while there is none.
    [[nodiscard]] virtual pid_t process() const = 0;
    /// How often it was started.
    [[nodiscard]] virtual std::uint64_t starts() const = 0;
    /// From the moment that the last frame was published there until it was lent here.
    [[nodiscard]] virtual Duration handOver() const = 0;
};

std::unique_ptr<ProcessCamera> makeProcessCamera(const ProcessCameraOptions& options, Clock& clock);

}  // namespace cheval::hal

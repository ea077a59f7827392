// The other end: what a sensor process does with its camera until chevald ends it, or is gone.
#pragma once

#include <functional>

#include "hal/depth_camera.h"
#include "hal/sensor_process/frame_ring.h"

namespace cheval::hal {

/// Where chevald puts what it shares with the process.
constexpr int kRingDescriptor = 3;
constexpr int kControlDescriptor = 4;
constexpr int kFramesDescriptor = 5;

struct SensorServerOptions {
    Descriptor ring{kRingDescriptor};
    Descriptor control{kControlDescriptor};
    Descriptor frames{kFramesDescriptor};
    bool recording = false;         ///< Frames are sent one by one, as they are asked for.
    std::function<bool()> arrived;  ///< True once for each device that was plugged in; may be empty.
};

/// Ends this process as soon as the other side of `control` is gone, even if every other thread is in a call that never
/// returns. To be called before the sensor's library is started.
void endWithTheOtherSide(int control = kControlDescriptor);

/// Serves `camera` until `quit` comes or the other side is gone. Errors: a ring of another release.
Expected<void> serveSensor(DepthCamera& camera, SensorServerOptions options);

}  // namespace cheval::hal

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

/// Serves `camera` until `quit` comes or the other side is gone. Should the camera never return from a call, a second
/// thread still notices that the other side is gone, and ends the process. Errors: a ring of another release.
Expected<void> serveSensor(DepthCamera& camera, SensorServerOptions options);

}  // namespace cheval::hal

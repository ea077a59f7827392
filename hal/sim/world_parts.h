// What the simulated world is made of, for the back ends of this folder.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>

#include "hal/sim/room.h"
#include "hal/sim/scene.h"
#include "hal/sim/view.h"
#include "hal/sim/world.h"

namespace cheval::hal::sim {

struct World::Parts {
    explicit Parts(const WorldOptions& theOptions);

    const WorldOptions options;
    const View view;
    const Room room;
    std::atomic<CameraFault> fault{CameraFault::none};
    std::atomic<Duration::rep> lateness{0};

    std::mutex zeroMutex;
    std::optional<TimePoint> zero;

    std::mutex sceneMutex;
    std::unique_ptr<Scene> scene;  ///< Made when renderFrame is first called.
};

}  // namespace cheval::hal::sim

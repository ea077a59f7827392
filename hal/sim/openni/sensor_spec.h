// What the simulated OpenNI2 sensor serves, as one line of text.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "hal/depth_camera.h"
#include "hal/expected.h"
#include "hal/sim/world.h"

namespace cheval::hal::sim {

/// "sim:KEY=VALUE,…" with seed, visit_s, pause_s, fps, noise, colour, start_ns, preload; or "folder:PATH" with
/// ",preload=N" at its end.
struct SensorSpec {
    WorldOptions world;
    std::string folder;         ///< Empty: the simulated world.
    std::int64_t startNs = 0;   ///< CLOCK_MONOTONIC of the world's zero; 0: when the first camera opens.
    std::uint64_t preload = 0;  ///< Pictures made once, at the start, and played over and over; 0: each when it is due.
};

/// Errors: invalidInput, with the key at fault.
Expected<SensorSpec> parseSensorSpec(std::string_view text);

/// The camera that a spec describes, on `clock`, which runs in real time. `world` is made by the first call and kept
/// over the next ones, so that a sensor that is reopened sees the same shopper go on. Errors: as makeReplayCamera.
Expected<std::unique_ptr<DepthCamera>> makeSpecCamera(const SensorSpec& spec, std::shared_ptr<World>& world,
                                                      Clock& clock);

}  // namespace cheval::hal::sim

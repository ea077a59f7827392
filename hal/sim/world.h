// The simulated kiosk: one world with a scripted shopper, a structured-light sensor and buttons (DESIGN §6). Its people
// are capsules and lofted limbs of its own, never the model that fitting/body fits.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "hal/buttons.h"
#include "hal/depth_camera.h"

namespace cheval::hal::sim {

/// One scripted visit: walk in, A-pose, turns, hands open and closed, swipes, walk out. Repeats for ever with other
/// shoppers.
struct WorldOptions {
    std::uint32_t seed = 1;  ///< Shoppers' bodies, clothes and noise.
    double framesPerSecond = 30.0;
    bool colour = true;
    bool sensorNoise = true;
    Mount mount{.heightMm = 1250.0F, .tiltDeg = -4.0F, .rollDeg = 0.0F, .known = true};
    double visitSeconds = 20.0;  ///< Walk-in to walk-out; the script's parts scale with it.
    double pauseSeconds = 4.0;   ///< Nobody there, between visits.
};

/// What is really there; for tests and benchmarks only.
struct WorldTruth {
    bool present = false;        ///< The shopper is in the room and wholly in view.
    fitting::Skeleton skeleton;  ///< Mirror frame.
    std::array<fitting::HandState, fitting::kSideCount> hands{};
    float statureMetres = 0.0F;
    std::uint32_t visit = 0;
};

class World;

/// The world's depth camera. Frames come at the world's rate on `clock`.
std::unique_ptr<DepthCamera> makeSimulatedCamera(std::shared_ptr<World> world, Clock& clock);
/// The world's buttons, pressed by its script: "next" twice a visit.
std::unique_ptr<Buttons> makeSimulatedButtons(std::shared_ptr<World> world, Clock& clock);
std::shared_ptr<World> makeWorld(const WorldOptions& options);
/// The truth at a time of the world's own time line (frame n is at n / framesPerSecond).
WorldTruth truthAt(const World& world, double worldSeconds);

}  // namespace cheval::hal::sim

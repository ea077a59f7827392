// The simulated kiosk: one world with a scripted shopper, a structured-light sensor and buttons. Its people
// are capsules and lofted limbs of its own, never the model that fitting/body fits.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "hal/buttons.h"
#include "hal/depth_camera.h"
#include "hal/image.h"

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

/// What goes wrong with the camera, on demand.
enum class CameraFault : std::uint8_t {
    none,
    lost,     ///< The device is gone: every wait says so, and opening fails.
    stalled,  ///< It is there but sends nothing: waits run into their time limit.
    garbage,  ///< Frames come, filled with noise.
    late,     ///< Each frame comes World::lateness() after it was due.
};

/// One world, shared by its camera and its buttons. Thread-safe: what it is made of never changes, faults are atomic,
/// and rendering through it is serialised.
class World {
  public:
    explicit World(const WorldOptions& options);
    ~World();
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    [[nodiscard]] const WorldOptions& options() const;
    /// Time of frame n in seconds of the world's own time line.
    [[nodiscard]] double timeOf(std::uint64_t frame) const;

    /// The world's time runs from here on. The first caller decides; the camera's first open() and the buttons' first
    /// poll() call it. Returns the clock's time of the world's zero.
    TimePoint startAt(TimePoint now);

    void setFault(CameraFault fault);
    [[nodiscard]] CameraFault fault() const;
    void setLateness(Duration lateness);
    [[nodiscard]] Duration lateness() const;

    struct Parts;  ///< What the back ends of this folder share.
    [[nodiscard]] const Parts& parts() const { return *parts_; }

  private:
    friend void renderFrame(World& world, std::uint64_t frame, Image<std::uint16_t>& depth, Image<Rgb8>& colour);
    std::unique_ptr<Parts> parts_;
};

/// The world's depth camera. Frame n is due n / framesPerSecond after the world's zero; sequence and sourceIndex are n.
/// On a clock that runs by itself a late caller skips frames; on VirtualClock none is skipped while the camera is open
/// and sound. A camera that is opened again goes on at the world's present time.
std::unique_ptr<DepthCamera> makeSimulatedCamera(std::shared_ptr<World> world, Clock& clock);
/// The world's buttons, pressed by its script: "next" twice a visit.
std::unique_ptr<Buttons> makeSimulatedButtons(std::shared_ptr<World> world, Clock& clock);
std::shared_ptr<World> makeWorld(const WorldOptions& options);
/// The truth at a time of the world's own time line (frame n is at n / framesPerSecond). A hand is open or closed while
/// it is raised with its palm or back towards the sensor, else unknown.
WorldTruth truthAt(const World& world, double worldSeconds);
/// Renders frame n without a camera, the same bytes that the camera delivers. The images are resized to 640 × 480;
/// `colour` is left empty where the world has none. Takes no memory when they have that size already.
void renderFrame(World& world, std::uint64_t frame, Image<std::uint16_t>& depth, Image<Rgb8>& colour);

}  // namespace cheval::hal::sim

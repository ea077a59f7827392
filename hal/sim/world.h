// The simulated kiosk: one world with scripted people, a structured-light sensor and buttons. Its people are lofted
// trunks and limbs of its own, never the model that fitting/body fits.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "hal/buttons.h"
#include "hal/depth_camera.h"
#include "hal/image.h"
#include "hal/sim/clothing.h"
#include "hal/sim/tape.h"

namespace cheval::hal::sim {

/// What happens in each visit. All but `visit` are played in real seconds and vary with the seed and the visit's
/// number: who, where, when, which hand, how far and how fast.
enum class Script : std::uint8_t {
    visit,      ///< Walk in, A-pose, turns, hands open and closed, swipes, walk out; scales with the visit's length.
    resting,    ///< Walks up to about 2.5 m and stands like a post.
    pacing,     ///< Walks to and fro across the picture at 1 m/s, facing the glass or where they go.
    gestures,   ///< Swipes and grabs with either hand, and the hand's ways between them.
    fidgeting,  ///< No gesture meant: steps, turns, tugs at clothes, scratches, talks with the hands, folds the arms.
    passersBy,  ///< Others pass before and behind the shopper and come to stand beside them.
    occlusion,  ///< Somebody stops between glass and shopper for a second, hiding them wholly, and goes on.
    mannequin,  ///< A shop mannequin stands in the zone all the time; a shopper comes and goes.
    dog,        ///< A dog walks through; nobody else is there.
    measuring,  ///< Somebody of known girths stands, takes the A-pose, turns to either side and once round; 21 s.
};
inline constexpr std::size_t kScriptCount = 10;

/// A row of visits that goes on for ever, each with other people.
struct WorldOptions {
    std::uint32_t seed = 1;  ///< Shoppers' bodies, clothes and noise.
    double framesPerSecond = 30.0;
    bool colour = true;
    bool sensorNoise = true;
    Mount mount{.heightMm = 1250.0F, .tiltDeg = -4.0F, .rollDeg = 0.0F, .known = true};
    Script script = Script::visit;
    double visitSeconds = 20.0;  ///< Walk-in to walk-out.
    double pauseSeconds = 4.0;   ///< Nobody there, between visits.
    float noiseScale = 1.0F;     ///< Of the sensor's noise and of how often it reads nothing.
    // Of Script::measuring.
    Clothing clothing = Clothing::tight;
    bool everybody = false;  ///< Children and wheelchair users come too.
};

enum class FigureKind : std::uint8_t { shopper, mannequin, dog };
/// Three people, a mannequin and a dog.
inline constexpr std::size_t kMaximumFigures = 5;

/// One of those who appear in a visit.
struct FigureTruth {
    FigureKind kind = FigureKind::shopper;
    bool inRoom = false;
    bool whollyInView = false;   ///< In the room, and no part of them beyond the picture's edge.
    fitting::Skeleton skeleton;  ///< Mirror frame; of somebody in the room who is not a dog, else nobody's.
    std::array<fitting::HandState, fitting::kSideCount> hands{};
    float statureMetres = 0.0F;  ///< Floor to crown of who stands, soles included; a dog's shoulder.
    bool wheelchair = false;
    /// The bare body's, of who is no dog; all zero for a dog.
    TrueMeasurements measurements{};
};

/// What is really there; for tests and benchmarks only.
struct WorldTruth {
    bool present = false;        ///< The shopper is in the room and wholly in view.
    fitting::Skeleton skeleton;  ///< The shopper's, mirror frame.
    std::array<fitting::HandState, fitting::kSideCount> hands{};
    float statureMetres = 0.0F;
    std::uint32_t visit = 0;
    /// All who appear in the visit, in an order that never changes within it; the shopper, if there is one, first.
    std::array<FigureTruth, kMaximumFigures> figures{};
    std::size_t figureCount = 0;
};

/// What a shopper means by moving a hand.
enum class MeantKind : std::uint8_t {
    swipe,       ///< The stroke itself.
    grab,        ///< A raised hand, as long as it is closed.
    transition,  ///< The hand goes to or from a gesture: no gesture, but not to be told from one by its path.
};
struct MeantGesture {
    MeantKind kind = MeantKind::swipe;
    fitting::Side hand = fitting::Side::right;
    fitting::SwipeDirection direction = fitting::SwipeDirection::left;  ///< Swipes only; as the shopper sees it.
    double start = 0.0, end = 0.0;                                      ///< Seconds of the world's time line.
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
/// The world's buttons, pressed in Script::visit only: "next" twice a visit.
std::unique_ptr<Buttons> makeSimulatedButtons(std::shared_ptr<World> world, Clock& clock);
std::shared_ptr<World> makeWorld(const WorldOptions& options);
/// The truth at a time of the world's own time line (frame n is at n / framesPerSecond). A hand is open or closed while
/// it is raised with its palm or back towards the sensor, else unknown.
WorldTruth truthAt(const World& world, double worldSeconds);
/// The gestures and transitions that overlap with a span of the world's time line, by their starts, as many as
/// `gestures` holds. Returns how many those are. The shopper's: nobody else means any.
std::size_t gesturesOf(const World& world, double fromSeconds, double toSeconds, std::span<MeantGesture> gestures);
/// Renders frame n without a camera, the same bytes that the camera delivers. The images are resized to 640 × 480;
/// `colour` is left empty where the world has none. Takes no memory when they have that size already.
void renderFrame(World& world, std::uint64_t frame, Image<std::uint16_t>& depth, Image<Rgb8>& colour);

/// The scene behind the readings of the frame that renderFrame drew last: what no sensor could tell.
struct ExactView {
    ImageView<const float> depth;         ///< Millimetres along z; 0 where there is nothing.
    ImageView<const std::uint8_t> owner;  ///< 0: the room; else 1 + the place in WorldTruth::figures.
};
/// Empty before the first renderFrame; valid until the next.
ExactView exactView(const World& world);

}  // namespace cheval::hal::sim

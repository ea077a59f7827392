// Writes a part down, one thing after another.
#pragma once

#include <optional>

#include "hal/sim/hash.h"
#include "hal/sim/script.h"

namespace cheval::hal::sim {

/// Further aside than any picture reaches at the depths of the room.
inline constexpr float kOutOfView = 2.6F;
/// Seconds in which a pacing person's speed rises, and in which it falls.
inline constexpr float kPacingRamp = 0.3F;

/// Draws people for a script. Children and wheelchair users are among shoppers; `grownUp` leaves both out.
Shopper drawPerson(Draw& draw, bool grownUp = false);
/// Adds somebody to the cast.
Performer& addPerformer(Cast& cast, FigureKind kind, const Shopper& shopper);

/// Thread-bound, lives while a script is written.
class PartWriter {
  public:
    PartWriter(Performer& performer, Draw& draw);

    [[nodiscard]] const Rig& rig() const { return rig_; }
    [[nodiscard]] const Place& place() const { return place_; }
    [[nodiscard]] bool seated() const { return performer_.shopper.wheelchair; }
    /// The next walk begins there: at the visit's beginning, or out of view.
    void beginAt(const Place& place);

    /// Each returns when it is done. Sides and yaws: `side` is the sign of the mirror frame's x.
    double walkIn(double start, float side, const Eigen::Vector2f& spot);
    /// Turns away and leaves the picture.
    double walkOut(double start, float side);
    double turn(double start, double seconds, float yaw);
    /// From stand to stand; looks where it goes, or keeps facing `facing`.
    double pace(double start, const Eigen::Vector2f& to, float metresPerSecond, std::optional<float> facing);
    /// Straight through the picture at `depth`, from `side` to the other.
    double passThrough(double start, float side, float depth, float metresPerSecond);

    double move(fitting::Side side, double start, double seconds, const ArmAttitude& pose);
    double move(fitting::Side side, double start, double seconds, const Reach& reach);
    /// Back to where the arm hangs, or lies on the lap.
    double rest(fitting::Side side, double start, double seconds);
    void glance(double start, double end, float pitch, float yaw);
    /// Whether there is room for `moves` more of one arm.
    [[nodiscard]] bool hasRoom(std::size_t moves) const;

  private:
    [[nodiscard]] int stepsFor(float metres, bool sideways) const;

    Performer& performer_;
    Draw& draw_;
    Rig rig_;
    Place place_;
};

}  // namespace cheval::hal::sim

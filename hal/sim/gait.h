// How people walk, turn on the spot and stand.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "hal/sim/rig.h"

namespace cheval::hal::sim {

/// A spot on the floor and the way one faces there.
struct Place {
    Eigen::Vector2f position = Eigen::Vector2f::Zero();  ///< x and z of the mirror frame.
    float yaw = 0.0F;                                    ///< As Posture::yaw.
};

enum class WalkKind : std::uint8_t {
    arriving,  ///< Begins in full stride and ends in a stand.
    leaving,   ///< Begins with a stand and ends in full stride.
    pacing,    ///< From stand to stand, at an even speed between.
};

/// A walk along a cubic curve; it goes on straight beyond its ends.
struct Walk {
    std::array<Eigen::Vector2f, 4> control;  ///< x and z of the mirror frame.
    double start = 0.0, end = 1.0;           ///< Seconds.
    int steps = 4;
    WalkKind kind = WalkKind::arriving;
    float ramp = 0.2F;  ///< Pacing: the share of the time in which speed rises, and that in which it falls.
    std::optional<float> facing = std::nullopt;  ///< The yaw kept throughout; else one looks where one walks.

    /// Share of the way behind one at `time`.
    [[nodiscard]] float progress(double time) const;
    /// Steps made by `time`.
    [[nodiscard]] float gait(double time) const;
    /// Speed as a share of full walking speed, for what swings along.
    [[nodiscard]] float vigour(double time) const;
    [[nodiscard]] Place place(float share) const;
    /// Where step `step`'s standing foot is set down: below the body in the middle of that step.
    [[nodiscard]] Place plant(int step) const;

  private:
    /// Progress at the share `u` of the walk's time.
    [[nodiscard]] float travelled(float u) const;
};

/// Turning on the spot in small steps: the body eases over, first one foot follows, then the other.
struct Turn {
    double start = 0.0, end = 0.0;  ///< Seconds.
    float from = 0.0F, to = 0.0F;   ///< Yaw.
};

/// What a body's legs are like to walk with, metres.
struct Gait {
    float legLength, ankleHeight, stanceHalfWidth, ankleToBall;
};
Gait gaitOf(const Rig& rig);

/// Each fills or adds to its part of `posture` at `time`: the feet of a walk, all the rest of it, and a stand at `spot`
/// that began with the yaw `facing` and has these turns, ordered by their starts.
void walkFeet(const Walk& walk, const Gait& gait, double time, Posture& posture);
void walkBody(const Walk& walk, const Gait& gait, double time, Posture& posture);
void stand(const Gait& gait, const Eigen::Vector2f& spot, float facing, std::span<const Turn> turns, double time,
           Posture& posture);
/// Nobody stands like a post: slow sway, breath and glances, times `strength`.
void sway(double time, float strength, Posture& posture);

}  // namespace cheval::hal::sim

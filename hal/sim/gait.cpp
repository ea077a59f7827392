#include "hal/sim/gait.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/sim/arms.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using fitting::Side;

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kSteady = 0.6F;

/// Integral of a speed that is constant up to kSteady and then falls to 0 as a cosine; 0 at 0, 1 at 1.
float slowing(float u) {
    constexpr float kRest = 1.0F - kSteady;
    const float travelled =
        u <= kSteady ? u
                     : kSteady + 0.5F * ((std::min(u, 1.0F) - kSteady) +
                                         kRest / kPi * std::sin(kPi * (std::min(u, 1.0F) - kSteady) / kRest));
    return travelled / (kSteady + 0.5F * kRest);
}

/// Integral of a speed that rises evenly up to `ramp`, holds, and falls as evenly; 0 at 0, 1 at 1.
float evenly(float u, float ramp) {
    u = std::clamp(u, 0.0F, 1.0F);
    const float scale = 1.0F / (1.0F - ramp);
    if (u < ramp) return 0.5F * scale * u * u / ramp;
    if (u > 1.0F - ramp) return 1.0F - 0.5F * scale * (1.0F - u) * (1.0F - u) / ramp;
    return scale * (u - 0.5F * ramp);
}

Vector3f onFloor(const Vector2f& position, float height) {
    return {position.x(), height, position.y()};
}

Vector3f aside(const Place& place, float offset, float height) {
    // Positive offsets lie to the shopper's left.
    const Vector3f left(-std::cos(place.yaw), 0.0F, std::sin(place.yaw));
    return onFloor(place.position, height) + offset * left;
}

/// Lifts the heel about the ball of the foot, or the toes about the heel.
FootAttitude pitched(FootAttitude foot, float pitch, const Gait& gait) {
    foot.pitch = pitch;
    const float arm = pitch > 0.0F ? gait.ankleToBall : 0.0F;
    const Vector3f forward(-std::sin(foot.yaw), 0.0F, -std::cos(foot.yaw));
    // The ankle turns about the pivot on the floor below `arm` metres ahead of it.
    const float c = std::cos(pitch);
    const float s = std::sin(pitch);
    const float ahead = -arm * c + gait.ankleHeight * s;
    const float up = arm * s + gait.ankleHeight * c;
    foot.ankle += (arm + ahead) * forward + Vector3f(0.0F, up - gait.ankleHeight, 0.0F);
    return foot;
}

/// Feet point a little outwards.
float toeOut(Side side) {
    return side == Side::left ? 0.13F : -0.13F;
}

float turnedFoot(const Turn& turn, double time, bool first) {
    const double middle = 0.5 * (turn.start + turn.end);
    return first ? ease(turn.start, middle, time) : ease(middle, turn.end, time);
}

}  // namespace

float Walk::travelled(float u) const {
    switch (kind) {
        case WalkKind::arriving:
            return slowing(u);
        case WalkKind::leaving:
            return 1.0F - slowing(1.0F - u);
        case WalkKind::pacing:
            break;
    }
    return evenly(u, ramp);
}

float Walk::progress(double time) const {
    return travelled(static_cast<float>((time - start) / (end - start)));
}

float Walk::gait(double time) const {
    return static_cast<float>((time - start) / (end - start)) * static_cast<float>(steps);
}

float Walk::vigour(double time) const {
    const float u = static_cast<float>((time - start) / (end - start));
    if (kind == WalkKind::pacing) return ease(std::min(u, 1.0F - u) / ramp);
    const float rest = kind == WalkKind::arriving ? (1.0F - u) / (1.0F - kSteady) : u / (1.0F - kSteady);
    return ease(rest);
}

Place Walk::place(float share) const {
    const float t = std::clamp(share, 0.0F, 1.0F);
    const float s = 1.0F - t;
    const Vector2f tangent = 3.0F * (s * s * (control[1] - control[0]) + 2.0F * s * t * (control[2] - control[1]) +
                                     t * t * (control[3] - control[2]));
    const Vector2f point =
        s * s * s * control[0] + 3.0F * s * s * t * control[1] + 3.0F * s * t * t * control[2] + t * t * t * control[3];
    return {.position = point + (share - t) * tangent,
            .yaw = facing ? *facing : std::atan2(-tangent.x(), -tangent.y())};
}

Place Walk::plant(int step) const {
    if (kind != WalkKind::leaving && step >= steps - 1) return place(1.0F);
    if (kind != WalkKind::arriving && step <= 0) return place(0.0F);
    return place(travelled((static_cast<float>(step) + 0.5F) / static_cast<float>(steps)));
}

Gait gaitOf(const Rig& rig) {
    const Vector3f hip = rig.at(Side::left, SideBone::thigh);
    const Vector3f ankle = rig.at(Side::left, SideBone::foot);
    return {.legLength = hip.y() - ankle.y(),
            .ankleHeight = ankle.y(),
            .stanceHalfWidth = 1.12F * ankle.x(),
            .ankleToBall = 2.2F * ankle.y()};
}

void walkFeet(const Walk& walk, const Gait& gait, double time, Posture& posture) {
    const float phase = walk.gait(time);
    const int step = static_cast<int>(std::floor(phase));
    const float u = phase - static_cast<float>(step);
    const float vigour = walk.vigour(time);
    const bool leftStands = (step % 2 + 2) % 2 == 0;
    const std::size_t standing = fitting::index(leftStands ? Side::left : Side::right);
    const auto sideways = [&](std::size_t foot) {
        return gait.stanceHalfWidth * (foot == fitting::index(Side::left) ? 1.0F : -1.0F) * (1.0F - 0.3F * vigour);
    };
    const Place here = walk.plant(step);
    FootAttitude stand{.ankle = aside(here, sideways(standing), gait.ankleHeight),
                       .yaw = here.yaw + toeOut(leftStands ? Side::left : Side::right)};
    // The heel leaves the floor before the foot does.
    const auto strengthOf = [&](const Place& a, const Place& b) {
        return std::min(1.0F, (b.position - a.position).norm() / (0.9F * gait.legLength));
    };
    const float heelOff = 0.34F * vigour;
    const float heel = std::clamp((u - 0.55F) / 0.45F, 0.0F, 1.0F);
    posture.feet[standing] =
        pitched(stand, heelOff * strengthOf(here, walk.plant(step + 2)) * heel * heel * (3.0F - 2.0F * heel), gait);

    const Place from = walk.plant(step - 1);
    const Place to = walk.plant(step + 1);
    // Gentler than an ease from rest to rest: a swinging leg is a pendulum.
    const float through = std::clamp((u - 0.04F) / 0.92F, 0.0F, 1.0F);
    const float swing = through * through * (3.0F - 2.0F * through);
    const std::size_t swinging = 1 - standing;
    FootAttitude foot;
    foot.yaw = from.yaw + swing * (to.yaw - from.yaw) + toeOut(leftStands ? Side::right : Side::left);
    foot.ankle = (1.0F - swing) * aside(from, sideways(swinging), gait.ankleHeight) +
                 swing * aside(to, sideways(swinging), gait.ankleHeight);
    const float strength = strengthOf(from, to);
    const float pushOff = std::sin(kPi * std::clamp(2.2F * u, 0.0F, 1.0F));
    foot = pitched(foot, strength * (heelOff + 0.4F * pushOff) * (1.0F - swing), gait);
    foot.ankle.y() += gait.legLength * 0.075F * std::min(1.0F, 3.0F * strength) * std::sin(kPi * swing);
    posture.feet[swinging] = foot;
}

void walkBody(const Walk& walk, const Gait& gait, double time, Posture& posture) {
    const Place place = walk.place(walk.progress(time));
    const float vigour = walk.vigour(time);
    const float phase = walk.gait(time);
    const float stride = std::sin(kPi * phase);  // One period is two steps; zero as the feet pass.
    const float passing = std::cos(kPi * (phase - 0.5F));
    posture.yaw = place.yaw;
    posture.pelvis.x() = place.position.x();
    posture.pelvis.z() = place.position.y();
    // Lowest as the legs are farthest apart.
    posture.pelvis.y() -= gait.legLength * vigour * (0.032F - 0.014F * passing * passing);
    posture.pelvis += 0.018F * vigour * stride * Vector3f(-std::cos(place.yaw), 0.0F, std::sin(place.yaw));
    posture.pelvisRoll += 0.03F * vigour * stride;
    posture.chestRoll -= 0.03F * vigour * stride;
    posture.chestPitch += 0.05F * vigour;
    // Who steps sideways holds their arms.
    if (walk.facing) return;
    const float swing = 0.42F * vigour * std::cos(kPi * phase);
    posture.chestYaw += 0.12F * vigour * std::cos(kPi * phase);
    for (const Side side : {Side::left, Side::right}) {
        // At the start of an even step the right foot is behind, and the left arm with it.
        const float angle = side == Side::left ? -swing : swing;
        ArmAttitude& arm = posture.arms[fitting::index(side)];
        const Eigen::AngleAxisf upper(-angle, Vector3f::UnitX());
        const Eigen::AngleAxisf lower(-angle - 0.25F * vigour * (1.0F + std::sin(angle)), Vector3f::UnitX());
        arm.upper = upper * arm.upper;
        arm.forearm = lower * arm.forearm;
        arm.fingers = lower * arm.fingers;
        arm.palm = lower * arm.palm;
    }
}

void stand(const Gait& gait, const Vector2f& spot, float facing, std::span<const Turn> turns, double time,
           Posture& posture) {
    float yaw = facing;
    std::array<float, 2> footYaw = {facing, facing};
    std::array<float, 2> lift{};
    for (const Turn& turn : turns) {
        if (time <= turn.start) break;
        yaw = turn.from + (turn.to - turn.from) * ease(turn.start, turn.end, time);
        for (const Side side : {Side::left, Side::right}) {
            const std::size_t i = fitting::index(side);
            // The foot on the side that one turns to goes first.
            const bool first = (turn.to > turn.from) == (side == Side::left);
            const float share = turnedFoot(turn, time, first);
            footYaw[i] = turn.from + (turn.to - turn.from) * share;
            lift[i] = 4.0F * share * (1.0F - share);
        }
    }
    posture.yaw = yaw;
    posture.pelvis.x() = spot.x();
    posture.pelvis.z() = spot.y();
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t i = fitting::index(side);
        const float offset = gait.stanceHalfWidth * (side == Side::left ? 1.0F : -1.0F);
        const Place place{.position = spot, .yaw = footYaw[i]};
        posture.feet[i] = {.ankle = aside(place, offset, gait.ankleHeight + 0.03F * lift[i]),
                           .yaw = footYaw[i] + toeOut(side)};
    }
}

void sway(double time, float strength, Posture& posture) {
    const float t = static_cast<float>(time);
    posture.pelvis.x() += strength * (0.008F * std::sin(1.3F * t) + 0.004F * std::sin(2.9F * t + 1.0F));
    posture.pelvis.z() += strength * 0.005F * std::sin(1.7F * t + 2.0F);
    posture.chestRoll += strength * 0.012F * std::sin(1.3F * t + 0.4F);
    posture.chestPitch += strength * 0.008F * std::sin(1.55F * t);
    posture.chestYaw += strength * 0.02F * std::sin(0.9F * t + 0.7F);
    posture.headYaw += strength * 0.07F * std::sin(0.75F * t);
    posture.headPitch += strength * (0.03F + 0.025F * std::sin(1.1F * t + 0.5F));
    for (ArmAttitude& arm : posture.arms) {
        arm.upper += strength * 0.012F * Vector3f(std::sin(1.5F * t), 0.0F, std::cos(1.2F * t));
        arm.forearm += strength * 0.015F * Vector3f(std::sin(1.5F * t + 0.3F), 0.0F, std::cos(1.2F * t + 0.5F));
    }
}

}  // namespace cheval::hal::sim

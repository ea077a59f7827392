#include "hal/sim/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using fitting::Side;

constexpr float kPi = std::numbers::pi_v<float>;

/// Minimum-jerk ease: how people move a hand from rest to rest (Flash & Hogan, J. Neurosci. 5(7), 1985).
float ease(float u) {
    u = std::clamp(u, 0.0F, 1.0F);
    return u * u * u * (10.0F + u * (6.0F * u - 15.0F));
}
float ease(double from, double to, double time) {
    return ease(static_cast<float>((time - from) / (to - from)));
}

// --- Arms -----------------------------------------------------------------------------------------------------------

enum class ArmPose { hanging, aPose, raised, outward, inward };

ArmAttitude attitude(ArmPose pose) {
    switch (pose) {
        case ArmPose::hanging:
            return {.upper = {0.15F, -0.985F, -0.03F},
                    .forearm = {0.07F, -0.97F, 0.20F},
                    .fingers = {0.02F, -0.985F, 0.16F},
                    .palm = {-0.95F, -0.02F, -0.15F},
                    .curl = 0.36F};
        case ArmPose::aPose:
            return {.upper = {0.707F, -0.707F, 0.0F},
                    .forearm = {0.705F, -0.705F, 0.07F},
                    .fingers = {0.69F, -0.72F, 0.07F},
                    .palm = {-0.55F, -0.50F, 0.66F},
                    .curl = 0.06F};
        case ArmPose::raised:
            return {.upper = {0.47F, -0.80F, 0.37F},
                    .forearm = {0.25F, 0.86F, 0.44F},
                    .fingers = {0.06F, 0.98F, 0.16F},
                    .palm = {-0.02F, -0.16F, 0.98F},
                    .curl = 0.0F};
        case ArmPose::outward:
            return {.upper = {0.70F, -0.56F, 0.44F},
                    .forearm = {0.56F, 0.46F, 0.69F},
                    .fingers = {0.28F, 0.84F, 0.46F},
                    .palm = {-0.30F, -0.40F, 0.86F},
                    .curl = 0.04F};
        case ArmPose::inward:
            break;
    }
    return {.upper = {0.10F, -0.72F, 0.68F},
            .forearm = {-0.58F, 0.44F, 0.68F},
            .fingers = {-0.26F, 0.80F, 0.54F},
            .palm = {-0.12F, -0.52F, 0.84F},
            .curl = 0.04F};
}

/// From `start` to `end` the arm moves to `pose`; before, it holds what came before.
struct ArmMove {
    double start, end;
    ArmPose pose;
};
constexpr std::array<ArmMove, 7> kRightMoves = {{{3.2, 3.95, ArmPose::aPose},
                                                 {5.95, 6.6, ArmPose::hanging},
                                                 {9.8, 10.55, ArmPose::raised},
                                                 {12.5, 12.9, ArmPose::outward},
                                                 {13.0, 13.45, ArmPose::inward},
                                                 {13.7, 14.15, ArmPose::outward},
                                                 {14.35, 15.1, ArmPose::hanging}}};
constexpr std::array<ArmMove, 6> kLeftMoves = {{{3.2, 3.95, ArmPose::aPose},
                                                {5.95, 6.6, ArmPose::hanging},
                                                {14.6, 15.35, ArmPose::outward},
                                                {15.5, 15.95, ArmPose::inward},
                                                {16.2, 16.65, ArmPose::outward},
                                                {16.75, 17.5, ArmPose::hanging}}};
constexpr double kGrabFrom = 11.1;  ///< The raised right hand begins to close …
constexpr double kGrabTo = 12.0;    ///< … and to open again.
constexpr double kGrabEase = 0.22;

/// The direction `share` of the way along the great circle.
Vector3f turnedTowards(const Vector3f& from, const Vector3f& to, float share) {
    const Eigen::AngleAxisf whole(Eigen::Quaternionf::FromTwoVectors(from, to));
    return Eigen::AngleAxisf(share * whole.angle(), whole.axis()) * from.normalized();
}

/// Axes of a hand: along the fingers, towards the thumb, out of the palm.
Eigen::Quaternionf handAxes(const ArmAttitude& arm) {
    Eigen::Matrix3f axes;
    axes.col(0) = arm.fingers.normalized();
    axes.col(1) = arm.palm.cross(arm.fingers).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return Eigen::Quaternionf(axes);
}

ArmAttitude blend(const ArmAttitude& from, const ArmAttitude& to, float share) {
    const Eigen::Matrix3f hand = handAxes(from).slerp(share, handAxes(to)).toRotationMatrix();
    return {.upper = turnedTowards(from.upper, to.upper, share),
            .forearm = turnedTowards(from.forearm, to.forearm, share),
            .fingers = hand.col(0),
            .palm = hand.col(2),
            .curl = (1.0F - share) * from.curl + share * to.curl};
}

ArmAttitude armAt(std::span<const ArmMove> moves, double time) {
    ArmAttitude arm = attitude(ArmPose::hanging);
    for (const ArmMove& move : moves) {
        if (time <= move.start || move.end <= move.start) break;
        arm = blend(arm, attitude(move.pose), ease(move.start, move.end, time));
    }
    return arm;
}

// --- Walking --------------------------------------------------------------------------------------------------------

struct Place {
    Vector2f position;  ///< x and z of the mirror frame.
    float yaw = 0.0F;
};

/// A walk along a cubic curve. Walking in ends in a stand, walking out begins with one.
struct Walk {
    std::array<Vector2f, 4> control;
    double start = 0.0, end = 1.0;
    int steps = 4;
    bool arriving = true;

    [[nodiscard]] float progress(double time) const {
        const float u = static_cast<float>((time - start) / (end - start));
        return arriving ? slowing(u) : 1.0F - slowing(1.0F - u);
    }
    [[nodiscard]] float gait(double time) const {
        return static_cast<float>((time - start) / (end - start)) * static_cast<float>(steps);
    }
    /// Speed as a share of full walking speed, for what swings along.
    [[nodiscard]] float vigour(double time) const {
        const float u = static_cast<float>((time - start) / (end - start));
        const float rest = arriving ? (1.0F - u) / (1.0F - kSteady) : u / (1.0F - kSteady);
        return ease(rest);
    }
    [[nodiscard]] Place place(float share) const {
        // The curve goes on straight beyond its ends.
        const float t = std::clamp(share, 0.0F, 1.0F);
        const float s = 1.0F - t;
        const Vector2f tangent = 3.0F * (s * s * (control[1] - control[0]) + 2.0F * s * t * (control[2] - control[1]) +
                                         t * t * (control[3] - control[2]));
        const Vector2f point = s * s * s * control[0] + 3.0F * s * s * t * control[1] + 3.0F * s * t * t * control[2] +
                               t * t * t * control[3];
        return {.position = point + (share - t) * tangent, .yaw = std::atan2(-tangent.x(), -tangent.y())};
    }
    /// Where step `step`'s standing foot is set down: below the body in the middle of that step.
    [[nodiscard]] Place plant(int step) const {
        if (arriving && step >= steps - 1) return place(1.0F);
        if (!arriving && step <= 0) return place(0.0F);
        const float u = (static_cast<float>(step) + 0.5F) / static_cast<float>(steps);
        return place(arriving ? slowing(u) : 1.0F - slowing(1.0F - u));
    }

  private:
    static constexpr float kSteady = 0.6F;
    /// Integral of a speed that is constant up to kSteady and then falls to 0 as a cosine; 0 at 0, 1 at 1.
    static float slowing(float u) {
        constexpr float kRest = 1.0F - kSteady;
        const float travelled =
            u <= kSteady ? u
                         : kSteady + 0.5F * ((std::min(u, 1.0F) - kSteady) +
                                             kRest / kPi * std::sin(kPi * (std::min(u, 1.0F) - kSteady) / kRest));
        return travelled / (kSteady + 0.5F * kRest);
    }
};

/// Turning on the spot in small steps: the body eases over, first one foot follows, then the other.
struct Turn {
    double start, end;
    float from, to;
};

constexpr double kArrived = 3.3;
constexpr double kLeaving = 18.05;
constexpr float kTurnAngle = 40.0F * kPi / 180.0F;

Vector3f onFloor(const Vector2f& position, float height) {
    return {position.x(), height, position.y()};
}

Vector3f aside(const Place& place, float offset, float height) {
    // Positive offsets lie to the shopper's left.
    const Vector3f left(-std::cos(place.yaw), 0.0F, std::sin(place.yaw));
    return onFloor(place.position, height) + offset * left;
}

struct Gait {
    float legLength, ankleHeight, stanceHalfWidth, ankleToBall;
};

Gait gaitOf(const Rig& rig) {
    const Vector3f hip = rig.at(Side::left, SideBone::thigh);
    const Vector3f ankle = rig.at(Side::left, SideBone::foot);
    return {.legLength = hip.y() - ankle.y(),
            .ankleHeight = ankle.y(),
            .stanceHalfWidth = 1.12F * ankle.x(),
            .ankleToBall = 2.2F * ankle.y()};
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

float turnedFoot(const Turn& turn, double time, bool first) {
    const double middle = 0.5 * (turn.start + turn.end);
    return first ? ease(turn.start, middle, time) : ease(middle, turn.end, time);
}

void stand(const Gait& gait, std::span<const Turn> turns, double time, Posture& posture) {
    float yaw = 0.0F;
    std::array<float, 2> footYaw{};
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
    posture.pelvis.x() = 0.0F;
    posture.pelvis.z() = kStandDepth;
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t i = fitting::index(side);
        const float offset = gait.stanceHalfWidth * (side == Side::left ? 1.0F : -1.0F);
        const Place place{.position = {0.0F, kStandDepth}, .yaw = footYaw[i]};
        posture.feet[i] = {.ankle = aside(place, offset, gait.ankleHeight + 0.03F * lift[i]),
                           .yaw = footYaw[i] + toeOut(side)};
    }
}

/// Nobody stands like a post: slow sway, breath and glances.
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

}  // namespace

Posture postureAt(const Shopper& shopper, const Rig& rig, double time) {
    const Gait gait = gaitOf(rig);
    const float exitYaw = shopper.exitSide < 0.0F ? 1.45F : -1.45F;
    const std::array<Turn, 5> turns = {{{6.7, 7.55, 0.0F, kTurnAngle},
                                        {7.75, 9.0, kTurnAngle, -kTurnAngle},
                                        {9.15, 9.9, -kTurnAngle, 0.0F},
                                        {16.9, 17.5, 0.0F, 0.5F * exitYaw},
                                        {17.5, kLeaving, 0.5F * exitYaw, exitYaw}}};
    const int steps = shopper.stature < 1.5F ? 7 : 6;
    const Vector2f spot(0.0F, kStandDepth);
    const Vector2f away(-std::sin(exitYaw), -std::cos(exitYaw));
    const Walk in{.control = {Vector2f(-2.35F, shopper.entryDepth), Vector2f(-1.25F, shopper.entryDepth + 0.15F),
                              Vector2f(0.0F, kStandDepth + 0.75F), spot},
                  .start = 0.0,
                  .end = kArrived,
                  .steps = steps,
                  .arriving = true};
    const Walk out{.control = {spot, spot + 0.7F * away, spot + 1.4F * away, spot + 2.1F * away},
                   .start = kLeaving,
                   .end = kScriptSeconds,
                   .steps = shopper.stature < 1.5F ? 5 : 4,
                   .arriving = false};

    Posture posture;
    posture.pelvis.y() = rig.at(Bone::pelvis).y() - 0.013F * gait.legLength;
    posture.arms[fitting::index(Side::left)] = armAt(kLeftMoves, time);
    posture.arms[fitting::index(Side::right)] = armAt(kRightMoves, time);
    posture.arms[fitting::index(Side::right)].curl +=
        ease(kGrabFrom, kGrabFrom + kGrabEase, time) - ease(kGrabTo, kGrabTo + kGrabEase, time);

    sway(time, ease(kArrived - 0.6, kArrived + 0.6, time) - ease(kLeaving - 0.6, kLeaving + 0.2, time), posture);
    const float swayX = posture.pelvis.x();
    const float swayZ = posture.pelvis.z();
    if (time < kArrived) {
        walkBody(in, gait, time, posture);
        walkFeet(in, gait, time, posture);
    } else if (time > kLeaving) {
        walkBody(out, gait, time, posture);
        walkFeet(out, gait, time, posture);
    } else {
        stand(gait, turns, time, posture);
    }
    posture.pelvis.x() += swayX;
    posture.pelvis.z() += swayZ;
    // While turned aside, one keeps an eye on the mirror.
    if (time >= kArrived && time < 16.9) posture.headYaw -= 0.55F * posture.yaw;
    return posture;
}

}  // namespace cheval::hal::sim

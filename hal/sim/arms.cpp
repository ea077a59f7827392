#include "hal/sim/arms.h"

#include <algorithm>
#include <cmath>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;

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

}  // namespace

float ease(float u) {
    u = std::clamp(u, 0.0F, 1.0F);
    return u * u * u * (10.0F + u * (6.0F * u - 15.0F));
}

float ease(double from, double to, double time) {
    return ease(static_cast<float>((time - from) / (to - from)));
}

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

ArmAttitude reaching(const Rig& rig, const Reach& reach) {
    const fitting::Side side = fitting::Side::left;
    const float upper = (rig.at(side, SideBone::forearm) - rig.at(side, SideBone::upperArm)).norm();
    const float lower = (rig.at(side, SideBone::hand) - rig.at(side, SideBone::forearm)).norm();
    const Vector3f fingers = reach.fingers.normalized();
    // The wrist lies half a palm behind its centre.
    Vector3f wrist = rig.crown.y() * reach.palm - 0.5F * rig.palmLength * fingers;
    const float full = 0.995F * (upper + lower);
    const float least = 1.05F * std::abs(upper - lower) + 0.02F;
    const float distance = std::clamp(wrist.norm(), least, full);
    wrist = distance * wrist.normalized();
    const Vector3f along = wrist / distance;
    const float share = (distance * distance + upper * upper - lower * lower) / (2.0F * distance);
    const float bend = std::sqrt(std::max(0.0F, upper * upper - share * share));
    const Vector3f aside = (reach.elbow - reach.elbow.dot(along) * along).normalized();
    const Vector3f elbow = share * along + bend * aside;
    return {.upper = elbow.normalized(),
            .forearm = (wrist - elbow).normalized(),
            .fingers = fingers,
            .palm = (reach.facing - reach.facing.dot(fingers) * fingers).normalized(),
            .curl = reach.curl};
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
        arm = blend(arm, move.pose, ease(move.start, move.end, time));
    }
    return arm;
}

}  // namespace cheval::hal::sim

#include "hal/sim/rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cheval::hal::sim {

namespace {

using Eigen::AngleAxisf;
using Eigen::Matrix3f;
using Eigen::Quaternionf;
using Eigen::Vector3f;
using fitting::Joint;
using fitting::Side;

constexpr float kPi = std::numbers::pi_v<float>;
constexpr std::array<Side, 2> kSides = {Side::left, Side::right};

/// Rest-pose axes of the left arm: along it, towards the thumb, out of the palm.
Vector3f armAxis() {
    return Vector3f(1.0F, -1.0F, 0.0F).normalized();
}

Matrix3f axes(const Vector3f& along, const Vector3f& across) {
    Matrix3f result;
    result.col(0) = along.normalized();
    result.col(1) = (across - across.dot(result.col(0)) * result.col(0)).normalized();
    result.col(2) = result.col(0).cross(result.col(1));
    return result;
}

Vector3f mirrored(const Vector3f& point) {
    return {-point.x(), point.y(), point.z()};
}

/// The same rotation on the other side of the body.
Matrix3f mirrored(const Matrix3f& rotation) {
    Matrix3f result = rotation;
    result(0, 1) = -result(0, 1);
    result(0, 2) = -result(0, 2);
    result(1, 0) = -result(1, 0);
    result(2, 0) = -result(2, 0);
    return result;
}

Matrix3f turn(float angle, const Vector3f& axis) {
    return AngleAxisf(angle, axis).toRotationMatrix();
}

/// Half of the part of `rotation` that turns about `axis`.
Matrix3f halfTwist(const Matrix3f& rotation, const Vector3f& axis) {
    const Quaternionf whole(rotation);
    const float angle = 2.0F * std::atan2(whole.vec().dot(axis), whole.w());
    return turn(0.5F * std::remainder(angle, 2.0F * kPi), axis);
}

/// Flexion of a finger's joints and its spread in the plane of the palm, radians.
Matrix3f phalanxTurn(std::size_t finger, std::size_t joint, float curl) {
    const Vector3f along = armAxis();
    const Vector3f thumbward = Vector3f::UnitZ();
    const Vector3f out = along.cross(thumbward);
    if (finger == 0) {
        constexpr std::array<float, kPhalanxCount> kSpread = {0.85F, 0.10F, 0.05F};
        constexpr std::array<float, kPhalanxCount> kFold = {0.55F, 0.95F, 0.95F};
        // The thumb swings across the palm's front and lies over the bent fingers.
        const Matrix3f spread = turn(kSpread[joint] * (joint == 0 ? 1.0F - 0.45F * curl : 1.0F - curl), out);
        const Matrix3f fold =
            joint == 0 ? turn(0.15F + kFold[joint] * curl, -thumbward) : turn(-kFold[joint] * curl, out);
        return fold * spread;
    }
    constexpr std::array<float, kFingerCount> kSpread = {0.0F, 0.22F, 0.05F, -0.12F, -0.31F};
    constexpr std::array<float, kPhalanxCount> kFlexion = {1.45F, 1.75F, 1.05F};
    const float rest = joint == 0 ? 0.03F : 0.08F;
    const Matrix3f flex = turn(rest * (1.0F - curl) + kFlexion[joint] * curl, -thumbward);
    return joint == 0 ? Matrix3f(turn(kSpread[finger] * (1.0F - curl), out) * flex) : flex;
}

void placeArm(const Rig& rig, Side side, const ArmAttitude& arm, Pose& pose) {
    const Matrix3f restAxes = axes(armAxis(), Vector3f::UnitZ());
    // All in axes of the left arm; the right one is its reflection.
    const Vector3f upper = arm.upper.normalized();
    const Vector3f lower = arm.forearm.normalized();
    Vector3f flexion = lower - lower.dot(upper) * upper;
    // A straight arm has no plane of its own: it keeps that of an arm turned from the rest pose the short way.
    const Vector3f hint = Quaternionf::FromTwoVectors(armAxis(), upper) * Vector3f::UnitZ();
    flexion += 0.12F * hint;
    const Matrix3f upperAxes = axes(upper, flexion);
    const Matrix3f lowerAxes = axes(lower, Vector3f(upperAxes.col(2)).cross(lower));
    const Matrix3f handAxes = axes(arm.fingers.normalized(), arm.palm.cross(arm.fingers));
    const Matrix3f upperTurn = upperAxes * restAxes.transpose();
    const Matrix3f lowerTurn = lowerAxes * restAxes.transpose();
    const Matrix3f handTurn = handAxes * restAxes.transpose();
    const Matrix3f twistTurn = lowerTurn * halfTwist(lowerTurn.transpose() * handTurn, armAxis());

    const auto own = [side](const Matrix3f& rotation) { return side == Side::left ? rotation : mirrored(rotation); };
    const Matrix3f& chest = pose.rotation[bone(Bone::chest)];
    const auto hang = [&](std::size_t child, std::size_t parent, const Matrix3f& rotation) {
        pose.position[child] = pose.apply(rig, parent, rig.rest[child]);
        pose.rotation[child] = chest * own(rotation);
    };
    hang(bone(side, SideBone::upperArm), bone(Bone::chest), upperTurn);
    hang(bone(side, SideBone::forearm), bone(side, SideBone::upperArm), lowerTurn);
    hang(bone(side, SideBone::forearmTwist), bone(side, SideBone::forearm), twistTurn);
    hang(bone(side, SideBone::hand), bone(side, SideBone::forearm), handTurn);
    pose.curl[fitting::index(side)] = arm.curl;
    for (std::size_t finger = 0; finger < kFingerCount; ++finger) {
        std::size_t parent = bone(side, SideBone::hand);
        Matrix3f rotation = handTurn;
        for (std::size_t joint = 0; joint < kPhalanxCount; ++joint) {
            rotation = rotation * phalanxTurn(finger, joint, arm.curl);
            hang(phalanx(side, finger, joint), parent, rotation);
            parent = phalanx(side, finger, joint);
        }
    }
}

void placeLeg(const Rig& rig, Side side, const FootAttitude& foot, float yaw, Pose& pose) {
    const std::size_t thigh = bone(side, SideBone::thigh);
    const std::size_t shin = bone(side, SideBone::shin);
    const std::size_t sole = bone(side, SideBone::foot);
    const Vector3f hip = pose.apply(rig, bone(Bone::pelvis), rig.rest[thigh]);
    const float upper = (rig.rest[shin] - rig.rest[thigh]).norm();
    const float lower = (rig.rest[sole] - rig.rest[shin]).norm();
    Vector3f reach = foot.ankle - hip;
    // A leg that straightens at its full reach would snap its knee: it comes up to the reach softly, the foot gives
    // way.
    const float full = upper + lower;
    const float soft = 0.015F * full;
    float distance = reach.norm();
    if (distance > full - soft) distance = full - soft * std::exp((full - soft - distance) / soft);
    reach.normalize();
    const float along = (distance * distance + upper * upper - lower * lower) / (2.0F * distance);
    const float bend = std::sqrt(std::max(0.0F, upper * upper - along * along));
    const float kneeYaw = kPi + 0.5F * (yaw + foot.yaw);
    Vector3f forward(std::sin(kneeYaw), 0.0F, std::cos(kneeYaw));
    forward = (forward - forward.dot(reach) * reach).normalized();
    const Vector3f knee = hip + along * reach + bend * forward;
    const Vector3f ankle = hip + distance * reach;

    pose.position[thigh] = hip;
    pose.position[shin] = knee;
    pose.position[sole] = ankle;
    const Vector3f restThigh = rig.rest[shin] - rig.rest[thigh];
    const Vector3f restShin = rig.rest[sole] - rig.rest[shin];
    pose.rotation[thigh] = axes(knee - hip, forward) * axes(restThigh, Vector3f::UnitZ()).transpose();
    pose.rotation[shin] = axes(ankle - knee, forward) * axes(restShin, Vector3f::UnitZ()).transpose();
    pose.rotation[sole] = turn(kPi + foot.yaw, Vector3f::UnitY()) * turn(foot.pitch, Vector3f::UnitX());
}

}  // namespace

Rig makeRig(const Shopper& shopper) {
    Rig rig;
    const float h = shopper.stature;
    const BodyShares& shares = shopper.shares;
    const float lift = shopper.lift;
    const float shoulder = h * (0.0950F + 0.014F * shopper.masculine + 0.004F * shopper.build) * shares.shoulderBreadth;
    rig.rest[bone(Bone::pelvis)] = {0.0F, (0.525F + shares.leg) * h + lift, 0.0F};
    rig.rest[bone(Bone::chest)] = {0.0F, (0.62F + 0.6F * shares.leg) * h + lift, 0.0F};
    rig.crown = {0.0F, h + lift, 0.004F * h};
    rig.headCentre = {0.0F, h + lift - 0.5F * shopper.headHeight, 0.010F * h};
    const float chin = h + lift - shopper.headHeight;
    const float neckBase = chin - (0.034F + shares.neckLength) * h;
    rig.rest[bone(Bone::neck)] = {0.0F, neckBase, -0.008F * h};
    rig.rest[bone(Bone::head)] = {0.0F, chin + 0.012F * h, 0.0F};

    rig.handLength = 0.107F * h;
    rig.palmLength = 0.54F * rig.handLength;
    rig.palmHalfWidth = 0.215F * rig.handLength;
    rig.fingerRadius = 0.050F * rig.handLength;
    rig.fingerLength = {0.36F * rig.handLength, 0.43F * rig.handLength, 0.48F * rig.handLength, 0.44F * rig.handLength,
                        0.35F * rig.handLength};
    const Vector3f along = armAxis();
    const Vector3f thumbward = Vector3f::UnitZ();
    const Vector3f out = along.cross(thumbward);
    for (const Side side : kSides) {
        const auto put = [&](std::size_t which, const Vector3f& left) {
            rig.rest[which] = side == Side::left ? left : mirrored(left);
        };
        const Vector3f shoulderPoint(shoulder, neckBase - 0.048F * h, -0.008F * h);
        const Vector3f elbow = shoulderPoint + 0.168F * h * shares.armLength * along;
        const Vector3f wrist = elbow + 0.145F * h * shares.armLength * along;
        put(bone(side, SideBone::upperArm), shoulderPoint);
        put(bone(side, SideBone::forearm), elbow);
        put(bone(side, SideBone::forearmTwist), 0.5F * (elbow + wrist));
        put(bone(side, SideBone::hand), wrist);
        // Wide hips stand on legs that are farther apart.
        const float apart = 1.0F + 0.6F * (shares.hipBreadth - 1.0F);
        put(bone(side, SideBone::thigh), {0.053F * h * apart, (0.525F + shares.leg) * h + lift, 0.0F});
        put(bone(side, SideBone::shin), {0.055F * h * apart, (0.283F + 0.55F * shares.leg) * h + lift, 0.004F * h});
        put(bone(side, SideBone::foot), {0.057F * h, 0.050F * h + lift, -0.010F * h});
        constexpr std::array<float, kFingerCount> kAcross = {0.62F, 0.73F, 0.245F, -0.245F, -0.71F};
        constexpr std::array<float, kFingerCount> kUp = {0.22F, 0.97F, 1.0F, 0.97F, 0.90F};
        constexpr std::array<float, kPhalanxCount> kShare = {0.44F, 0.31F, 0.25F};
        for (std::size_t finger = 0; finger < kFingerCount; ++finger) {
            Vector3f base = wrist + kUp[finger] * rig.palmLength * along +
                            kAcross[finger] * rig.palmHalfWidth * thumbward +
                            (finger == 0 ? 0.15F : 0.0F) * rig.palmHalfWidth * out;
            for (std::size_t joint = 0; joint < kPhalanxCount; ++joint) {
                put(phalanx(side, finger, joint), base);
                base += kShare[joint] * rig.fingerLength[finger] * along;
            }
        }
    }
    return rig;
}

Pose solvePose(const Rig& rig, const Posture& posture) {
    Pose pose;
    const Matrix3f facing = turn(kPi + posture.yaw, Vector3f::UnitY());
    const std::size_t pelvis = bone(Bone::pelvis);
    const std::size_t chest = bone(Bone::chest);
    const std::size_t neck = bone(Bone::neck);
    const std::size_t head = bone(Bone::head);
    pose.position[pelvis] = posture.pelvis;
    pose.rotation[pelvis] = facing * turn(posture.pelvisRoll, Vector3f::UnitZ());
    pose.position[chest] = pose.apply(rig, pelvis, rig.rest[chest]);
    pose.rotation[chest] = pose.rotation[pelvis] * turn(posture.chestYaw, Vector3f::UnitY()) *
                           turn(posture.chestPitch, Vector3f::UnitX()) * turn(posture.chestRoll, Vector3f::UnitZ());
    pose.position[neck] = pose.apply(rig, chest, rig.rest[neck]);
    const auto headTurn = [&](float share) {
        return Matrix3f(turn(share * posture.headYaw, Vector3f::UnitY()) *
                        turn(share * posture.headPitch, Vector3f::UnitX()) *
                        turn(share * posture.headRoll, Vector3f::UnitZ()));
    };
    pose.rotation[neck] = pose.rotation[chest] * headTurn(0.5F);
    pose.position[head] = pose.apply(rig, neck, rig.rest[head]);
    pose.rotation[head] = pose.rotation[chest] * headTurn(1.0F);
    for (const Side side : kSides) {
        placeArm(rig, side, posture.arms[fitting::index(side)], pose);
        placeLeg(rig, side, posture.feet[fitting::index(side)], posture.yaw, pose);
    }
    return pose;
}

fitting::Skeleton skeletonOf(const Rig& rig, const Pose& pose) {
    fitting::Skeleton skeleton;
    const auto put = [&](Joint joint, const Vector3f& position, const Matrix3f& rotation) {
        skeleton[joint] = {.position = position, .orientation = Quaternionf(rotation).normalized(), .confidence = 1.0F};
    };
    const auto putBone = [&](Joint joint, std::size_t which) {
        put(joint, pose.position[which], pose.rotation[which]);
    };
    put(Joint::head, pose.apply(rig, bone(Bone::head), rig.headCentre), pose.rotation[bone(Bone::head)]);
    putBone(Joint::neck, bone(Bone::neck));
    const auto putSide = [&](Side side, std::array<Joint, 6> joints) {
        putBone(joints[0], bone(side, SideBone::upperArm));
        putBone(joints[1], bone(side, SideBone::forearm));
        const std::size_t hand = bone(side, SideBone::hand);
        Vector3f along = armAxis();
        if (side == Side::right) along = mirrored(along);
        put(joints[2], pose.apply(rig, hand, rig.rest[hand] + 0.5F * rig.palmLength * along), pose.rotation[hand]);
        putBone(joints[3], bone(side, SideBone::thigh));
        putBone(joints[4], bone(side, SideBone::shin));
        putBone(joints[5], bone(side, SideBone::foot));
    };
    putSide(Side::left,
            {Joint::leftShoulder, Joint::leftElbow, Joint::leftHand, Joint::leftHip, Joint::leftKnee, Joint::leftFoot});
    putSide(Side::right, {Joint::rightShoulder, Joint::rightElbow, Joint::rightHand, Joint::rightHip, Joint::rightKnee,
                          Joint::rightFoot});
    const Vector3f hips = 0.5F * (skeleton[Joint::leftHip].position + skeleton[Joint::rightHip].position);
    const Quaternionf lower(pose.rotation[bone(Bone::pelvis)]);
    const Quaternionf upper(pose.rotation[bone(Bone::chest)]);
    put(Joint::torso, 0.5F * (skeleton[Joint::neck].position + hips), lower.slerp(0.5F, upper).toRotationMatrix());
    return skeleton;
}

}  // namespace cheval::hal::sim

#include "fitting/tracking/orientation.h"

namespace cheval::fitting::tracking {
namespace {

constexpr float kHalfRoot = 0.70710678F;

/// Turns `parent` so that the bone's rest direction falls on the way from one joint to the next.
Eigen::Quaternionf swing(const Eigen::Quaternionf& parent, const Eigen::Vector3f& rest, const Eigen::Vector3f& from,
                         const Eigen::Vector3f& to) {
    const Eigen::Vector3f bone = to - from;
    if (bone.squaredNorm() < 1e-8F) return parent;
    return (Eigen::Quaternionf::FromTwoVectors(parent * rest, bone) * parent).normalized();
}

void orientLimb(const Eigen::Quaternionf& trunk, const Eigen::Vector3f& rest, Joint root, Joint middle, Joint end,
                Skeleton& skeleton) {
    skeleton[root].orientation = swing(trunk, rest, skeleton[root].position, skeleton[middle].position);
    skeleton[middle].orientation =
        swing(skeleton[root].orientation, rest, skeleton[middle].position, skeleton[end].position);
    skeleton[end].orientation = skeleton[middle].orientation;
}

}  // namespace

void orientJoints(const Eigen::Matrix3f& axes, Skeleton& skeleton) {
    const Eigen::Quaternionf trunk = Eigen::Quaternionf(axes).normalized();
    for (const Joint joint : {Joint::head, Joint::neck, Joint::torso}) {
        skeleton[joint].orientation = trunk;
    }
    const Eigen::Vector3f leftArm(kHalfRoot, -kHalfRoot, 0.0F);
    const Eigen::Vector3f rightArm(-kHalfRoot, -kHalfRoot, 0.0F);
    const Eigen::Vector3f leg(0.0F, -1.0F, 0.0F);
    orientLimb(trunk, leftArm, Joint::leftShoulder, Joint::leftElbow, Joint::leftHand, skeleton);
    orientLimb(trunk, rightArm, Joint::rightShoulder, Joint::rightElbow, Joint::rightHand, skeleton);
    orientLimb(trunk, leg, Joint::leftHip, Joint::leftKnee, Joint::leftFoot, skeleton);
    orientLimb(trunk, leg, Joint::rightHip, Joint::rightKnee, Joint::rightFoot, skeleton);
}

}  // namespace cheval::fitting::tracking

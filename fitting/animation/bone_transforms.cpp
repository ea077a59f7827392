#include "fitting/animation/bone_transforms.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting {

namespace {

using Joints = std::array<Eigen::Vector3f, kJointCount>;

// The joint that a bone reaches to; itself where the bone ends freely.
constexpr std::array<Joint, kJointCount> kBoneTip = {
    Joint::head,     Joint::head,       Joint::neck,      Joint::leftElbow, Joint::leftHand,
    Joint::leftHand, Joint::rightElbow, Joint::rightHand, Joint::rightHand, Joint::leftKnee,
    Joint::leftFoot, Joint::leftFoot,   Joint::rightKnee, Joint::rightFoot, Joint::rightFoot};

// The bone that a bone hangs from and keeps its rotation relative to: as kJointParent, but arms hang from the trunk
// (the neck turns with the head).
constexpr Joint bearer(Joint joint) {
    return joint == Joint::leftShoulder || joint == Joint::rightShoulder ? Joint::torso : kJointParent[index(joint)];
}

// Bearers before what they bear.
constexpr std::array kLimbOrder = {Joint::neck,      Joint::head,          Joint::leftShoulder, Joint::leftElbow,
                                   Joint::leftHand,  Joint::rightShoulder, Joint::rightElbow,   Joint::rightHand,
                                   Joint::leftHip,   Joint::leftKnee,      Joint::leftFoot,     Joint::rightHip,
                                   Joint::rightKnee, Joint::rightFoot};

// A shopper faces the glass: half a turn from the rest pose.
const Eigen::Quaternionf kFacingGlass(0.0F, 0.0F, 1.0F, 0.0F);
constexpr float kSmallestLength = 1e-3F;  // metres; shorter vectors have no direction worth having

bool usable(const Eigen::Quaternionf& q) {
    return q.coeffs().allFinite() && std::abs(q.norm() - 1.0F) < 0.1F;
}

bool isGirdle(Joint joint) {
    return joint == Joint::leftShoulder || joint == Joint::rightShoulder || joint == Joint::leftHip ||
           joint == Joint::rightHip;
}

Eigen::Vector3f midpoint(const Joints& joints, Joint a, Joint b) {
    return 0.5F * (joints[index(a)] + joints[index(b)]);
}

// Rotation whose columns are the frame of `up` and `left`, the first kept exactly.
bool frameOf(const Eigen::Vector3f& up, const Eigen::Vector3f& left, Eigen::Matrix3f& frame) {
    if (up.norm() < kSmallestLength) return false;
    const Eigen::Vector3f y = up.normalized();
    const Eigen::Vector3f across = left - y * y.dot(left);
    if (across.norm() < kSmallestLength) return false;
    const Eigen::Vector3f x = across.normalized();
    frame << x, y, x.cross(y);
    return true;
}

}  // namespace

struct BoneTransforms::Tracked {
    Joints position{};
    std::array<Eigen::Quaternionf, kJointCount> orientation{};
    std::array<bool, kJointCount> seen{};
    std::array<bool, kJointCount> oriented{};

    Tracked(const Skeleton& skeleton, float minimumConfidence) {
        for (std::size_t i = 0; i < kJointCount; ++i) {
            const JointState& joint = skeleton.joints[i];
            seen[i] = skeleton.present() && joint.confidence >= minimumConfidence && joint.position.allFinite();
            oriented[i] = seen[i] && usable(joint.orientation);
            position[i] = seen[i] ? joint.position : Eigen::Vector3f::Zero();
            orientation[i] = oriented[i] ? joint.orientation.normalized() : Eigen::Quaternionf::Identity();
        }
    }
    [[nodiscard]] bool has(Joint joint) const { return seen[index(joint)]; }
    [[nodiscard]] bool has(Joint a, Joint b) const { return has(a) && has(b); }
    [[nodiscard]] const Eigen::Vector3f& at(Joint joint) const { return position[index(joint)]; }
};

BoneTransforms::BoneTransforms(const BoneTransformOptions& options) : options_(options) {
    reset();
}

void BoneTransforms::reset() {
    transforms_.fill(Eigen::Affine3f::Identity());
    rotation_.fill(kFacingGlass);
    relative_.fill(Eigen::Quaternionf::Identity());
    stretch_.fill(1.0F);
    torsoCentre_.setZero();
    placed_ = false;
}

void BoneTransforms::update(const Joints& rest, const Skeleton& skeleton) {
    const Tracked tracked(skeleton, options_.minimumConfidence);
    placeTorso(rest, tracked);
    for (const Joint joint : kLimbOrder)
        placeLimb(joint, rest, tracked);
}

void BoneTransforms::place(Joint joint, const Eigen::Vector3f& restPosition, const Eigen::Vector3f& position,
                           const Eigen::Quaternionf& rotation, const Eigen::Vector3f& axis, float stretch) {
    const std::size_t i = index(joint);
    rotation_[i] = rotation;
    stretch_[i] = stretch;
    Eigen::Affine3f& transform = transforms_[i];
    transform.linear() =
        rotation.toRotationMatrix() * (Eigen::Matrix3f::Identity() + (stretch - 1.0F) * axis * axis.transpose());
    transform.translation() = position - transform.linear() * restPosition;
}

void BoneTransforms::placeTorso(const Joints& rest, const Tracked& tracked) {
    const Eigen::Vector3f restHips = midpoint(rest, Joint::leftHip, Joint::rightHip);
    const Eigen::Vector3f& restNeck = rest[index(Joint::neck)];
    const Eigen::Vector3f restCentre = 0.5F * (restHips + restNeck);
    const Eigen::Vector3f restUp = restNeck - restHips;
    const bool hips = tracked.has(Joint::leftHip, Joint::rightHip);
    const bool shoulders = tracked.has(Joint::leftShoulder, Joint::rightShoulder);
    const bool neck = tracked.has(Joint::neck);
    const bool torso = tracked.has(Joint::torso);
    const Eigen::Vector3f trackedHips = midpoint(tracked.position, Joint::leftHip, Joint::rightHip);
    const Eigen::Vector3f& trackedNeck = tracked.at(Joint::neck);

    // The spine from whichever two of neck, torso and hips are seen, the longest first.
    Eigen::Vector3f up = Eigen::Vector3f::Zero();
    float restLength = 0.0F;
    if (neck && hips) {
        up = trackedNeck - trackedHips;
        restLength = restUp.norm();
    } else if (neck && torso) {
        up = trackedNeck - tracked.at(Joint::torso);
        restLength = 0.5F * restUp.norm();
    } else if (torso && hips) {
        up = tracked.at(Joint::torso) - trackedHips;
        restLength = 0.5F * restUp.norm();
    }
    // The breadth from shoulders and hips together: one joint of four cannot turn it over.
    Eigen::Vector3f left = Eigen::Vector3f::Zero();
    Eigen::Vector3f restLeft = Eigen::Vector3f::Zero();
    const auto addBreadth = [&](Joint leftJoint, Joint rightJoint) {
        left += tracked.at(leftJoint) - tracked.at(rightJoint);
        restLeft += rest[index(leftJoint)] - rest[index(rightJoint)];
    };
    if (shoulders) addBreadth(Joint::leftShoulder, Joint::rightShoulder);
    if (hips) addBreadth(Joint::leftHip, Joint::rightHip);

    Eigen::Quaternionf rotation = rotation_[index(Joint::torso)];
    if (tracked.oriented[index(Joint::torso)]) rotation = tracked.orientation[index(Joint::torso)];
    Eigen::Matrix3f frame;
    Eigen::Matrix3f restFrame;
    if (frameOf(up, left, frame) && frameOf(restUp, restLeft, restFrame)) {
        rotation = Eigen::Quaternionf(frame * restFrame.transpose());
    } else if (up.norm() > kSmallestLength) {
        rotation = Eigen::Quaternionf::FromTwoVectors(rotation * restUp, up) * rotation;
    }
    rotation.normalize();

    float stretch = stretch_[index(Joint::torso)];
    if (restLength > kSmallestLength && up.norm() > kSmallestLength) {
        stretch = std::clamp(up.norm() / restLength, options_.shortestStretch, options_.longestStretch);
    }

    // Translated last (D5).
    const Eigen::Vector3f halfSpine = 0.5F * stretch * (rotation * restUp);
    if (neck && hips) {
        torsoCentre_ = 0.5F * (trackedNeck + trackedHips);
    } else if (neck) {
        torsoCentre_ = trackedNeck - halfSpine;
    } else if (torso) {
        torsoCentre_ = tracked.at(Joint::torso);
    } else if (hips) {
        torsoCentre_ = trackedHips + halfSpine;
    } else if (shoulders) {
        const Eigen::Vector3f restOffset = midpoint(rest, Joint::leftShoulder, Joint::rightShoulder) - restCentre;
        torsoCentre_ = midpoint(tracked.position, Joint::leftShoulder, Joint::rightShoulder) - rotation * restOffset;
    } else if (!placed_) {
        torsoCentre_ = restCentre;
    }
    placed_ = true;
    place(Joint::torso, restCentre, torsoCentre_, rotation, restUp.normalized(), stretch);
}

void BoneTransforms::placeLimb(Joint joint, const Joints& rest, const Tracked& tracked) {
    const std::size_t i = index(joint);
    const Joint tip = kBoneTip[i];
    const std::size_t bearing = index(bearer(joint));
    const Eigen::Vector3f& restPosition = rest[i];

    // Elsewhere the bearing bone already reaches to the tracked joint, as far as its stretch may go.
    Eigen::Vector3f position = transforms_[bearing] * restPosition;
    if (isGirdle(joint) && tracked.has(joint)) {
        Eigen::Vector3f away = tracked.at(joint) - position;
        const float squared = away.squaredNorm();
        away *= squared / (squared + options_.girdleSlack * options_.girdleSlack);
        if (away.norm() > options_.girdleReach) away *= options_.girdleReach / away.norm();
        position += away;
    }

    const Eigen::Vector3f restBone = rest[index(tip)] - restPosition;
    const Eigen::Vector3f along = restBone.normalized();
    const bool ends = tip == joint;
    Eigen::Quaternionf rotation = (rotation_[bearing] * relative_[i]).normalized();
    float stretch = stretch_[i];
    if (ends) {
        if (tracked.oriented[i]) rotation = tracked.orientation[i];
    } else if (tracked.has(joint, tip) && restBone.norm() > kSmallestLength) {
        // Measured from where the bone starts, so that it ends on the tracked joint even when its start was held back.
        const Eigen::Vector3f bone = tracked.at(tip) - position;
        if (bone.norm() > kSmallestLength) {
            const Eigen::Quaternionf before = tracked.oriented[i] ? tracked.orientation[i] : rotation_[bearing];
            rotation = Eigen::Quaternionf::FromTwoVectors(before * along, bone) * before;
            stretch = std::clamp(bone.norm() / restBone.norm(), options_.shortestStretch, options_.longestStretch);
        }
    }
    rotation.normalize();
    relative_[i] = (rotation_[bearing].conjugate() * rotation).normalized();
    place(joint, restPosition, position, rotation, ends ? Eigen::Vector3f::Zero() : along, stretch);
}

}  // namespace cheval::fitting

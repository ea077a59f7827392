// The simulated shopper's bones: rest pose, and how a pose places them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Geometry>

#include "fitting/skeleton.h"
#include "hal/sim/shopper.h"

namespace cheval::hal::sim {

inline constexpr std::size_t kFingerCount = 5;  ///< Thumb first.
inline constexpr std::size_t kPhalanxCount = 3;

/// Bones in the middle of the body; those of each side follow, left first.
enum class Bone : std::uint8_t { pelvis, chest, neck, head };
enum class SideBone : std::uint8_t { upperArm, forearm, forearmTwist, hand, thigh, shin, foot, fingers };
inline constexpr std::size_t kMiddleBoneCount = 4;
inline constexpr std::size_t kSideBoneCount = 7 + kFingerCount * kPhalanxCount;
inline constexpr std::size_t kBoneCount = kMiddleBoneCount + 2 * kSideBoneCount;

constexpr std::size_t bone(Bone which) {
    return static_cast<std::size_t>(which);
}
constexpr std::size_t bone(fitting::Side side, SideBone which) {
    return kMiddleBoneCount + fitting::index(side) * kSideBoneCount + static_cast<std::size_t>(which);
}
constexpr std::size_t phalanx(fitting::Side side, std::size_t finger, std::size_t joint) {
    return bone(side, SideBone::fingers) + finger * kPhalanxCount + joint;
}

/// Rest pose: A-pose, arms 45° down, palms towards the thighs, thumbs forward; metres, +Y up, facing +Z, left at +X.
struct Rig {
    std::array<Eigen::Vector3f, kBoneCount> rest;  ///< Where each bone begins; all its axes are those of the rest pose.
    Eigen::Vector3f headCentre;
    Eigen::Vector3f crown;
    float handLength = 0.0F;
    float palmLength = 0.0F;
    float palmHalfWidth = 0.0F;
    float fingerRadius = 0.0F;
    std::array<float, kFingerCount> fingerLength{};

    [[nodiscard]] Eigen::Vector3f at(Bone which) const { return rest[bone(which)]; }
    [[nodiscard]] Eigen::Vector3f at(fitting::Side side, SideBone which) const { return rest[bone(side, which)]; }
};
Rig makeRig(const Shopper& shopper);

/// One arm's attitude in axes of the chest with x pointing away from the body on either side.
struct ArmAttitude {
    Eigen::Vector3f upper, forearm;  ///< Directions of the bones.
    Eigen::Vector3f fingers, palm;   ///< Direction of flat fingers, and out of the palm.
    float curl = 0.0F;               ///< 0 flat and spread … 1 fist.
};
/// One foot on or above the floor, mirror frame.
struct FootAttitude {
    Eigen::Vector3f ankle = Eigen::Vector3f::Zero();
    float yaw = 0.0F;    ///< As Posture::yaw.
    float pitch = 0.0F;  ///< Positive: toes down.
};
/// All that is free in a pose. Angles in radians. Yaw 0 faces the glass, positive turns the shopper to their left.
struct Posture {
    Eigen::Vector3f pelvis = Eigen::Vector3f::Zero();  ///< Mid-point of the hips, mirror frame.
    float yaw = 0.0F;
    float pelvisRoll = 0.0F;
    float chestPitch = 0.0F, chestYaw = 0.0F, chestRoll = 0.0F;  ///< Against the pelvis.
    float headPitch = 0.0F, headYaw = 0.0F, headRoll = 0.0F;     ///< Against the chest.
    std::array<ArmAttitude, fitting::kSideCount> arms;
    std::array<FootAttitude, fitting::kSideCount> feet;
};

/// Where the bones are: p = rotation · (p_rest − rest) + position, mirror frame.
struct Pose {
    std::array<Eigen::Matrix3f, kBoneCount> rotation;
    std::array<Eigen::Vector3f, kBoneCount> position;
    std::array<float, fitting::kSideCount> curl{};

    [[nodiscard]] Eigen::Vector3f apply(const Rig& rig, std::size_t which, const Eigen::Vector3f& restPoint) const {
        return rotation[which] * (restPoint - rig.rest[which]) + position[which];
    }
};
Pose solvePose(const Rig& rig, const Posture& posture);

/// The 15 joints of a pose by the definitions of fitting/skeleton.h; captureTime and userId are left to the caller.
fitting::Skeleton skeletonOf(const Rig& rig, const Pose& pose);

}  // namespace cheval::hal::sim

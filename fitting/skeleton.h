// The 15 joints (D1). Mirror frame of reference: metres, right-handed, +Y up, floor at y = 0 below the
// display's centre, +Z from the glass towards the shopper, +X to the right of a shopper who faces the glass. Left and
// right are the shopper's: a shopper who faces the glass has the left hand at −X.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <Eigen/Geometry>

#include "hal/clock.h"
#include "hal/frame.h"

namespace cheval::fitting {

enum class Joint : std::uint8_t {
    head,
    neck,
    torso,
    leftShoulder,
    leftElbow,
    leftHand,
    rightShoulder,
    rightElbow,
    rightHand,
    leftHip,
    leftKnee,
    leftFoot,
    rightHip,
    rightKnee,
    rightFoot,
};
inline constexpr std::size_t kJointCount = 15;

/// Names as the tracks file has them ("left_shoulder"), in the order of Joint.
inline constexpr std::array<std::string_view, kJointCount> kJointNames = {
    "head",       "neck",     "torso",     "left_shoulder", "left_elbow", "left_hand",  "right_shoulder", "right_elbow",
    "right_hand", "left_hip", "left_knee", "left_foot",     "right_hip",  "right_knee", "right_foot"};

/// The joint that each joint hangs from; the torso is the root and its own parent.
inline constexpr std::array<Joint, kJointCount> kJointParent = {
    Joint::neck,      Joint::torso,    Joint::torso,         Joint::neck,       Joint::leftShoulder,
    Joint::leftElbow, Joint::neck,     Joint::rightShoulder, Joint::rightElbow, Joint::torso,
    Joint::leftHip,   Joint::leftKnee, Joint::torso,         Joint::rightHip,   Joint::rightKnee};

enum class Side : std::uint8_t { left, right };
inline constexpr std::size_t kSideCount = 2;

constexpr std::size_t index(Joint joint) {
    return static_cast<std::size_t>(joint);
}
constexpr std::size_t index(Side side) {
    return static_cast<std::size_t>(side);
}

/// One joint as tracked. `position` is the rig's joint centre (head: centre of the head; hand: centre of the palm;
/// foot: the ankle). `orientation` turns rest-pose axes (A-pose) into the tracked ones. `confidence` 0…1;
/// under 0.5 the joint was not seen and its position is an estimate.
struct JointState {
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
    float confidence = 0.0F;
};

/// All joints of one person at one time.
struct Skeleton {
    std::array<JointState, kJointCount> joints{};
    hal::TimePoint captureTime{};
    std::uint32_t userId = 0;  ///< 0: nobody.

    [[nodiscard]] bool present() const { return userId != 0; }
    JointState& operator[](Joint joint) { return joints[index(joint)]; }
    const JointState& operator[](Joint joint) const { return joints[index(joint)]; }
};

/// The rigid way from the sensor frame (millimetres, left-handed, hal/frame.h) to the mirror frame (metres,
/// right-handed): p_mirror = rotation · p_sensor / 1000 + translation. `rotation` has determinant −1, since handedness
/// changes.
struct SensorPlacement {
    Eigen::Matrix3f rotation = Eigen::Vector3f(-1.0F, 1.0F, 1.0F).asDiagonal();
    Eigen::Vector3f translation = Eigen::Vector3f::Zero();

    [[nodiscard]] Eigen::Vector3f toMirror(const Eigen::Vector3f& sensorMillimetres) const {
        return rotation * sensorMillimetres * 1e-3F + translation;
    }
    [[nodiscard]] Eigen::Vector3f toSensor(const Eigen::Vector3f& mirrorMetres) const {
        return rotation.transpose() * (mirrorMetres - translation) * 1e3F;
    }
};

/// The sensor-frame point in millimetres that pixel (u, v) sees at depth `z` millimetres.
inline Eigen::Vector3f unproject(const hal::Intrinsics& intrinsics, float u, float v, float z) {
    return {(u - intrinsics.cx) * z / intrinsics.fx, (intrinsics.cy - v) * z / intrinsics.fy, z};
}
/// The pixel (u, v) of a sensor-frame point with z > 0.
inline Eigen::Vector2f project(const hal::Intrinsics& intrinsics, const Eigen::Vector3f& sensorMillimetres) {
    return {intrinsics.cx + intrinsics.fx * sensorMillimetres.x() / sensorMillimetres.z(),
            intrinsics.cy - intrinsics.fy * sensorMillimetres.y() / sensorMillimetres.z()};
}

}  // namespace cheval::fitting

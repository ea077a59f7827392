// From tracked joints to bone transforms (D5): where each bone lies, how it is turned and how far it is stretched.
#pragma once

#include <array>

#include <Eigen/Geometry>

#include "fitting/skeleton.h"

namespace cheval::fitting {

struct BoneTransformOptions {
    float minimumConfidence = 0.5F;
    float shortestStretch = 0.8F;  ///< A bone meets the next tracked joint by stretching along itself, within limits:
    float longestStretch = 1.25F;  ///< a joint seen too near or too far pulls no more than this.
    /// Shoulders and hips hang from the torso and follow their tracked joints by the part d²/(d² + slack²) of the
    /// distance d: a few centimetres are mostly another idea of where the joint is, or noise, and would dent the
    /// garment; raised shoulders are followed. They never follow farther than the reach, metres: a joint that jumped to
    /// another thing must not tear the garment.
    float girdleSlack = 0.04F;
    float girdleReach = 0.12F;
};

/// Rest pose → mirror frame for each bone, with memory for bones that are not seen. A bone starts at the joint that it
/// is named after: torso = the trunk from mid-hips to neck, neck = neck to head, shoulder = upper arm, elbow = forearm,
/// hip = thigh, knee = shin; head, hand and foot end there. Thread-bound; takes no memory.
///
/// A bone turns by its joint's orientation and then by the least rotation that lays it on the next tracked joint. Where
/// either joint is under the minimum confidence (or not finite) the bone keeps its last rotation relative to the bone
/// that it hangs from, so that an arm that cannot be seen turns with the body and not through it. Before anything was
/// seen that is the rest pose, facing the glass. The torso is a frame of shoulders, hips and neck, so that no single
/// joint can turn it over.
class BoneTransforms {
  public:
    explicit BoneTransforms(const BoneTransformOptions& options);

    /// `rest`: joint centres of the shaped body in rest pose.
    void update(const std::array<Eigen::Vector3f, kJointCount>& rest, const Skeleton& skeleton);
    void reset();

    [[nodiscard]] const std::array<Eigen::Affine3f, kJointCount>& transforms() const { return transforms_; }

  private:
    struct Tracked;
    void placeTorso(const std::array<Eigen::Vector3f, kJointCount>& rest, const Tracked& tracked);
    void placeLimb(Joint joint, const std::array<Eigen::Vector3f, kJointCount>& rest, const Tracked& tracked);
    void place(Joint joint, const Eigen::Vector3f& restPosition, const Eigen::Vector3f& position,
               const Eigen::Quaternionf& rotation, const Eigen::Vector3f& axis, float stretch);

    BoneTransformOptions options_;
    std::array<Eigen::Affine3f, kJointCount> transforms_{};
    std::array<Eigen::Quaternionf, kJointCount> rotation_{};  ///< Of the bone in the mirror frame.
    std::array<Eigen::Quaternionf, kJointCount> relative_{};  ///< To the parent bone, as last seen.
    std::array<float, kJointCount> stretch_{};
    Eigen::Vector3f torsoCentre_ = Eigen::Vector3f::Zero();
    bool placed_ = false;
};

}  // namespace cheval::fitting

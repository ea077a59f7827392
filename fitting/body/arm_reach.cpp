#include "fitting/body/arm_reach.h"

#include <algorithm>
#include <array>

namespace cheval::fitting {

namespace {

constexpr float kSeen = 0.5F;         // Confidence from which a joint counts as seen.
constexpr float kArmRadius = 0.065F;  // metres about an arm's bones

float distanceToSegment(const Eigen::Vector3f& point, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    const Eigen::Vector3f along = b - a;
    const float squared = along.squaredNorm();
    const float t = squared > 0.0F ? std::clamp((point - a).dot(along) / squared, 0.0F, 1.0F) : 0.0F;
    return (point - (a + t * along)).norm();
}

}  // namespace

bool onArm(const Skeleton& skeleton, const Eigen::Vector3f& point) {
    for (const auto& [shoulder, elbow, hand] :
         {std::array{Joint::leftShoulder, Joint::leftElbow, Joint::leftHand},
          std::array{Joint::rightShoulder, Joint::rightElbow, Joint::rightHand}}) {
        const JointState& upper = skeleton[shoulder];
        const JointState& middle = skeleton[elbow];
        const JointState& lower = skeleton[hand];
        if (middle.confidence < kSeen) continue;
        // The shoulder itself is the trunk's.
        const Eigen::Vector3f start = upper.position + 0.4F * (middle.position - upper.position);
        if (upper.confidence >= kSeen && distanceToSegment(point, start, middle.position) < kArmRadius) return true;
        if (lower.confidence >= kSeen) {
            // Fingers go on past the palm.
            const Eigen::Vector3f fingers = lower.position + 0.35F * (lower.position - middle.position);
            if (distanceToSegment(point, middle.position, fingers) < kArmRadius) return true;
        }
    }
    return false;
}

}  // namespace cheval::fitting

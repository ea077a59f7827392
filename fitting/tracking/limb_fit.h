// Arms and legs: two bones from a known root, fitted to the depth by a guided search.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "fitting/tracking/cloud.h"
#include "fitting/tracking/silhouette.h"
#include "fitting/tracking/torso_fit.h"

namespace cheval::fitting::tracking {

enum class LimbKind : std::uint8_t { arm, leg };

/// Lengths and radii of a limb's two bones, metres. The lower bone ends in the joint that is tracked (palm, ankle);
/// `beyond` is how far the body goes on after it in the same direction.
struct LimbModel {
    LimbKind kind = LimbKind::arm;
    float upperLength = 0.26F;
    float lowerLength = 0.29F;
    float upperRadius = 0.045F;
    float lowerRadius = 0.035F;
    float beyond = 0.08F;
};
LimbModel armModel(float stature);
LimbModel legModel(float stature);

/// Where a limb is. Mirror frame, metres.
struct LimbPose {
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< Elbow or knee.
    Eigen::Vector3f end = Eigen::Vector3f::Zero();     ///< Palm or ankle.
    float cost = 1e3F;
    bool valid = false;
};

/// A posed limb, prepared for many questions: how far points are from its skin, inside or out.
class LimbSkin {
  public:
    LimbSkin(const LimbModel& model, const Eigen::Vector3f& root, const LimbPose& pose);
    [[nodiscard]] float distanceTo(const Eigen::Vector3f& point) const {
        return std::min(upper_.distanceTo(point), lower_.distanceTo(point));
    }

  private:
    struct Bone {
        Eigen::Vector3f from, along;
        float perLength, radius;  ///< perLength: 1 / |along|².

        [[nodiscard]] float distanceTo(const Eigen::Vector3f& point) const {
            const Eigen::Vector3f offset = point - from;
            const float t = std::clamp(offset.dot(along) * perLength, 0.0F, 1.0F);
            return std::abs((offset - t * along).norm() - radius);
        }
    };
    Bone upper_, lower_;
};

/// A small deterministic generator: the same frame gives the same pose.
struct Generator {
    std::uint32_t state = 0x9E3779B9U;
    /// Uniform in −1…1.
    float next() {
        state ^= state << 13U;
        state ^= state >> 17U;
        state ^= state << 5U;
        return static_cast<float>(state >> 8U) * (2.0F / 16777216.0F) - 1.0F;
    }
};

/// Searches the two directions of a limb. The cost has four terms: depth points that no limb explains, bones in empty
/// air, bones behind what is seen, and what bodies do not do. Starts are the pose before, the farthest points, and a
/// small set of common poses; the best three that differ are each perturbed, and the winner ever more finely. Invalid
/// without cloud, silhouette and torso, or when `explained` and `points` differ in length.
struct LimbFitJob {
    const Cloud* cloud = nullptr;
    const Silhouette* silhouette = nullptr;
    const TorsoPose* torso = nullptr;
    LimbModel model;
    Side side = Side::left;
    Eigen::Vector3f root = Eigen::Vector3f::Zero();
    const LimbPose* previous = nullptr;       ///< Of the frame before, or null.
    std::span<const Eigen::Vector3f> points;  ///< Depth points that belong to limbs.
    std::span<const float> explained;         ///< Distance of each to whatever else may explain it, metres.
    int evaluations = 160;
    Generator generator;

    LimbPose pose;                     ///< Out.
    std::array<LimbPose, 3> starts{};  ///< Out: the best starts that differ, best first.

    [[nodiscard]] bool isValid() const {
        return cloud != nullptr && silhouette != nullptr && torso != nullptr && points.size() == explained.size();
    }
    void run();
    /// The cost of a pose, as the search sees it.
    [[nodiscard]] float evaluate(const LimbPose& candidate) const;

  private:
    [[nodiscard]] LimbPose along(const Eigen::Vector3f& upper, const Eigen::Vector3f& lower) const;
    void tryPose(const LimbPose& candidate);
    void trySeed(const LimbPose& candidate);
    void seedFromPoints();
    void seedFromTip(const Eigen::Vector3f& tip);
    void refine(int steps, float widest);
    [[nodiscard]] float boneCost(const LimbPose& candidate) const;
    [[nodiscard]] float bodyCost(const LimbPose& candidate) const;
};

}  // namespace cheval::fitting::tracking

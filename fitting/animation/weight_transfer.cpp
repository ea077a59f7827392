#include "fitting/animation/weight_transfer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fitting/point_tree.h"
#include "fitting/skeleton.h"

namespace cheval::fitting {

namespace {

enum class Limb : std::uint8_t { trunk, leftArm, rightArm, leftLeg, rightLeg };

constexpr Limb limbOf(Joint joint) {
    switch (joint) {
        case Joint::leftShoulder:
        case Joint::leftElbow:
        case Joint::leftHand:
            return Limb::leftArm;
        case Joint::rightShoulder:
        case Joint::rightElbow:
        case Joint::rightHand:
            return Limb::rightArm;
        case Joint::leftHip:
        case Joint::leftKnee:
        case Joint::leftFoot:
            return Limb::leftLeg;
        case Joint::rightHip:
        case Joint::rightKnee:
        case Joint::rightFoot:
            return Limb::rightLeg;
        default:
            return Limb::trunk;
    }
}

constexpr std::size_t kLimbCount = 5;

// How much of a vertex belongs to each limb.
std::array<float, kLimbCount> limbShares(const SkinningWeights& weights) {
    std::array<float, kLimbCount> shares{};
    for (std::size_t k = 0; k < 4; ++k) {
        const auto joint = static_cast<Joint>(std::min<std::size_t>(weights.joint[k], kJointCount - 1));
        shares[static_cast<std::size_t>(limbOf(joint))] += weights.weight[k];
    }
    return shares;
}

// Two body vertices may be mixed when they share at least this much of a limb: around a joint neighbours do, across an
// armpit's gap or between the legs they do not.
constexpr float kSharedLimb = 0.25F;

bool sameLimb(const std::array<float, kLimbCount>& a, const std::array<float, kLimbCount>& b) {
    float shared = 0.0F;
    for (std::size_t i = 0; i < kLimbCount; ++i)
        shared += std::min(a[i], b[i]);
    return shared >= kSharedLimb;
}

// The four largest of the summed bone weights, scaled to sum 1; lower joint first among equals.
SkinningWeights largestFour(const std::array<double, kJointCount>& sums) {
    std::array<std::size_t, kJointCount> order{};
    for (std::size_t i = 0; i < kJointCount; ++i)
        order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sums[a] > sums[b]; });
    const double total = sums[order[0]] + sums[order[1]] + sums[order[2]] + sums[order[3]];
    SkinningWeights weights;
    for (std::size_t k = 0; k < 4; ++k) {
        const double weight = total > 0.0 ? sums[order[k]] / total : (k == 0 ? 1.0 : 0.0);
        weights.joint[k] = weight > 0.0 ? static_cast<std::uint8_t>(order[k]) : std::uint8_t{0};
        weights.weight[k] = static_cast<float>(weight);
    }
    return weights;
}

}  // namespace

std::vector<SkinningWeights> transferWeights(const RestMesh& body, std::span<const Eigen::Vector3f> positions,
                                             std::span<const Eigen::Vector3f> normals,
                                             const WeightTransferOptions& options) {
    std::vector<SkinningWeights> result;
    const std::size_t bodyVertices = body.positions.size();
    if (bodyVertices == 0 || body.normals.size() != bodyVertices || body.weights.size() != bodyVertices ||
        normals.size() != positions.size()) {
        return result;
    }
    const PointTree tree(body.positions);
    // Enough to find others behind a patch that faces the wrong way.
    const std::size_t asked = std::min(bodyVertices, options.neighbours * 8);
    std::vector<std::uint32_t> found(asked);
    std::vector<float> squaredDistances(asked);

    result.reserve(positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const std::size_t count = tree.nearest(positions[v], found, squaredDistances);
        const auto faces = [&](std::uint32_t i) { return body.normals[i].dot(normals[v]) > 0.0F; };
        std::size_t nearest = 0;
        while (nearest < count && !faces(found[nearest]))
            ++nearest;
        const bool noneFaces = nearest == count;
        if (noneFaces) nearest = 0;  // A lining, or a fold: the nearest of all.
        const auto limb = limbShares(body.weights[found[nearest]]);

        std::array<double, kJointCount> sums{};
        std::size_t taken = 0;
        for (std::size_t k = nearest; k < count && taken < options.neighbours; ++k) {
            const std::uint32_t i = found[k];
            if (!noneFaces && !faces(i)) continue;
            const SkinningWeights& weights = body.weights[i];
            if (!sameLimb(limb, limbShares(weights))) continue;
            // A millimetre keeps a vertex that lies on the body from drowning out its neighbours.
            const double influence = 1.0 / (std::sqrt(static_cast<double>(squaredDistances[k])) + 1e-3);
            for (std::size_t b = 0; b < 4; ++b) {
                if (weights.joint[b] < kJointCount) {
                    sums[weights.joint[b]] += influence * static_cast<double>(weights.weight[b]);
                }
            }
            ++taken;
        }
        result.push_back(largestFour(sums));
    }
    return result;
}

}  // namespace cheval::fitting

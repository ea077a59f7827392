#include "fitting/layering/cage_binding.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "fitting/point_tree.h"

namespace cheval::fitting {

namespace {

// A triangle that faces the right way but lies so much farther than the nearest one is on the other side of the limb:
// the vertex belongs to a lining, whose normals look inwards.
constexpr float kFarSide = 0.04F;  // metres

struct Candidate {
    std::uint32_t triangle = 0;
    Eigen::Vector3f a, b, c;
    Eigen::Vector3f centre;
    Eigen::Vector3f normal;
    float radius = 0.0F;
};

// The triangles that a garment can hang on, midway between its cages.
std::vector<Candidate> candidatesOf(const CagePair& cages, std::span<const std::uint8_t> covered) {
    std::vector<Candidate> candidates;
    candidates.reserve(cages.triangles.size());
    for (std::size_t i = 0; i < cages.triangles.size(); ++i) {
        const Triangle& t = cages.triangles[i];
        if (covered[t.a] == 0 || covered[t.b] == 0 || covered[t.c] == 0) continue;
        Candidate candidate;
        candidate.triangle = static_cast<std::uint32_t>(i);
        candidate.a = 0.5F * (cages.inner[t.a] + cages.outer[t.a]);
        candidate.b = 0.5F * (cages.inner[t.b] + cages.outer[t.b]);
        candidate.c = 0.5F * (cages.inner[t.c] + cages.outer[t.c]);
        candidate.centre = (candidate.a + candidate.b + candidate.c) / 3.0F;
        candidate.radius = std::sqrt(
            std::max({(candidate.a - candidate.centre).squaredNorm(), (candidate.b - candidate.centre).squaredNorm(),
                      (candidate.c - candidate.centre).squaredNorm()}));
        const Eigen::Vector3f normal = (candidate.b - candidate.a).cross(candidate.c - candidate.a);
        candidate.normal = normal.norm() > 0.0F ? Eigen::Vector3f(normal.normalized()) : Eigen::Vector3f::Zero();
        candidates.push_back(candidate);
    }
    return candidates;
}

struct Nearest {
    const Candidate* candidate = nullptr;
    float distance = std::numeric_limits<float>::max();

    void offer(const Candidate& other, float away) {
        // Of two that share an edge the first, in whatever order they come.
        if (candidate != nullptr && (away > distance || (away == distance && &other > candidate))) return;
        candidate = &other;
        distance = away;
    }
};

/// Finds the candidate for a point, nearest centres first. Thread-bound.
class CandidateSearch {
  public:
    explicit CandidateSearch(std::span<const Candidate> candidates)
        : candidates_(candidates), centres_(centresOf(candidates)), tree_(centres_) {
        for (const Candidate& candidate : candidates) {
            largest_ = std::max(largest_, candidate.radius);
        }
    }

    /// The nearest that looks the way of `normal`, unless it is so much farther than the nearest of all that the point
    /// belongs to a lining.
    const Candidate& find(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
        Nearest any;
        Nearest facing;
        for (std::size_t asked = std::min(kFirstAsked, candidates_.size()), looked = 0;; asked *= 4) {
            asked = std::min(asked, candidates_.size());
            places_.resize(asked);
            squaredDistances_.resize(asked);
            const std::size_t count = tree_.nearest(point, places_, squaredDistances_);
            for (; looked < count; ++looked) {
                const Candidate& candidate = candidates_[places_[looked]];
                // Those left are farther than this.
                const float least = std::sqrt(squaredDistances_[looked]) - largest_;
                if (least > std::min(facing.distance, any.distance + kFarSide)) return chosen(any, facing);
                const float away = distanceTo(candidate, point);
                any.offer(candidate, away);
                if (candidate.normal.dot(normal) > 0.0F) facing.offer(candidate, away);
            }
            if (asked == candidates_.size()) return chosen(any, facing);
        }
    }

  private:
    static constexpr std::size_t kFirstAsked = 32;

    static std::vector<Eigen::Vector3f> centresOf(std::span<const Candidate> candidates) {
        std::vector<Eigen::Vector3f> centres;
        centres.reserve(candidates.size());
        for (const Candidate& candidate : candidates) {
            centres.push_back(candidate.centre);
        }
        return centres;
    }
    static float distanceTo(const Candidate& candidate, const Eigen::Vector3f& point) {
        const Eigen::Vector3f weights = nearestBarycentric(point, candidate.a, candidate.b, candidate.c);
        return (weights[0] * candidate.a + weights[1] * candidate.b + weights[2] * candidate.c - point).norm();
    }
    [[nodiscard]] const Candidate& chosen(const Nearest& any, const Nearest& facing) const {
        const bool lining = facing.distance > any.distance + kFarSide;
        if (facing.candidate != nullptr && !lining) return *facing.candidate;
        return any.candidate != nullptr ? *any.candidate : candidates_.front();  // Else the point is no number.
    }

    std::span<const Candidate> candidates_;
    std::vector<Eigen::Vector3f> centres_;
    PointTree tree_;
    float largest_ = 0.0F;
    std::vector<std::uint32_t> places_;
    std::vector<float> squaredDistances_;
};

Eigen::Vector3f blend(std::span<const Eigen::Vector3f> cage, const Triangle& t, const Eigen::Vector3f& weights) {
    return weights[0] * cage[t.a] + weights[1] * cage[t.b] + weights[2] * cage[t.c];
}

}  // namespace

Eigen::Vector3f nearestBarycentric(const Eigen::Vector3f& point, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                   const Eigen::Vector3f& c) {
    // Voronoi regions of the triangle (Ericson, Real-Time Collision Detection, 5.1.5).
    const Eigen::Vector3f ab = b - a;
    const Eigen::Vector3f ac = c - a;
    const Eigen::Vector3f ap = point - a;
    const float d1 = ab.dot(ap);
    const float d2 = ac.dot(ap);
    if (d1 <= 0.0F && d2 <= 0.0F) return {1, 0, 0};
    const Eigen::Vector3f bp = point - b;
    const float d3 = ab.dot(bp);
    const float d4 = ac.dot(bp);
    if (d3 >= 0.0F && d4 <= d3) return {0, 1, 0};
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F && d1 - d3 > 0.0F) {
        const float v = d1 / (d1 - d3);
        return {1.0F - v, v, 0};
    }
    const Eigen::Vector3f cp = point - c;
    const float d5 = ab.dot(cp);
    const float d6 = ac.dot(cp);
    if (d6 >= 0.0F && d5 <= d6) return {0, 0, 1};
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F && d2 - d6 > 0.0F) {
        const float w = d2 / (d2 - d6);
        return {1.0F - w, 0, w};
    }
    const float va = d3 * d6 - d5 * d4;
    const float along = (d4 - d3) + (d5 - d6);
    if (va <= 0.0F && d4 - d3 >= 0.0F && d5 - d6 >= 0.0F && along > 0.0F) {
        const float w = (d4 - d3) / along;
        return {0, 1.0F - w, w};
    }
    const float sum = va + vb + vc;
    if (!(sum > 0.0F)) return {1, 0, 0};  // No area: any corner is as near as makes no difference.
    return {va / sum, vb / sum, vc / sum};
}

std::vector<CageBinding> bindToCages(const CagePair& cages, std::span<const std::uint8_t> covered,
                                     std::span<const Eigen::Vector3f> positions,
                                     std::span<const Eigen::Vector3f> normals) {
    std::vector<CageBinding> bindings;
    const std::vector<Candidate> candidates = candidatesOf(cages, covered);
    if (candidates.empty()) return bindings;
    CandidateSearch search(candidates);
    bindings.reserve(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Eigen::Vector3f& point = positions[i];
        const Candidate& candidate = search.find(point, normals[i]);
        CageBinding binding;
        binding.triangle = candidate.triangle;
        binding.barycentric = nearestBarycentric(point, candidate.a, candidate.b, candidate.c);
        const Triangle& triangle = cages.triangles[binding.triangle];
        const Eigen::Vector3f inside = blend(cages.inner, triangle, binding.barycentric);
        const Eigen::Vector3f across = blend(cages.outer, triangle, binding.barycentric) - inside;
        if (across.squaredNorm() > 1e-12F) {
            binding.betweenCages = std::clamp((point - inside).dot(across) / across.squaredNorm(), 0.0F, 1.0F);
        }
        binding.residual = point - (inside + binding.betweenCages * across);
        bindings.push_back(binding);
    }
    return bindings;
}

void evaluateBindings(const CagePair& cages, std::span<const Eigen::Matrix3f> vertexTransforms,
                      std::span<const CageBinding> bindings, std::span<Eigen::Vector3f> positions) {
    for (std::size_t i = 0; i < bindings.size(); ++i) {
        const CageBinding& binding = bindings[i];
        const Triangle& t = cages.triangles[binding.triangle];
        const Eigen::Vector3f& b = binding.barycentric;
        const Eigen::Vector3f inside = blend(cages.inner, t, b);
        const Eigen::Vector3f outside = blend(cages.outer, t, b);
        const Eigen::Matrix3f turn =
            b[0] * vertexTransforms[t.a] + b[1] * vertexTransforms[t.b] + b[2] * vertexTransforms[t.c];
        positions[i] = inside + binding.betweenCages * (outside - inside) + turn * binding.residual;
    }
}

}  // namespace cheval::fitting

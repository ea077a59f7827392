#include "fitting/body/trunk_rings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cheval::fitting {

namespace {

// Between the crotch and the shoulders, as shares of the way from the hips' joints to the neck's; below the hips'
// joints the thighs still are one outline with the trunk.
constexpr float kLowest = -0.10F;
constexpr float kHighest = 0.93F;

struct Crossing {
    std::uint32_t a = 0, b = 0;
    float share = 0.0F;  ///< Of b.
    Eigen::Vector3f at = Eigen::Vector3f::Zero();
};
struct Segment {
    Crossing from, to;
};

bool isArm(const SkinningWeights& weights) {
    float arm = 0.0F;
    for (std::size_t k = 0; k < 4; ++k) {
        const auto joint = static_cast<Joint>(weights.joint[k]);
        if (joint >= Joint::leftShoulder && joint <= Joint::rightHand) arm += weights.weight[k];
    }
    return arm >= 0.5F;
}

std::vector<Segment> cutAt(const Body& body, float height) {
    std::vector<Segment> segments;
    for (const Triangle& t : body.mesh.triangles) {
        if (isArm(body.mesh.weights[t.a]) || isArm(body.mesh.weights[t.b]) || isArm(body.mesh.weights[t.c])) continue;
        std::array<Crossing, 2> crossings{};
        std::size_t count = 0;
        for (const auto& [a, b] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
            const Eigen::Vector3f& p = body.mesh.positions[a];
            const Eigen::Vector3f& q = body.mesh.positions[b];
            if ((p.y() <= height) == (q.y() <= height) || count == 2) continue;
            const float share = (height - p.y()) / (q.y() - p.y());
            crossings[count++] = {.a = a, .b = b, .share = share, .at = p + share * (q - p)};
        }
        if (count == 2) segments.push_back({crossings[0], crossings[1]});
    }
    return segments;
}

}  // namespace

TrunkRings::TrunkRings(const Body& body) : rest_(kSamples, Eigen::Vector3f::Zero()), valid_(kSamples, 0) {
    basis_.setZero(static_cast<Eigen::Index>(3 * kSamples), static_cast<Eigen::Index>(kShapeParameterCount));
    if (body.shapes.mesh.cols() != static_cast<Eigen::Index>(kShapeParameterCount)) return;
    const float hips = body.joints[index(Joint::leftHip)].y();
    const float neck = body.joints[index(Joint::neck)].y();
    for (std::size_t level = 0; level < kLevels; ++level) {
        const float share =
            kLowest + (kHighest - kLowest) * static_cast<float>(level) / static_cast<float>(kLevels - 1);
        const float height = hips + share * (neck - hips);
        const std::vector<Segment> segments = cutAt(body, height);
        if (segments.empty()) continue;
        float front = -1e9F;
        float back = 1e9F;
        for (const Segment& segment : segments) {
            front = std::max(front, segment.from.at.z());
            back = std::min(back, segment.from.at.z());
        }
        const Eigen::Vector2f centre(0.0F, 0.5F * (front + back));
        for (std::size_t column = 0; column < kColumns; ++column) {
            const float angle =
                2.0F * std::numbers::pi_v<float> * static_cast<float>(column) / static_cast<float>(kColumns);
            const Eigen::Vector2f ray(std::sin(angle), std::cos(angle));
            float reach = 0.0F;
            const std::size_t at = sample(level, column);
            for (const Segment& segment : segments) {
                // Where the ray from the centre meets the segment; the outermost counts.
                const Eigen::Vector2f p(segment.from.at.x(), segment.from.at.z());
                const Eigen::Vector2f q(segment.to.at.x(), segment.to.at.z());
                const float sideP = ray.x() * (p - centre).y() - ray.y() * (p - centre).x();
                const float sideQ = ray.x() * (q - centre).y() - ray.y() * (q - centre).x();
                if ((sideP <= 0.0F) == (sideQ <= 0.0F)) continue;
                const float along = sideP / (sideP - sideQ);
                const float distance = (p + along * (q - p) - centre).dot(ray);
                if (distance <= reach) continue;
                reach = distance;
                valid_[at] = 1;
                rest_[at].setZero();
                auto rows = basis_.middleRows<3>(static_cast<Eigen::Index>(3 * at));
                rows.setZero();
                for (const auto& [crossing, part] :
                     {std::pair(&segment.from, 1.0F - along), std::pair(&segment.to, along)}) {
                    for (const auto& [vertex, weight] : {std::pair(crossing->a, part * (1.0F - crossing->share)),
                                                         std::pair(crossing->b, part * crossing->share)}) {
                        rest_[at] += weight * body.mesh.positions[vertex];
                        rows += weight * body.shapes.mesh.middleRows<3>(3 * static_cast<Eigen::Index>(vertex));
                    }
                }
            }
        }
    }
}

void TrunkRings::place(const ShapeParameters& parameters, std::vector<Eigen::Vector3f>& points) const {
    for (std::size_t i = 0; i < kSamples && i < points.size(); ++i)
        points[i] = rest_[i] + basis(i) * parameters;
}

Eigen::Vector3f TrunkRings::normal(const std::vector<Eigen::Vector3f>& points, std::size_t at) const {
    const std::size_t level = at / kColumns;
    const std::size_t column = at % kColumns;
    const auto pick = [&](std::size_t otherLevel, std::size_t otherColumn) -> const Eigen::Vector3f& {
        const std::size_t other = sample(otherLevel, otherColumn);
        return points[valid(other) ? other : at];
    };
    const Eigen::Vector3f round = pick(level, column + 1) - pick(level, column + kColumns - 1);
    const Eigen::Vector3f up =
        pick(std::min(level + 1, kLevels - 1), column) - pick(level == 0 ? 0 : level - 1, column);
    const Eigen::Vector3f across = round.cross(up);
    const float length = across.norm();
    return length > 1e-9F ? Eigen::Vector3f(across / length) : Eigen::Vector3f::Zero();
}

}  // namespace cheval::fitting

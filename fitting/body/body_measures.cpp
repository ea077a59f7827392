#include "fitting/body/body_measures.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cheval::fitting {

namespace {

// Where landmarks are looked for on the mannequin, as shares of its stature.
constexpr float kWaistLevel = 0.632F;  // Natural waist, midway between lowest rib and iliac crest.
constexpr float kUsualWaist = 0.46F;   // From the crotch to the neck's joint.
constexpr float kRib = 0.655F;
constexpr float kIliacCrest = 0.609F;
constexpr float kBustLowest = 0.69F;
constexpr float kBustHighest = 0.76F;
constexpr float kSeatLowest = 0.46F;
constexpr float kSeatHighest = 0.55F;

// Wrist on the way from elbow to palm: 0.146 of 0.146 + 0.044 statures (Drillis and Contini 1966), as the mannequin.
constexpr float kWristShare = 0.77F;
// Cuts across the neck, as shares of the way from the neck's joint to the chin's height.
constexpr std::array kNeckCuts = {0.35F, 0.5F, 0.65F, 0.8F, 0.95F};
// A thigh is measured this far below the crotch, as a share of the inside leg.
constexpr float kBelowCrotch = 0.04F;

float shareOf(const SkinningWeights& weights, Joint first, Joint last) {
    float share = 0.0F;
    for (std::size_t k = 0; k < 4; ++k) {
        const auto joint = static_cast<Joint>(weights.joint[k]);
        if (joint >= first && joint <= last) share += weights.weight[k];
    }
    return share;
}

// The vertex that reaches farthest in a direction, of those that count.
template <typename Counts>
std::uint32_t farthest(const Body& body, const Eigen::Vector3f& direction, const Counts& counts) {
    std::uint32_t best = 0;
    float reach = -1e9F;
    for (std::uint32_t v = 0; v < body.mesh.positions.size(); ++v) {
        const Eigen::Vector3f& p = body.mesh.positions[v];
        if (!counts(v, p) || p.dot(direction) <= reach) continue;
        reach = p.dot(direction);
        best = v;
    }
    return best;
}

}  // namespace

float tapeLength(std::vector<Eigen::Vector2f>& points, std::vector<Eigen::Vector2f>& hull) {
    // Andrew's monotone chain.
    if (points.size() < 2) return 0.0F;
    std::sort(points.begin(), points.end(), [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
        return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
    });
    hull.clear();
    const auto add = [&hull](const Eigen::Vector2f& p, std::size_t least) {
        while (hull.size() >= least) {
            const Eigen::Vector2f& a = hull[hull.size() - 2];
            const Eigen::Vector2f& b = hull.back();
            const Eigen::Vector2f ab = b - a;
            const Eigen::Vector2f ap = p - a;
            if (ab.x() * ap.y() - ab.y() * ap.x() > 0.0F) break;
            hull.pop_back();
        }
        hull.push_back(p);
    };
    for (const Eigen::Vector2f& p : points)
        add(p, 2);
    const std::size_t lower = hull.size() + 1;
    for (std::size_t i = points.size() - 1; i-- > 0;)
        add(points[i], lower);
    float length = 0.0F;
    for (std::size_t i = 1; i < hull.size(); ++i)
        length += (hull[i] - hull[i - 1]).norm();
    return length;
}

BodyMeasures::BodyMeasures(const Body& body) : body_(body) {
    const RestMesh& mesh = body.mesh;
    float height = 0.0F;
    for (const Eigen::Vector3f& p : mesh.positions)
        height = std::max(height, p.y());
    const auto arm = [&](std::uint32_t v) { return shareOf(mesh.weights[v], Joint::leftShoulder, Joint::rightHand); };
    const auto onTrunk = [&](std::uint32_t v) { return arm(v) < 0.5F; };
    const auto within = [&](const Eigen::Vector3f& p, float low, float high) {
        return p.y() > low * height && p.y() < high * height;
    };
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        if (!onTrunk(t.a) || !onTrunk(t.b) || !onTrunk(t.c)) continue;
        trunk_.push_back(i);
        const float y = mesh.positions[t.a].y();
        const Eigen::Vector3f& neck = body.joints[index(Joint::neck)];
        if (y > neck.y() - 0.02F * height && std::abs(mesh.positions[t.a].x()) < 0.06F * height) neck_.push_back(i);
        const auto thigh = [&](std::uint32_t v) {
            return shareOf(mesh.weights[v], Joint::leftHip, Joint::leftKnee) > 0.3F || mesh.positions[v].x() > 0.0F;
        };
        if (y < 0.5F * height && thigh(t.a) && thigh(t.b) && thigh(t.c)) leftThigh_.push_back(i);
    }
    const auto any = [](std::uint32_t, const Eigen::Vector3f&) { return true; };
    crown_ = farthest(body, Eigen::Vector3f::UnitY(), any);
    chin_ = farthest(body, {0.0F, -0.6F, 0.8F}, [&](std::uint32_t v, const Eigen::Vector3f& p) {
        return shareOf(mesh.weights[v], Joint::head, Joint::head) > 0.5F && std::abs(p.x()) < 1e-4F;
    });
    crotch_ = farthest(body, -Eigen::Vector3f::UnitY(), [&](std::uint32_t, const Eigen::Vector3f& p) {
        return std::abs(p.x()) < 1e-4F && p.y() > 0.2F * height;
    });
    bust_ = farthest(body, Eigen::Vector3f::UnitZ(), [&](std::uint32_t v, const Eigen::Vector3f& p) {
        return onTrunk(v) && within(p, kBustLowest, kBustHighest) && p.x() > 0.015F * height;
    });
    seat_ = farthest(body, -Eigen::Vector3f::UnitZ(), [&](std::uint32_t v, const Eigen::Vector3f& p) {
        return onTrunk(v) && within(p, kSeatLowest, kSeatHighest) && p.x() > 0.0F;
    });
    // Rib and crest on the side of the trunk.
    const auto atSide = [&](float level) {
        std::uint32_t best = 0;
        float nearest = 1e9F;
        for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
            const Eigen::Vector3f& p = mesh.positions[v];
            if (!onTrunk(v) || p.x() < 0.05F * height) continue;
            const float away = std::abs(p.y() - level * height) + 0.5F * std::abs(p.z());
            if (away >= nearest) continue;
            nearest = away;
            best = v;
        }
        return best;
    };
    aboveWaist_ = atSide(kRib);
    belowWaist_ = atSide(kIliacCrest);
    const float below = mesh.positions[belowWaist_].y();
    const float above = mesh.positions[aboveWaist_].y();
    waistShare_ = above > below ? (kWaistLevel * height - below) / (above - below) : 0.5F;
    wristShare_ = kWristShare;
    points_.reserve(2 * trunk_.size());
    hull_.reserve(4 * trunk_.size());
}

BodyMeasures::Levels BodyMeasures::levels(std::span<const Eigen::Vector3f> positions) const {
    return {
        .chest = positions[bust_].y(),
        .waist = positions[belowWaist_].y() + waistShare_ * (positions[aboveWaist_].y() - positions[belowWaist_].y()),
        .hips = positions[seat_].y()};
}

BodyMeasures::Cut BodyMeasures::cut(std::span<const Eigen::Vector3f> positions,
                                    std::span<const std::uint32_t> triangles, const Eigen::Vector3f& point,
                                    const Eigen::Vector3f& normal) const {
    points_.clear();
    // The plane's own axes: across the body, and towards the front.
    const Eigen::Vector3f ahead = Eigen::Vector3f::UnitX().cross(normal).normalized();
    float nearest = 1e9F;
    float farthestZ = -1e9F;
    const auto cross = [&](const Eigen::Vector3f& p, float dp, const Eigen::Vector3f& q, float dq) {
        if ((dp <= 0.0F) == (dq <= 0.0F) || points_.size() == points_.capacity()) return;
        const Eigen::Vector3f at = p + (q - p) * (dp / (dp - dq));
        points_.emplace_back(at.x(), (at - point).dot(ahead));
        nearest = std::min(nearest, at.z());
        farthestZ = std::max(farthestZ, at.z());
    };
    for (const std::uint32_t i : triangles) {
        const Triangle& t = body_.mesh.triangles[i];
        const Eigen::Vector3f& a = positions[t.a];
        const Eigen::Vector3f& b = positions[t.b];
        const Eigen::Vector3f& c = positions[t.c];
        const float da = (a - point).dot(normal);
        const float db = (b - point).dot(normal);
        const float dc = (c - point).dot(normal);
        if ((da <= 0.0F) == (db <= 0.0F) && (db <= 0.0F) == (dc <= 0.0F)) continue;
        cross(a, da, b, db);
        cross(b, db, c, dc);
        cross(c, dc, a, da);
    }
    if (points_.size() < 3) return {};
    return {.girth = tapeLength(points_, hull_), .depth = farthestZ - nearest};
}

MeasuredParameters BodyMeasures::measure(std::span<const Eigen::Vector3f> positions,
                                         std::span<const Eigen::Vector3f, kJointCount> joints) const {
    MeasuredParameters result;
    const auto put = [&result](ShapeParameter parameter, float value) {
        result[static_cast<Eigen::Index>(index(parameter))] = value;
    };
    const auto level = [](float y) { return Eigen::Vector3f(0.0F, y, 0.0F); };
    const Levels at = levels(positions);
    const Eigen::Vector3f up = Eigen::Vector3f::UnitY();
    const Cut chest = cut(positions, trunk_, level(at.chest), up);
    const Cut waist = cut(positions, trunk_, level(at.waist), up);
    const Cut hips = cut(positions, trunk_, level(at.hips), up);
    put(ShapeParameter::stature, positions[crown_].y());
    put(ShapeParameter::chestGirth, chest.girth);
    put(ShapeParameter::waistGirth, waist.girth);
    put(ShapeParameter::hipGirth, hips.girth);
    const Eigen::Vector3f& neck = joints[index(Joint::neck)];
    const Eigen::Vector3f throat(0.0F, positions[chin_].y(), 0.5F * (neck.z() + joints[index(Joint::head)].z()));
    const Eigen::Vector3f axis = (throat - neck).normalized();
    float smallest = 0.0F;
    for (const float share : kNeckCuts) {
        const float girth = cut(positions, neck_, neck + share * (throat - neck), axis).girth;
        if (girth > 0.0F && (smallest == 0.0F || girth < smallest)) smallest = girth;
    }
    put(ShapeParameter::neckGirth, smallest);
    put(ShapeParameter::shoulderBreadth,
        (joints[index(Joint::leftShoulder)] - joints[index(Joint::rightShoulder)]).norm());
    put(ShapeParameter::armLength,
        (joints[index(Joint::leftElbow)] - joints[index(Joint::leftShoulder)]).norm() +
            wristShare_ * (joints[index(Joint::leftHand)] - joints[index(Joint::leftElbow)]).norm());
    const float crotch = positions[crotch_].y();
    put(ShapeParameter::insideLeg, crotch);
    put(ShapeParameter::headHeight, positions[crown_].y() - positions[chin_].y());
    put(ShapeParameter::chestDepth, chest.depth);
    put(ShapeParameter::waistDepth, waist.depth);
    put(ShapeParameter::hipDepth, hips.depth);
    put(ShapeParameter::thighGirth, cut(positions, leftThigh_, level((1.0F - kBelowCrotch) * crotch), up).girth);
    put(ShapeParameter::waistRise, at.waist - (crotch + kUsualWaist * (neck.y() - crotch)));
    return result;
}

}  // namespace cheval::fitting

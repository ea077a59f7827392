#include "fitting/tracking/limb_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/tracking/articulated_body.h"

namespace cheval::fitting::tracking {
namespace {

/// Beyond this a point or a bone is simply wrong, however far.
constexpr float kCap = 0.14F;
/// What the share of unexplained points weighs against bones in the air.
constexpr float kPointWeight = 2.5F;

float squareCapped(float metres) {
    const float capped = std::min(std::abs(metres), kCap) / kCap;
    return capped * capped;
}

/// Directions as (left, up, forward) of the left arm: outwards is +left; mirrored for the right.
constexpr float kArmSeeds[][6] = {
    {0.15F, -1.0F, 0.0F, 0.1F, -1.0F, 0.1F},   // hanging
    {0.7F, -0.7F, 0.0F, 0.7F, -0.7F, 0.1F},    // A-pose
    {1.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F},      // T-pose
    {0.7F, 0.7F, 0.0F, 0.6F, 0.8F, 0.0F},      // V
    {0.5F, -0.8F, 0.2F, 0.3F, 0.9F, 0.3F},     // hand raised beside the shoulder
    {1.0F, -0.1F, 0.1F, 0.0F, 1.0F, 0.2F},     // elbow out, forearm up
    {1.0F, 0.0F, 0.0F, 0.0F, -1.0F, 0.1F},     // elbow out, forearm hanging
    {0.7F, -0.7F, -0.2F, -0.8F, -0.4F, 0.3F},  // hand on hip
    {0.3F, -0.9F, 0.1F, 0.0F, -0.1F, 1.0F},    // forearm forwards
    {0.3F, -0.8F, 0.3F, -0.8F, 0.2F, 0.6F},    // forearm across the chest
    {0.1F, -0.2F, 1.0F, 0.0F, 0.0F, 1.0F},     // pointing at the glass
    {0.3F, 0.3F, 0.8F, -0.2F, 0.8F, 0.4F},     // reaching up and forwards
    {0.4F, -0.4F, 0.8F, -0.2F, 0.8F, 0.3F},    // elbow forwards, forearm up
};
constexpr float kLegSeeds[][6] = {
    {0.05F, -1.0F, 0.0F, 0.03F, -1.0F, -0.2F},    // standing
    {0.3F, -1.0F, 0.0F, 0.25F, -1.0F, -0.1F},     // apart
    {0.05F, -0.95F, 0.3F, 0.03F, -0.9F, -0.45F},  // stepping
    {0.0F, -0.5F, 0.9F, 0.0F, -1.0F, 0.0F},       // sitting
};

}  // namespace

LimbModel armModel(float stature) {
    const BodyLengths size = usualLengths(stature);
    return {.kind = LimbKind::arm,
            .upperLength = size[index(BodyLength::upperArm)],
            .lowerLength = size[index(BodyLength::forearm)],
            .upperRadius = 0.026F * stature,
            .lowerRadius = 0.020F * stature,
            .beyond = 0.045F * stature};
}

LimbModel legModel(float stature) {
    const BodyLengths size = usualLengths(stature);
    return {.kind = LimbKind::leg,
            .upperLength = size[index(BodyLength::thigh)],
            .lowerLength = size[index(BodyLength::shank)],
            .upperRadius = 0.045F * stature,
            .lowerRadius = 0.030F * stature,
            .beyond = 0.02F * stature};
}

LimbSkin::LimbSkin(const LimbModel& model, const Eigen::Vector3f& root, const LimbPose& pose) {
    const Eigen::Vector3f forearm = pose.end - pose.middle;
    const Eigen::Vector3f whole = forearm * (1.0F + model.beyond / std::max(forearm.norm(), 1e-4F));
    const Eigen::Vector3f upper = pose.middle - root;
    upper_ = {root, upper, 1.0F / std::max(upper.squaredNorm(), 1e-8F), model.upperRadius};
    lower_ = {pose.middle, whole, 1.0F / std::max(whole.squaredNorm(), 1e-8F), model.lowerRadius};
}

LimbPose LimbFitJob::along(const Eigen::Vector3f& upper, const Eigen::Vector3f& lower) const {
    LimbPose candidate;
    candidate.middle = root + upper.normalized() * model.upperLength;
    candidate.end = candidate.middle + lower.normalized() * model.lowerLength;
    return candidate;
}

float LimbFitJob::boneCost(const LimbPose& candidate) const {
    constexpr int kSamples = 6;
    float cost = 0.0F;
    for (int k = 1; k <= 2 * kSamples; ++k) {
        const bool upper = k <= kSamples;
        const float t = static_cast<float>(upper ? k : k - kSamples) / kSamples;
        const Eigen::Vector3f from = upper ? root : candidate.middle;
        const Eigen::Vector3f to = upper ? candidate.middle : candidate.end;
        const Eigen::Vector3f cell = cloud->toCell(from + t * (to - from));
        const int column = static_cast<int>(std::lround(cell.x()));
        const int row = static_cast<int>(std::lround(cell.y()));
        if (cell.z() <= 0.0F || column < 0 || row < 0 || column >= kCloudWidth || row >= kCloudHeight) {
            // Outside the picture nothing speaks for or against.
            cost += 0.05F;
            continue;
        }
        if (!silhouette->contains(column, row)) {
            cost += 1.0F;
            continue;
        }
        const std::size_t i = cellIndex(column, row);
        if (silhouette->inside[i] == 0) {
            // Depth farther than the bone: empty air. No reading: perhaps a shadow or a dark sleeve.
            const bool unread = cloud->depth[i] <= 0.0F;
            const float away = silhouette->outside[i] * cloud->cellSize(cell.z());
            cost += (unread ? 0.7F : 1.0F) * std::min(1.0F, 0.2F + away / 0.08F);
            continue;
        }
        const float radius = upper ? model.upperRadius : model.lowerRadius;
        const float behind = silhouette->surface[i] - (cell.z() - radius);
        if (behind > 0.0F) {
            cost += squareCapped(behind);  // The bone hangs in the air before the surface.
        } else {
            cost += 0.55F * squareCapped(0.6F * std::max(0.0F, -behind - 0.02F));  // It is hidden, or too deep.
        }
    }
    return cost / (2.0F * kSamples);
}

float LimbFitJob::bodyCost(const LimbPose& candidate) const {
    const Eigen::Vector3f upper = (candidate.middle - root).normalized();
    const Eigen::Vector3f lower = (candidate.end - candidate.middle).normalized();
    const float outwards = side == Side::left ? 1.0F : -1.0F;
    float cost = 0.0F;
    const float bend = upper.dot(lower);
    if (model.kind == LimbKind::arm) {
        cost += 2.0F * std::max(0.0F, -bend - 0.75F);                              // forearm folded into the arm
        cost += 0.8F * std::max(0.0F, -upper.dot(torso->forward) - 0.45F);         // elbow far behind the back
        cost += 0.6F * std::max(0.0F, -outwards * upper.dot(torso->left) - 0.4F);  // elbow across the chest
        // The forearm bends forwards and up, hardly ever backwards.
        const Eigen::Vector3f fold = lower - bend * upper;
        cost += 0.25F * std::max(0.0F, -fold.dot(torso->forward) - 0.1F);
    } else {
        const Eigen::Vector3f down = -torso->up;
        cost += 0.9F * std::max(0.0F, 1.0F - upper.dot(down) - 0.01F);
        cost += 0.5F * std::max(0.0F, 1.0F - bend - 0.02F);
        // Knees bend one way, and a shank slants backwards from the knee (the ankle lies behind its axis).
        const Eigen::Vector3f fold = lower - bend * upper;
        cost += 0.6F * std::max(0.0F, fold.dot(torso->forward) - 0.02F);
        cost += 0.8F * std::max(0.0F, -outwards * (candidate.end - root).dot(torso->left) - 0.04F);
        cost += 0.5F * std::max(0.0F, 0.02F - candidate.end.y()) / 0.05F;
    }
    if (previous != nullptr && previous->valid) {
        cost += 0.10F * squareCapped(0.5F * (candidate.end - previous->end).norm());
        cost += 0.10F * squareCapped(0.5F * (candidate.middle - previous->middle).norm());
    }
    return cost;
}

float LimbFitJob::evaluate(const LimbPose& candidate) const {
    const float bones = boneCost(candidate) + bodyCost(candidate);
    if (bones > pose.cost) return bones;
    if (points.empty()) return bones;
    // As soon as the points alone are worse than what is known, the rest need not be looked at.
    const float perPoint = kPointWeight / static_cast<float>(points.size());
    const float most = (pose.cost - bones) / perPoint;
    const LimbSkin skin(model, root, candidate);
    float unexplained = 0.0F;
    for (std::size_t i = 0; i < points.size() && unexplained <= most; ++i) {
        unexplained += squareCapped(std::min(skin.distanceTo(points[i]), explained[i]));
    }
    return bones + perPoint * unexplained;
}

void LimbFitJob::tryPose(const LimbPose& candidate) {
    const float cost = evaluate(candidate);
    if (cost < pose.cost) {
        pose = candidate;
        pose.cost = cost;
        pose.valid = true;
    }
}

void LimbFitJob::trySeed(const LimbPose& candidate) {
    // The pool's worst stands in for the best in evaluate(), so that its early way out keeps what belongs in the pool.
    pose.cost = starts.back().cost;
    LimbPose start = candidate;
    start.cost = evaluate(candidate);
    start.valid = true;
    if (start.cost >= starts.back().cost) return;
    constexpr float kSame = 0.10F;
    std::size_t place = starts.size() - 1;
    for (std::size_t i = 0; i < starts.size(); ++i) {
        if (!starts[i].valid || (starts[i].end - start.end).norm() + (starts[i].middle - start.middle).norm() > kSame) {
            continue;
        }
        if (starts[i].cost <= start.cost) return;
        place = i;  // A better one of the same basin takes its place.
        break;
    }
    starts[place] = start;
    for (; place > 0 && starts[place].cost < starts[place - 1].cost; --place) {
        std::swap(starts[place], starts[place - 1]);
    }
}

void LimbFitJob::seedFromPoints() {
    // The points farthest from the root within reach may be the tip; another limb's may be among them, so three that
    // lie apart are tried.
    constexpr std::size_t kTips = 3;
    constexpr float kApart = 0.15F;
    const float reach = model.upperLength + model.lowerLength + model.beyond + 0.06F;
    std::array<const Eigen::Vector3f*, kTips> tips{};
    for (std::size_t k = 0; k < kTips; ++k) {
        float farthest = 0.12F;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const float away = (points[i] - root).norm();
            if (away > reach || away <= farthest || explained[i] < 0.05F) continue;
            bool apart = true;
            for (std::size_t other = 0; other < k; ++other) {
                apart &= tips[other] == nullptr || (*tips[other] - points[i]).norm() > kApart;
            }
            if (!apart) continue;
            farthest = away;
            tips[k] = &points[i];
        }
        if (tips[k] != nullptr) seedFromTip(*tips[k]);
    }
}

void LimbFitJob::seedFromTip(const Eigen::Vector3f& tip) {
    // The middle joint lies on a circle about the line from root to end.
    Eigen::Vector3f toEnd = tip + Eigen::Vector3f(0, 0, model.lowerRadius) - root;
    const float longest = 0.98F * (model.upperLength + model.lowerLength);
    const float length = std::min(std::max(0.12F, toEnd.norm() - model.beyond), longest);
    toEnd.normalize();
    const float a = model.upperLength;
    const float b = model.lowerLength;
    const float alongAxis = (a * a - b * b + length * length) / (2.0F * length);
    const float radius = std::sqrt(std::max(0.0F, a * a - alongAxis * alongAxis));
    const Eigen::Vector3f sideways = toEnd.unitOrthogonal();
    const Eigen::Vector3f other = toEnd.cross(sideways);
    constexpr int kAngles = 8;
    for (int k = 0; k < kAngles; ++k) {
        const float angle = static_cast<float>(k) * 6.2831853F / kAngles;
        const Eigen::Vector3f middle =
            root + toEnd * alongAxis + (sideways * std::cos(angle) + other * std::sin(angle)) * radius;
        trySeed(along(middle - root, root + toEnd * length - middle));
    }
}

void LimbFitJob::refine(int steps, float widest) {
    for (int k = 0; k < steps; ++k) {
        const float left = 1.0F - static_cast<float>(k) / static_cast<float>(steps);
        const float spread = widest * left * left + 0.04F;
        const Eigen::Vector3f upper = (pose.middle - root) / model.upperLength;
        const Eigen::Vector3f lower = (pose.end - pose.middle) / model.lowerLength;
        // Three kinds of step in turn: both bones, the lower alone, and the elbow with the hand kept in place.
        const Eigen::Vector3f first(generator.next(), generator.next(), generator.next());
        const Eigen::Vector3f second(generator.next(), generator.next(), generator.next());
        if (k % 3 == 0) {
            tryPose(along(upper + spread * first, lower + spread * second));
        } else if (k % 3 == 1) {
            tryPose(along(upper, lower + spread * second));
        } else {
            const Eigen::Vector3f moved = root + (upper + spread * first).normalized() * model.upperLength;
            tryPose(along(moved - root, pose.end - moved));
        }
    }
}

void LimbFitJob::run() {
    pose = LimbPose{};
    starts = {};
    const float outwards = side == Side::left ? 1.0F : -1.0F;
    const auto world = [&](float left, float up, float forward) -> Eigen::Vector3f {
        return torso->left * (left * outwards) + torso->up * up + torso->forward * forward;
    };
    if (previous != nullptr && previous->valid) {
        trySeed(along(previous->middle - root, previous->end - previous->middle));
    }
    const std::span<const float[6]> seeds =
        model.kind == LimbKind::arm ? std::span<const float[6]>(kArmSeeds) : std::span<const float[6]>(kLegSeeds);
    for (const auto& seed : seeds) {
        trySeed(along(world(seed[0], seed[1], seed[2]), world(seed[3], seed[4], seed[5])));
    }
    seedFromPoints();
    LimbPose best;
    for (const LimbPose& start : starts) {
        if (!start.valid) continue;
        pose = start;
        refine(evaluations / 6, 0.45F);
        if (!best.valid || pose.cost < best.cost) best = pose;
    }
    if (!best.valid) return;
    pose = best;
    refine(evaluations / 2, 0.35F);
}

}  // namespace cheval::fitting::tracking

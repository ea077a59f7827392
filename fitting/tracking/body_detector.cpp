#include "fitting/tracking/body_detector.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace cheval::fitting::tracking {
namespace {

/// What lies this near the floor is foot, not shank.
constexpr float kFootHeight = 0.09F;
constexpr int kArmEvaluations = 150;
constexpr int kLegEvaluations = 90;

/// How well everything but one limb explains the points: its partner's pose where there is one; before that, what lies
/// on the partner's side of the body is left to the partner.
void explainBy(const LimbModel& model, const Eigen::Vector3f& root, const LimbPose& other, const TorsoPose& torso,
               Side otherSide, std::span<const Eigen::Vector3f> points, std::vector<float>& explained) {
    explained.resize(points.size());
    const Eigen::Vector3f middle = 0.5F * (torso.hips[0] + torso.hips[1]);
    const LimbSkin skin(model, root, other);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (other.valid) {
            explained[i] = skin.distanceTo(points[i]);
        } else {
            const float across = (points[i] - middle).dot(torso.left) * (otherSide == Side::left ? 1.0F : -1.0F);
            explained[i] = across > 0.02F ? 0.0F : 1.0F;
        }
    }
}

LimbPose limbPose(const Eigen::Vector3f& middle, const Eigen::Vector3f& end) {
    return {.middle = middle, .end = end, .valid = true};
}

LimbDirections directions(const Eigen::Vector3f& root, const LimbPose& limb) {
    return {.upper = (limb.middle - root).normalized(), .lower = (limb.end - limb.middle).normalized()};
}

}  // namespace

BodyDetector::BodyDetector() {
    for (LimbPoints* limb : {&armPoints_, &legPoints_}) {
        limb->points.reserve(kMostPoints);
        limb->explained.reserve(kMostPoints);
    }
}

void BodyDetector::collectPoints(const View& view) {
    const Cloud& cloud = view.cloud;
    const Silhouette& s = view.silhouette;
    const TorsoPose& torso = view.torso;
    const float stature = torso.stature;
    const Eigen::Vector3f hip = 0.5F * (torso.hips[0] + torso.hips[1]);
    const Eigen::Vector3f shoulder = 0.5F * (torso.shoulders[0] + torso.shoulders[1]);
    const float trunkLength = (shoulder - hip).dot(torso.up);
    // Kind of a cell: 0 trunk or head, 1 arm, 2 leg.
    const auto kindOf = [&](std::size_t i) {
        const Eigen::Vector3f point = cloud.point(i);
        const Eigen::Vector3f fromHip = point - hip;
        const float height = fromHip.dot(torso.up) / trunkLength;  // 0 at the hips, 1 at the shoulders
        const float across = std::abs(fromHip.dot(torso.left));
        const float front = torso.surface[0] + torso.surface[1] * point.x() + torso.surface[2] * point.y();
        const float before = front - point.z();
        if ((point.head<2>() - torso.head.head<2>()).norm() < 0.085F * stature &&
            std::abs(point.z() - torso.head.z()) < 0.15F) {
            return 0;
        }
        if (height < -0.02F) {
            const float width = 0.115F * stature + 0.10F * std::max(0.0F, -height);
            if (across > width && height > -0.65F && s.limbReach[i] * cloud.cellSize(s.surface[i]) < 0.07F) return 1;
            if (before > 0.16F && height > -0.5F) return 1;
            return point.y() < kFootHeight ? 0 : 2;
        }
        // Half the trunk's width: hips, narrower waist, armpits.
        const float width = (height < 0.35F ? 0.100F : height < 0.9F ? 0.098F : 0.085F) * stature;
        if (height < 1.12F && across < width && before < 0.10F) return 0;
        return 1;
    };
    armPoints_.points.clear();
    legPoints_.points.clear();
    // Two passes, so that each limb kind is thinned evenly to what the search can afford.
    std::array<int, 3> counts{};
    for (int pass = 0; pass < 2; ++pass) {
        std::array<int, 3> met{};
        for (int row = s.top; row <= s.bottom; row += 2) {
            for (int column = s.left + (row / 2) % 2; column <= s.right; column += 2) {
                const std::size_t i = cellIndex(column, row);
                if (s.inside[i] == 0 || cloud.depth[i] <= 0.0F) continue;
                const auto kind = static_cast<std::size_t>(kindOf(i));
                if (kind == 0) continue;
                if (pass == 0) {
                    ++counts[kind];
                    continue;
                }
                const int stride = counts[kind] / static_cast<int>(kMostPoints) + 1;
                if (met[kind]++ % stride != 0) continue;
                auto& points = kind == 1 ? armPoints_.points : legPoints_.points;
                if (points.size() < kMostPoints) points.push_back(cloud.point(i));
            }
        }
    }
}

void BodyDetector::fitLimbs(const View& view, const LimbModel& model,
                            const std::array<Eigen::Vector3f, kSideCount>& roots, const Limbs& before, int evaluations,
                            Generator& generator, LimbPoints& points, Limbs& limbs) {
    const int rounds = before[0].valid ? 1 : 2;
    for (int round = 0; round < rounds; ++round) {
        for (const Side side : {Side::left, Side::right}) {
            const Side other = side == Side::left ? Side::right : Side::left;
            const LimbPose& partner = limbs[index(other)].valid ? limbs[index(other)] : before[index(other)];
            explainBy(model, roots[index(other)], partner, view.torso, other, points.points, points.explained);
            LimbPose& limb = limbs[index(side)];
            const LimbPose& start = limb.valid ? limb : before[index(side)];
            LimbFitJob job{.cloud = &view.cloud,
                           .silhouette = &view.silhouette,
                           .torso = &view.torso,
                           .model = model,
                           .side = side,
                           .root = roots[index(side)],
                           .previous = start.valid ? &start : nullptr,
                           .points = points.points,
                           .explained = points.explained,
                           .evaluations = evaluations,
                           .generator = generator};
            if (!job.isValid()) continue;
            job.run();
            limb = job.pose;
            generator = job.generator;
        }
    }
}

ArticulatedPose BodyDetector::detect(const Cloud& cloud, const Silhouette& silhouette, const TorsoPose& torso,
                                     const BodyLengths& size, const ArticulatedPose* before) {
    const View view{cloud, silhouette, torso};
    Limbs armsBefore{};
    Limbs legsBefore{};
    if (before != nullptr) {
        for (const Side side : {Side::left, Side::right}) {
            armsBefore[index(side)] = limbPose(before->elbow(side), before->hand(side));
            legsBefore[index(side)] = limbPose(before->knee(side), before->foot(side));
        }
    }
    collectPoints(view);
    Limbs arms{};
    Limbs legs{};
    fitLimbs(view, legModel(torso.stature), torso.hips, legsBefore, kLegEvaluations, generator_, legPoints_, legs);
    fitLimbs(view, armModel(torso.stature), torso.shoulders, armsBefore, kArmEvaluations, generator_, armPoints_, arms);

    ArticulatedPose pose;
    pose.size = size;
    pose.axes << torso.left, torso.up, torso.forward;
    pose.middle = torso.neck - 0.5F * size[index(BodyLength::trunk)] * torso.up;
    pose.headDirection = (torso.head - torso.neck).normalized();
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t k = index(side);
        if (arms[k].valid) pose.arms[k] = directions(torso.shoulders[k], arms[k]);
        if (legs[k].valid) pose.legs[k] = directions(torso.hips[k], legs[k]);
    }
    return pose;
}

}  // namespace cheval::fitting::tracking

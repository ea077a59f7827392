#include "fitting/tracking/body_tracker.h"

#include <algorithm>
#include <cmath>

#include "fitting/tracking/orientation.h"

namespace cheval::fitting::tracking {
namespace {

constexpr float kUsualStature = 1.70F;
constexpr int kStatureFrames = 20;
/// Someone whose crown is this much lower than before bends or sits: it says nothing about stature.
constexpr float kBending = 0.07F;
/// What lies this near the floor is foot, not shank.
constexpr float kFootHeight = 0.09F;

constexpr float kSeen = 0.9F;
constexpr float kHidden = 0.3F;
constexpr float kOutside = 0.2F;
/// A joint within so many cells of the picture's edge is cut by it.
constexpr int kEdge = 4;

}  // namespace

BodyTracker::BodyTracker() {
    for (LimbPoints* limb : {&armPoints_, &legPoints_}) {
        limb->points.reserve(kMostPoints);
        limb->explained.reserve(kMostPoints);
    }
}

void BodyTracker::reset() {
    torso_ = TorsoPose{};
    arms_ = legs_ = previousArms_ = previousLegs_ = {};
    for (PointFilter& filter : filters_) {
        filter.reset();
    }
    userId_ = 0;
    stature_ = 0.0F;
    statureFrames_ = 0;
    halfDepth_ = kUsualHalfDepth;
}

void BodyTracker::update(const Cloud& cloud, std::span<const std::uint8_t> labels, const User& user, bool floorKnown,
                         hal::TimePoint time, Skeleton& skeleton) {
    if (user.id != userId_) {
        reset();
        userId_ = user.id;
    }
    skeleton = Skeleton{};
    SilhouetteJob outline{.cloud = &cloud, .labels = labels, .label = user.label, .silhouette = &silhouette_};
    if (!outline.isValid()) return;
    outline.run();
    const TorsoPose before = torso_;
    TorsoFitJob trunk{.cloud = &cloud,
                      .silhouette = &silhouette_,
                      .previous = before.found ? &before : nullptr,
                      .stature = floorKnown ? stature_ : kUsualStature,
                      .floorKnown = floorKnown,
                      .halfDepth = halfDepth_};
    if (!trunk.isValid()) return;
    trunk.run();
    torso_ = trunk.pose;
    if (!torso_.found) return;
    learnStature(floorKnown);
    learnHalfDepth();

    previousArms_ = arms_;
    previousLegs_ = legs_;
    collectPoints(cloud);
    fitLegs(cloud);
    fitArms(cloud);
    fillSkeleton(cloud, time, skeleton);
}

void BodyTracker::learnStature(bool floorKnown) {
    if (!floorKnown) {
        stature_ = kUsualStature;
        return;
    }
    const float seen = std::clamp(torso_.crown, 0.9F, 2.2F);
    if (statureFrames_ > 0 && seen < stature_ - kBending) return;
    ++statureFrames_;
    const float weight = 1.0F / static_cast<float>(std::min(statureFrames_, kStatureFrames));
    stature_ += weight * (seen - stature_);
}

void BodyTracker::learnHalfDepth() {
    // A slender trunk and a stout one differ by a hand's breadth; the head above shows where the spine is, as long as
    // the person faces the sensor.
    if (std::abs(torso_.surface[1]) > 0.3F) return;
    const float seen = std::clamp(torso_.halfDepth, 0.050F, 0.095F);
    halfDepth_ += 0.06F * (seen - halfDepth_);
}

void BodyTracker::collectPoints(const Cloud& cloud) {
    const Silhouette& s = silhouette_;
    const float stature = torso_.stature;
    const Eigen::Vector3f hip = 0.5F * (torso_.hips[0] + torso_.hips[1]);
    const Eigen::Vector3f shoulder = 0.5F * (torso_.shoulders[0] + torso_.shoulders[1]);
    const float trunkLength = (shoulder - hip).dot(torso_.up);
    // Kind of a cell: 0 trunk or head, 1 arm, 2 leg.
    const auto kindOf = [&](std::size_t i) {
        const Eigen::Vector3f point = cloud.point(i);
        const Eigen::Vector3f fromHip = point - hip;
        const float height = fromHip.dot(torso_.up) / trunkLength;  // 0 at the hips, 1 at the shoulders
        const float across = std::abs(fromHip.dot(torso_.left));
        const float front = torso_.surface[0] + torso_.surface[1] * point.x() + torso_.surface[2] * point.y();
        const float before = front - point.z();
        if ((point.head<2>() - torso_.head.head<2>()).norm() < 0.085F * stature &&
            std::abs(point.z() - torso_.head.z()) < 0.15F) {
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

void BodyTracker::fitLimb(const Cloud& cloud, Side side, const LimbModel& model, const Eigen::Vector3f& root,
                          LimbPose& pose, LimbPoints& points, int evaluations) {
    const LimbPose& previous = model.kind == LimbKind::arm ? previousArms_[index(side)] : previousLegs_[index(side)];
    LimbFitJob job{.cloud = &cloud,
                   .silhouette = &silhouette_,
                   .torso = &torso_,
                   .model = model,
                   .side = side,
                   .root = root,
                   .previous = pose.valid ? &pose : (previous.valid ? &previous : nullptr),
                   .points = points.points,
                   .explained = points.explained,
                   .evaluations = evaluations};
    if (!job.isValid()) return;
    job.run();
    pose = job.pose;
}

namespace {

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

}  // namespace

void BodyTracker::fitLegs(const Cloud& cloud) {
    const LimbModel model = legModel(torso_.stature);
    legs_ = {};
    for (int round = 0; round < 2; ++round) {
        for (const Side side : {Side::left, Side::right}) {
            const Side other = side == Side::left ? Side::right : Side::left;
            explainBy(model, torso_.hips[index(other)], legs_[index(other)], torso_, other, legPoints_.points,
                      legPoints_.explained);
            fitLimb(cloud, side, model, torso_.hips[index(side)], legs_[index(side)], legPoints_, 90);
        }
    }
}

void BodyTracker::fitArms(const Cloud& cloud) {
    const LimbModel model = armModel(torso_.stature);
    arms_ = {};
    for (int round = 0; round < 2; ++round) {
        for (const Side side : {Side::left, Side::right}) {
            const Side other = side == Side::left ? Side::right : Side::left;
            const LimbPose& partner = arms_[index(other)].valid ? arms_[index(other)] : previousArms_[index(other)];
            explainBy(model, torso_.shoulders[index(other)], partner, torso_, other, armPoints_.points,
                      armPoints_.explained);
            fitLimb(cloud, side, model, torso_.shoulders[index(side)], arms_[index(side)], armPoints_, 150);
        }
    }
}

float BodyTracker::confidenceOf(const Cloud& cloud, const Eigen::Vector3f& position, float depthAllowed) const {
    const Eigen::Vector3f cell = cloud.toCell(position);
    const int column = static_cast<int>(std::lround(cell.x()));
    const int row = static_cast<int>(std::lround(cell.y()));
    if (cell.z() <= 0.0F || column < kEdge || row < kEdge || column >= kCloudWidth - kEdge ||
        row >= kCloudHeight - kEdge) {
        return kOutside;
    }
    if (!silhouette_.contains(column, row)) return kOutside;
    const std::size_t i = cellIndex(column, row);
    if (silhouette_.inside[i] == 0) {
        const float away = silhouette_.outside[i] * cloud.cellSize(cell.z());
        return away < 0.03F ? 0.6F : kHidden;
    }
    const float behind = cell.z() - silhouette_.surface[i];
    if (behind < -0.10F) return kHidden;
    return behind < depthAllowed ? kSeen : kHidden;
}

void BodyTracker::fillSkeleton(const Cloud& cloud, hal::TimePoint time, Skeleton& skeleton) {
    const auto set = [&](Joint joint, const Eigen::Vector3f& position, float depthAllowed) {
        skeleton[joint].position = position;
        skeleton[joint].confidence = confidenceOf(cloud, position, depthAllowed);
    };
    set(Joint::head, torso_.head, 0.25F);
    set(Joint::neck, torso_.neck, 0.25F);
    set(Joint::torso, 0.5F * (torso_.neck + 0.5F * (torso_.hips[0] + torso_.hips[1])), 0.25F);
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t k = index(side);
        const bool left = side == Side::left;
        set(left ? Joint::leftShoulder : Joint::rightShoulder, torso_.shoulders[k], 0.22F);
        set(left ? Joint::leftElbow : Joint::rightElbow, arms_[k].middle, 0.15F);
        set(left ? Joint::leftHand : Joint::rightHand, arms_[k].end, 0.10F);
        set(left ? Joint::leftHip : Joint::rightHip, torso_.hips[k], 0.25F);
        set(left ? Joint::leftKnee : Joint::rightKnee, legs_[k].middle, 0.20F);
        set(left ? Joint::leftFoot : Joint::rightFoot, legs_[k].end, 0.20F);
    }
    const float elapsed = static_cast<float>(hal::seconds(time - lastTime_));
    lastTime_ = time;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        JointState& joint = skeleton.joints[i];
        if (elapsed > 0.7F) filters_[i].reset();
        joint.position = filters_[i].filter(joint.position, elapsed);
    }
    orientJoints(torso_, skeleton);
    skeleton.captureTime = time;
    skeleton.userId = userId_;
}

}  // namespace cheval::fitting::tracking

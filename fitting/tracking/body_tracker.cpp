#include "fitting/tracking/body_tracker.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "fitting/tracking/orientation.h"

namespace cheval::fitting::tracking {
namespace {

constexpr float kUsualStature = 1.70F;
constexpr int kStatureFrames = 20;
constexpr int kSizeFrames = 30;
constexpr float kUsualHalfDepth = 0.066F;

/// In a person's first frames nobody knows which way they face.
constexpr int kNewFrames = 6;
constexpr float kNoFit = 1e9F;
/// Another pose must cost less than this share of what the pose that was followed costs.
constexpr float kSteadiness = 0.96F;
/// A forward direction with this much along z, or more, is no longer towards the glass.
constexpr float kProfile = -0.35F;
constexpr float kTurned = 1.3F;  ///< Radians to either side that are tried then.
/// How much of the forward direction points where a person walks sideways, at least.
constexpr float kLooksAside = 0.5F;
/// Someone whose crown is this much lower than before bends or sits: it says nothing about stature.
constexpr float kBending = 0.07F;
constexpr int kBendingFrames = 60;

constexpr float kSeen = 0.9F;
constexpr float kHidden = 0.3F;
constexpr float kOutside = 0.2F;
/// A joint within so many cells of the picture's edge is cut by it.
constexpr int kEdge = 4;

}  // namespace

BodyTracker::BodyTracker() {
    points_.reserve(kMostPoints);
    reset();
}

void BodyTracker::reset() {
    torso_ = TorsoPose{};
    detector_.reset();
    for (PointFilter& filter : filters_) {
        filter.reset();
    }
    known_ = false;
    sizeFrames_ = 0;
    hem_.reset();
    userId_ = 0;
    stature_ = 0.0F;
    statureFrames_ = lowerFrames_ = 0;
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
    if (!torso_.found) {
        known_ = false;
        return;
    }
    learnStature(floorKnown);
    learnHalfDepth();
    known_ = fitBody(cloud, user, floorKnown);
    if (!known_) return;
    fillSkeleton(cloud, time, skeleton);
}

void BodyTracker::learnStature(bool floorKnown) {
    if (!floorKnown) {
        stature_ = kUsualStature;
        return;
    }
    const float seen = std::clamp(torso_.crown, 0.9F, 2.2F);
    if (statureFrames_ > 0 && seen < stature_ - kBending) {
        // Nobody bends for so long: what was seen first was too tall.
        if (++lowerFrames_ < kBendingFrames) return;
        statureFrames_ = 0;
    }
    lowerFrames_ = 0;
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

void BodyTracker::learnSize() {
    ++sizeFrames_;
    const float weight = 1.0F / static_cast<float>(std::min(sizeFrames_, kSizeFrames));
    for (std::size_t k = 0; k < kBodyLengthCount; ++k) {
        size_[k] += weight * (body_.size[k] - size_[k]);
    }
}

void BodyTracker::collectPoints(const Cloud& cloud) {
    points_.clear();
    const Silhouette& s = silhouette_;
    // What a skirt shows says nothing about the legs under it.
    float coveredFrom = -1e3F;
    float coveredTo = 1e3F;
    if (known_ && hem_.covered()) {
        const float hip = body_.hipMiddle().y();
        const float ankle = 0.5F * (body_.foot(Side::left).y() + body_.foot(Side::right).y());
        coveredFrom = hip - 0.12F * (hip - ankle);
        coveredTo = hip - hem_.hem() * (hip - ankle);
    }
    const float share = static_cast<float>(s.cells) / static_cast<float>(kMostPoints);
    const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(share))));
    for (int row = s.top; row <= s.bottom; row += stride) {
        for (int column = s.left; column <= s.right; column += stride) {
            const std::size_t i = cellIndex(column, row);
            if (s.inside[i] == 0 || cloud.depth[i] <= 0.0F || points_.size() >= kMostPoints) continue;
            const Eigen::Vector3f point = cloud.point(i);
            if (point.y() < coveredFrom && point.y() > coveredTo) continue;
            points_.push_back(point);
        }
    }
}

void BodyTracker::tryFrom(const ArticulatedPose& start, BodyFitJob& job, ArticulatedPose& best, float& cost) const {
    job.start = start;
    job.toBeat = cost;
    job.run();
    if (job.cost >= cost) return;
    cost = job.cost;
    best = job.pose;
}

bool BodyTracker::fitBody(const Cloud& cloud, const User& user, bool floorKnown) {
    collectPoints(cloud);
    const BodyLengths usual = usualLengths(torso_.stature);
    if (sizeFrames_ == 0) size_ = usual;
    const ArticulatedPose before = body_;
    BodyFitJob job{.cloud = &cloud,
                   .silhouette = &silhouette_,
                   .points = points_,
                   .head = torso_.head,
                   .headSeen = torso_.headSeen,
                   .floorKnown = floorKnown,
                   .sideways = user.velocity.x(),
                   .previous = known_ ? &before : nullptr,
                   .usual = usual,
                   .spread = lengthSpread(torso_.stature, floorKnown),
                   .learnt = sizeFrames_ > 0 ? &size_ : nullptr};
    ArticulatedPose best;
    float cost = kNoFit;
    if (!job.isValid()) return false;
    if (known_) {
        tryFrom(before, job, best, cost);
        // In profile front and back look alike.
        if (before.forward().z() > kProfile) tryFrom(before.turnedRound(), job, best, cost);
        if (before.legsCrossed()) tryFrom(before.withLegsExchanged(), job, best, cost);
        // Of two that are as good the one that does not jump.
        cost *= kSteadiness;
    }
    const ArticulatedPose detected = detector_.detect(cloud, silhouette_, torso_, size_, known_ ? &before : nullptr);
    tryFrom(detected, job, best, cost);
    // Whoever walks sideways most likely looks where they go.
    const float sideways = user.velocity.x();
    const float towards = std::copysign(1.0F, sideways);
    const bool walks = std::abs(sideways) > kWalking && best.forward().x() * towards < kLooksAside;
    for (const float side : {-1.0F, 1.0F}) {
        if (walks ? side != towards : sizeFrames_ >= kNewFrames) continue;
        ArticulatedPose turned = detected;
        turned.axes = Eigen::AngleAxisf(-side * kTurned, Eigen::Vector3f::UnitY()) * turned.axes;
        turned.arms = {};
        tryFrom(turned, job, best, cost);
    }
    if (cost >= kNoFit) return false;
    body_ = best;
    hem_.look(cloud, silhouette_, body_);
    learnSize();
    return true;
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
    set(Joint::head, body_.head(), 0.25F);
    set(Joint::neck, body_.neck(), 0.25F);
    set(Joint::torso, body_.middle, 0.25F);
    for (const Side side : {Side::left, Side::right}) {
        const bool left = side == Side::left;
        set(left ? Joint::leftShoulder : Joint::rightShoulder, body_.shoulder(side), 0.22F);
        set(left ? Joint::leftElbow : Joint::rightElbow, body_.elbow(side), 0.15F);
        set(left ? Joint::leftHand : Joint::rightHand, body_.hand(side), 0.10F);
        set(left ? Joint::leftHip : Joint::rightHip, body_.hip(side), 0.25F);
        set(left ? Joint::leftKnee : Joint::rightKnee, body_.knee(side), 0.20F);
        set(left ? Joint::leftFoot : Joint::rightFoot, body_.foot(side), 0.20F);
    }
    const float elapsed = static_cast<float>(hal::seconds(time - lastTime_));
    lastTime_ = time;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        JointState& joint = skeleton.joints[i];
        if (elapsed > 0.7F) filters_[i].reset();
        joint.position = filters_[i].filter(joint.position, elapsed);
    }
    orientJoints(body_.axes, skeleton);
    skeleton.captureTime = time;
    skeleton.userId = userId_;
}

}  // namespace cheval::fitting::tracking

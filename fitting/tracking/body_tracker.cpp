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

/// In a person's first frames nobody knows which way they face; of whoever comes out from behind others, for some more,
/// where their arms are.
constexpr int kNewFrames = 6;
constexpr int kArmFrames = 20;
/// A pose of so long ago says little.
constexpr float kLostSeconds = 0.35F;
constexpr float kNoFit = 1e9F;
/// Another pose must cost less than this share of what the pose that was followed costs; of somebody at rest, than
/// that.
constexpr float kSteadiness = 0.96F;
constexpr float kSteadinessAtRest = 0.85F;
/// Joints of somebody at rest are slower than this on average, metres a second.
constexpr float kAtRest = 0.12F;
/// What is followed is sound while it costs no more than this many times what it did before. Then other poses are
/// looked for in every second frame only.
constexpr float kSound = 1.05F;
constexpr int kLookEvery = 2;
/// Seconds in which what it usually costs follows what it costs now, downwards and upwards.
constexpr float kCostFalls = 0.1F;
constexpr float kCostRises = 2.0F;
/// Rounds of the fit where only a limb has to find its place; the next frame goes on from there.
constexpr int kLimbRounds = 3;
/// Radians before and behind the trunk: arms that hang, and that swing.
constexpr std::array<float, 3> kSwings = {0.0F, 0.6F, -0.5F};
/// A forward direction with this much along z, or more, is no longer towards the glass.
constexpr float kProfile = -0.35F;
constexpr float kTurned = 1.3F;  ///< Radians to either side that are tried then.
/// How much of the forward direction points where a person walks sideways, at least.
constexpr float kLooksAside = 0.5F;
/// Someone whose crown is this much lower than before bends or sits: it says nothing about stature.
constexpr float kBending = 0.07F;
constexpr int kBendingFrames = 60;

/// Whoever sits on a chair, crown above the floor: the seat's height and so much of the stature (Drillis and Contini).
constexpr float kSeatHeight = 0.48F;
constexpr float kSittingHeight = 0.52F;
/// Crowns of whoever sits are lower than this, and their knees this far before the trunk, as seen from above; metres.
constexpr float kTallestSeated = 1.60F;
constexpr float kSeated = 0.18F;
/// Seconds over which it is averaged whether they look like it.
constexpr float kSeatSpan = 0.12F;

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
    foundFrames_ = 0;
    sizeFrames_ = 0;
    usualCost_ = 0.0F;
    soundFrames_ = 0;
    hem_.reset();
    userId_ = 0;
    stature_ = 0.0F;
    statureFrames_ = lowerFrames_ = 0;
    halfDepth_ = kUsualHalfDepth;
    seated_ = false;
    seatedShare_ = -1.0F;
}

void BodyTracker::update(const Cloud& cloud, std::span<const std::uint8_t> labels, const User& user, bool floorKnown,
                         hal::TimePoint time, Skeleton& skeleton) {
    if (user.id != userId_) {
        reset();
        userId_ = user.id;
    }
    skeleton = Skeleton{};
    const auto elapsed = static_cast<float>(hal::seconds(time - lastTime_));
    if (elapsed > kLostSeconds) {
        // Whoever was hidden may stand otherwise by now.
        known_ = false;
        foundFrames_ = 0;
        torso_ = TorsoPose{};
    }
    SilhouetteJob outline{.cloud = &cloud, .labels = labels, .label = user.label, .silhouette = &silhouette_};
    if (!outline.isValid()) return;
    outline.run();
    findSeat(cloud, floorKnown, elapsed);
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
        foundFrames_ = 0;
        return;
    }
    learnStature(floorKnown);
    learnHalfDepth();
    known_ = fitBody(cloud, user, floorKnown, elapsed);
    foundFrames_ = known_ ? foundFrames_ + 1 : 0;
    if (!known_) return;
    fillSkeleton(cloud, time, elapsed, skeleton);
}

void BodyTracker::findSeat(const Cloud& cloud, bool floorKnown, float elapsed) {
    if (!floorKnown) return;
    const Silhouette& s = silhouette_;
    const auto each = [&](const auto& look) {
        for (int row = s.top; row <= s.bottom; ++row) {
            for (int column = s.left; column <= s.right; ++column) {
                const std::size_t i = cellIndex(column, row);
                if (s.inside[i] != 0 && cloud.depth[i] > 0.0F) look(i);
            }
        }
    };
    float crown = 0.0F;
    each([&](std::size_t i) { crown = std::max(crown, cloud.y[i]); });
    float seen = 0.0F;
    // Whoever has been seen taller bends.
    const bool bends = !seated_ && statureFrames_ > 0 && crown < stature_ - kBending;
    if (crown < kTallestSeated && !bends) {
        Eigen::Vector2f trunk = Eigen::Vector2f::Zero();
        Eigen::Vector2f legs = Eigen::Vector2f::Zero();
        int trunkCells = 0;
        int legCells = 0;
        each([&](std::size_t i) {
            const float height = cloud.y[i] / crown;
            const Eigen::Vector2f place(cloud.x[i], cloud.z[i]);
            if (height > 0.60F && height < 0.75F) {
                trunk += place;
                ++trunkCells;
            } else if (height > 0.25F && height < 0.42F) {
                legs += place;
                ++legCells;
            }
        });
        if (trunkCells < 30 || legCells < 30) return;
        const float before = (trunk / static_cast<float>(trunkCells) - legs / static_cast<float>(legCells)).norm();
        if (before > kSeated) seen = 1.0F;
    }
    const float weight = seatedShare_ < 0.0F ? 1.0F : 1.0F - std::exp(-elapsed / kSeatSpan);
    seatedShare_ += weight * (seen - seatedShare_);
    const bool seated = seated_ ? seatedShare_ > 0.3F : seatedShare_ > 0.7F;
    if (seated == seated_) return;
    // Another body altogether.
    seated_ = seated;
    known_ = false;
    foundFrames_ = sizeFrames_ = statureFrames_ = lowerFrames_ = 0;
    stature_ = statureOf(crown);
    torso_ = TorsoPose{};
}

float BodyTracker::statureOf(float crown) const {
    return seated_ ? std::clamp((crown - kSeatHeight) / kSittingHeight, 1.1F, 2.0F) : std::clamp(crown, 0.9F, 2.2F);
}

void BodyTracker::learnStature(bool floorKnown) {
    if (!floorKnown) {
        stature_ = kUsualStature;
        return;
    }
    const float seen = statureOf(torso_.crown);
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
    // On a grid that does not move with the outline: of somebody at rest the same cells are looked at.
    for (int row = (s.top + stride - 1) / stride * stride; row <= s.bottom; row += stride) {
        for (int column = (s.left + stride - 1) / stride * stride; column <= s.right; column += stride) {
            const std::size_t i = cellIndex(column, row);
            if (s.inside[i] == 0 || cloud.depth[i] <= 0.0F || points_.size() >= kMostPoints) continue;
            const Eigen::Vector3f point = cloud.point(i);
            if (point.y() < coveredFrom && point.y() > coveredTo) continue;
            points_.push_back(point);
        }
    }
}

void BodyTracker::tryFrom(const ArticulatedPose& start, BodyFitJob& job, Fit& best, float& cost) {
    job.start = start;
    job.toBeat = cost;
    job.run();
    if (job.cost >= cost) return;
    cost = job.cost;
    best = {.pose = job.pose, .cost = job.cost};
}

bool BodyTracker::fitBody(const Cloud& cloud, const User& user, bool floorKnown, float elapsed) {
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
                   .seated = seated_,
                   .sideways = user.velocity.x(),
                   .previous = known_ ? &before : nullptr,
                   .usual = usual,
                   .spread = lengthSpread(torso_.stature, floorKnown),
                   .learnt = sizeFrames_ > 0 ? &size_ : nullptr};
    Fit best;
    float cost = kNoFit;
    if (!job.isValid()) return false;
    const bool isNew = foundFrames_ < kNewFrames;
    bool sound = false;
    if (known_) {
        tryFrom(before, job, best, cost);
        sound = !isNew && cost < kSound * usualCost_;
        // Of two that are as good the one that does not jump.
        cost *= sound && atRest() ? kSteadinessAtRest : kSteadiness;
    }
    soundFrames_ = sound ? soundFrames_ + 1 : 0;
    if (soundFrames_ % kLookEvery == 0) lookAfresh(cloud, user, {.isNew = isNew, .sound = sound}, job, best, cost);
    if (cost >= kNoFit) return false;
    // Falls at once and rises slowly, or a fit that goes astray by and by would pass for sound.
    const float span = isNew || best.cost < usualCost_ ? kCostFalls : kCostRises;
    usualCost_ += (1.0F - std::exp(-elapsed / span)) * (best.cost - usualCost_);
    body_ = best.pose;
    if (!seated_) hem_.look(cloud, silhouette_, body_);
    learnSize();
    return true;
}

bool BodyTracker::atRest() const {
    float speed = 0.0F;
    for (const PointFilter& filter : filters_) {
        speed += filter.velocity().norm();
    }
    return speed < kAtRest * static_cast<float>(kJointCount);
}

void BodyTracker::lookAfresh(const Cloud& cloud, const User& user, Standing standing, BodyFitJob& job, Fit& best,
                             float& cost) {
    // In profile front and back look alike.
    if (known_ && body_.forward().z() > kProfile) tryFrom(body_.turnedRound(), job, best, cost);
    const auto detected = [&](const TorsoPose& torso, const ArticulatedPose* before) {
        ArticulatedPose pose = detector_.detect(cloud, silhouette_, torso, size_, before);
        if (seated_) pose.legs.fill(seatedLeg(pose.axes));
        return pose;
    };
    tryFrom(detected(torso_, known_ ? &body_ : nullptr), job, best, cost);
    if (standing.sound) return;
    // Whoever walks sideways most likely looks where they go.
    const float sideways = user.velocity.x();
    const float towards = std::copysign(1.0F, sideways);
    const bool walks = std::abs(sideways) > kWalking && best.pose.forward().x() * towards < kLooksAside;
    // But for somebody's first, a frame has time for one side, or for one arm. Mirrored pictures have them mirrored.
    const float half = std::copysign(1.0F, user.centroid.x());
    const float turn = (foundFrames_ / 2) % 2 == 0 ? half : -half;
    const bool turns = standing.isNew && foundFrames_ % 2 == 0;
    for (const float side : {-1.0F, 1.0F}) {
        if (walks ? side != towards : !turns || (known_ && side != turn)) continue;
        tryFrom(detected(torso_.turned(side * kTurned), nullptr), job, best, cost);
    }
    // Of two legs side by side in the picture only the depth tells which is which, and of two arms. Only a limb is
    // another.
    job.rounds = kLimbRounds;
    const bool profile = best.pose.forward().z() > kProfile;
    if (profile || best.pose.legsCrossed()) tryFrom(best.pose.withLegsExchanged(), job, best, cost);
    if ((!profile && foundFrames_ >= kArmFrames) || (turns && known_)) return;
    tryArm((foundFrames_ / 2) % 2 == (half > 0.0F ? 0 : 1) ? Side::left : Side::right, job, best, cost);
}

void BodyTracker::tryArm(Side side, BodyFitJob& job, Fit& best, float& cost) {
    const Side other = side == Side::left ? Side::right : Side::left;
    ArticulatedPose pose = best.pose;
    pose.arms[fitting::index(side)] = pose.arms[fitting::index(other)];
    pose.arms[fitting::index(other)] = {};
    tryFrom(pose, job, best, cost);
    for (const float swing : kSwings) {
        pose = best.pose;
        const Eigen::Vector3f along = std::sin(swing) * pose.forward() - std::cos(swing) * pose.up();
        pose.arms[fitting::index(side)] = {.upper = along, .lower = along};
        tryFrom(pose, job, best, cost);
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

void BodyTracker::fillSkeleton(const Cloud& cloud, hal::TimePoint time, float elapsed, Skeleton& skeleton) {
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

#include "fitting/tracking/hand_reader.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cheval::fitting::tracking {
namespace {

/// Hysteresis on the filtered openness.
constexpr float kOpens = 0.12F;
constexpr float kCloses = -0.12F;
/// Seconds over which readings are averaged.
constexpr float kStateSpan = 0.10F;
/// A picture this much coarser than the grid shows no fingers any more.
constexpr float kCoarsest = 0.30F;
/// A hand before the shoulder by this share of the stature is held out, as one does to point.
constexpr float kHeldOut = 0.147F;
/// Where a hand's centre is when it touches something of the shopper's own, in shares of the stature: so near to the
/// head's centre or the other hand, so little above the hips, before and beside the line from hips to neck.
constexpr float kAtHead = 0.105F;
constexpr float kAtOtherHand = 0.085F;
constexpr float kLap = 0.06F;
constexpr float kAtChestBefore = 0.125F;
constexpr float kAtChestAcross = 0.125F;

}  // namespace

void HandStateFilter::read(float value, float elapsed) {
    missing_ = 0.0F;
    const float weight = started_ ? 1.0F - std::exp(-elapsed / kStateSpan) : 1.0F;
    started_ = true;
    level_ += weight * (value - level_);
    if (level_ > kOpens) {
        state_ = HandState::open;
    } else if (level_ < kCloses) {
        state_ = HandState::closed;
    }
    const bool agrees = (state_ == HandState::open) == (level_ > 0.0F);
    confidence_ = state_ == HandState::unknown || !agrees ? 0.2F : std::clamp(0.3F + std::abs(level_), 0.0F, 1.0F);
}

void HandStateFilter::miss(float elapsed) {
    missing_ += elapsed;
    confidence_ *= 0.5F;
    if (missing_ >= kPatience) reset();
}

namespace {

/// Whether a hand is away from everything it may be busy with: the head, the chest, the other hand, the lap.
bool isFree(const Skeleton& skeleton, Side side, float stature) {
    const bool left = side == Side::left;
    const Eigen::Vector3f& hand = skeleton[left ? Joint::leftHand : Joint::rightHand].position;
    const Eigen::Vector3f& other = skeleton[left ? Joint::rightHand : Joint::leftHand].position;
    const Eigen::Vector3f hips = 0.5F * (skeleton[Joint::leftHip].position + skeleton[Joint::rightHip].position);
    const Eigen::Matrix3f axes = skeleton[Joint::torso].orientation.toRotationMatrix();
    const Eigen::Vector3f fromHips = hand - hips;
    const float height = fromHips.dot(axes.col(1));
    const float trunk = (skeleton[Joint::neck].position - hips).norm();
    if (height < kLap * stature) return false;
    if ((hand - skeleton[Joint::head].position).norm() < kAtHead * stature) return false;
    if ((hand - other).norm() < kAtOtherHand * stature) return false;
    return height > trunk || std::abs(fromHips.dot(axes.col(0))) > kAtChestAcross * stature ||
           fromHips.dot(axes.col(2)) > kAtChestBefore * stature;
}

}  // namespace

void HandReader::reset() {
    for (const Side side : {Side::left, Side::right}) {
        states_[index(side)].reset();
    }
    userId_ = 0;
}

void HandReader::update(const hal::DepthFrame& frame, const Users& users, const Skeleton& skeleton,
                        const SensorPlacement& placement, float stature, Hands& hands) {
    if (skeleton.userId != userId_) reset();
    if (!skeleton.present() || frame.depth.empty()) return;
    const float elapsed =
        userId_ == 0 ? 0.0F : std::clamp(static_cast<float>(hal::seconds(frame.captureTime - lastTime_)), 0.0F, 1.0F);
    userId_ = skeleton.userId;
    lastTime_ = frame.captureTime;
    const Eigen::Vector3f forward = skeleton[Joint::torso].orientation * Eigen::Vector3f::UnitZ();
    for (const Side side : {Side::left, Side::right}) {
        Hand& hand = hands[side];
        const bool left = side == Side::left;
        readHand(frame, users, skeleton, placement, side, elapsed, hand);
        const Eigen::Vector3f& elbow = skeleton[left ? Joint::leftElbow : Joint::rightElbow].position;
        const Eigen::Vector3f& shoulder = skeleton[left ? Joint::leftShoulder : Joint::rightShoulder].position;
        const bool up = hand.position.y() > elbow.y() + 0.01F * stature ||
                        (hand.position - shoulder).dot(forward) > kHeldOut * stature;
        hand.raised = up && isFree(skeleton, side, stature);
    }
}

void HandReader::readHand(const hal::DepthFrame& frame, const Users& users, const Skeleton& skeleton,
                          const SensorPlacement& placement, Side side, float elapsed, Hand& hand) {
    const bool left = side == Side::left;
    const JointState& joint = skeleton[left ? Joint::leftHand : Joint::rightHand];
    const JointState& elbow = skeleton[left ? Joint::leftElbow : Joint::rightElbow];
    hand.position = joint.position;

    HandStateFilter& filter = states_[index(side)];
    const User* user = users.active();
    const float headToNeck = (skeleton[Joint::head].position - skeleton[Joint::neck].position).norm();
    HandOpennessJob reading{.depth = frame.depth,
                            .userMap = users.map,
                            .label = user == nullptr ? std::uint8_t{0} : user->label,
                            .intrinsics = frame.intrinsics,
                            .palm = placement.toSensor(joint.position),
                            .elbow = placement.toSensor(elbow.position),
                            .headToNeck = headToNeck,
                            .coarsest = kCoarsest,
                            .context = &context_};
    if (user != nullptr && joint.confidence >= 0.5F && reading.isValid()) reading.run();
    if (reading.found) {
        filter.read(reading.openness, elapsed);
    } else {
        filter.miss(elapsed);
    }
    hand.state = filter.state();
    hand.confidence = filter.confidence();
}

}  // namespace cheval::fitting::tracking

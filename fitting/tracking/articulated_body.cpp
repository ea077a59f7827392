#include "fitting/tracking/articulated_body.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cheval::fitting::tracking {
namespace {

/// Radii in shares of the trunk's length, which is about a third of the stature.
constexpr float kHeadRadius = 0.135F;
constexpr float kNeckRadius = 0.105F;
constexpr float kShoulderRadius = 0.085F;
constexpr float kElbowRadius = 0.070F;
constexpr float kHandRadius = 0.058F;
constexpr float kThighRadius = 0.150F;
constexpr float kKneeRadius = 0.098F;
constexpr float kAnkleRadius = 0.058F;
constexpr float kFootRadius = 0.070F;
/// Beyond the palm's centre the hand goes on; the foot reaches forwards from the ankle. Shares of the trunk's length.
constexpr float kHandBeyond = 0.09F;
constexpr float kFootLength = 0.28F;
constexpr float kFootDrop = 0.09F;
/// The trunk's slab ends so far below the neck's base that its rounding is the shoulders' line.
constexpr float kSlabDrop = 0.27F;
/// The head's bone, from chin to crown, about its centre: share of headDrop.
constexpr float kHeadHalfHeight = 0.16F;

std::size_t place(BodyPart part) {
    return static_cast<std::size_t>(part);
}

}  // namespace

BodyLengths usualLengths(float stature) {
    BodyLengths size{};
    const auto set = [&](BodyLength which, float metres) { size[index(which)] = metres; };
    set(BodyLength::headDrop, 0.185F + 0.0425F * stature);
    set(BodyLength::trunk, 0.328F * stature);
    set(BodyLength::shoulderHalfBreadth, 0.102F * stature);
    set(BodyLength::hipHalfBreadth, 0.061F * stature);
    set(BodyLength::upperArm, 0.147F * stature);
    set(BodyLength::forearm, 0.174F * stature);
    set(BodyLength::thigh, 0.238F * stature);
    set(BodyLength::shank, 0.248F * stature);
    set(BodyLength::trunkDepth, 0.084F * stature);
    set(BodyLength::trunkHalfWidth, 0.096F * stature);
    set(BodyLength::hipSetback, 0.044F * stature);
    return size;
}

BodyLengths lengthSpread(float stature, bool statureKnown) {
    constexpr float kGuessed = 2.5F;
    BodyLengths spread{};
    const auto set = [&](BodyLength which, float share) {
        spread[index(which)] = share * stature * (statureKnown ? 1.0F : kGuessed);
    };
    set(BodyLength::headDrop, 0.006F);
    set(BodyLength::trunk, 0.008F);
    set(BodyLength::shoulderHalfBreadth, 0.005F);
    set(BodyLength::hipHalfBreadth, 0.003F);
    set(BodyLength::upperArm, 0.006F);
    set(BodyLength::forearm, 0.011F);
    set(BodyLength::thigh, 0.008F);
    set(BodyLength::shank, 0.010F);
    set(BodyLength::trunkDepth, 0.010F);
    set(BodyLength::trunkHalfWidth, 0.015F);
    set(BodyLength::hipSetback, 0.010F);
    return spread;
}

LimbDirections seatedLeg(const Eigen::Matrix3f& axes) {
    return {.upper = (axes.col(2) - 0.15F * axes.col(1)).normalized(),
            .lower = (0.2F * axes.col(2) - axes.col(1)).normalized()};
}

Eigen::Vector3f ArticulatedPose::head() const {
    return neck() + (1.0F - kHeadCentre) * length(BodyLength::headDrop) * headDirection;
}

Eigen::Vector3f ArticulatedPose::shoulder(Side side) const {
    return neck() - kShoulderDrop * length(BodyLength::trunk) * up() +
           outwards(side) * length(BodyLength::shoulderHalfBreadth) * left();
}

Eigen::Vector3f ArticulatedPose::hip(Side side) const {
    return hipMiddle() + outwards(side) * length(BodyLength::hipHalfBreadth) * left();
}

ArticulatedPose ArticulatedPose::turnedRound() const {
    ArticulatedPose turned = *this;
    turned.axes.col(0) = -left();
    turned.axes.col(2) = -forward();
    std::swap(turned.arms[0], turned.arms[1]);
    std::swap(turned.legs[0], turned.legs[1]);
    return turned;
}

ArticulatedPose ArticulatedPose::withLegsExchanged() const {
    ArticulatedPose exchanged = *this;
    for (const Side side : {Side::left, Side::right}) {
        const Side other = side == Side::left ? Side::right : Side::left;
        exchanged.legs[fitting::index(side)] = {(knee(other) - hip(side)).normalized(),
                                                (foot(other) - knee(other)).normalized()};
    }
    return exchanged;
}

BodySurface::BodySurface(const ArticulatedPose& pose)
    : middle_(pose.middle + 0.5F * pose.length(BodyLength::hipSetback) * pose.forward()),
      left_(pose.left()),
      up_((pose.length(BodyLength::trunk) * pose.up() - pose.length(BodyLength::hipSetback) * pose.forward())
              .normalized()),
      halfTrunk_(0.5F * pose.length(BodyLength::trunk)),
      slab_(std::max(0.01F, pose.length(BodyLength::trunkHalfWidth) - pose.length(BodyLength::trunkDepth))),
      trunkRadius_(pose.length(BodyLength::trunkDepth)) {
    const float scale = pose.length(BodyLength::trunk);
    bones_ = {};
    bones_.x.fill(1e3F);
    setBone(BodyPart::neck, pose.neck(), pose.head(), kNeckRadius * scale, kNeckRadius * scale);
    const float half = kHeadHalfHeight * pose.length(BodyLength::headDrop);
    const Eigen::Vector3f head = pose.head();
    setBone(BodyPart::head, head - half * pose.headDirection, head + half * pose.headDirection, kHeadRadius * scale,
            kHeadRadius * scale);
    for (const Side side : {Side::left, Side::right}) {
        const bool isLeft = side == Side::left;
        const LimbDirections& arm = pose.arms[fitting::index(side)];
        const Eigen::Vector3f elbow = pose.elbow(side);
        setBone(isLeft ? BodyPart::leftUpperArm : BodyPart::rightUpperArm, pose.shoulder(side), elbow,
                kShoulderRadius * scale, kElbowRadius * scale);
        setBone(isLeft ? BodyPart::leftForearm : BodyPart::rightForearm, elbow,
                pose.hand(side) + kHandBeyond * scale * arm.lower, kElbowRadius * scale, kHandRadius * scale);
        const Eigen::Vector3f knee = pose.knee(side);
        const Eigen::Vector3f ankle = pose.foot(side);
        setBone(isLeft ? BodyPart::leftThigh : BodyPart::rightThigh, pose.hip(side), knee, kThighRadius * scale,
                kKneeRadius * scale);
        setBone(isLeft ? BodyPart::leftShank : BodyPart::rightShank, knee, ankle, kKneeRadius * scale,
                kAnkleRadius * scale);
        const Eigen::Vector3f level = Eigen::Vector3f(pose.forward().x(), 0.0F, pose.forward().z()).normalized();
        const Eigen::Vector3f sole = ankle - Eigen::Vector3f(0.0F, kFootDrop * scale, 0.0F);
        setBone(isLeft ? BodyPart::leftFoot : BodyPart::rightFoot, sole, sole + kFootLength * scale * level,
                kFootRadius * scale, kFootRadius * scale);
    }
}

void BodySurface::setBone(BodyPart part, const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius,
                          float endRadius) {
    const std::size_t i = place(part);
    const Eigen::Vector3f along = to - from;
    bones_.x[i] = from.x();
    bones_.y[i] = from.y();
    bones_.z[i] = from.z();
    bones_.alongX[i] = along.x();
    bones_.alongY[i] = along.y();
    bones_.alongZ[i] = along.z();
    bones_.perLength[i] = 1.0F / std::max(along.squaredNorm(), 1e-8F);
    bones_.radius[i] = radius;
    bones_.taper[i] = endRadius - radius;
}

BodySurface::Distances BodySurface::distances(const Eigen::Vector3f& point) const {
    Distances result;
    const float px = point.x();
    const float py = point.y();
    const float pz = point.z();
    for (std::size_t i = 0; i < kLanes; ++i) {
        const float x = px - bones_.x[i];
        const float y = py - bones_.y[i];
        const float z = pz - bones_.z[i];
        const float along = (x * bones_.alongX[i] + y * bones_.alongY[i] + z * bones_.alongZ[i]) * bones_.perLength[i];
        const float t = std::min(std::max(along, 0.0F), 1.0F);
        const float dx = x - t * bones_.alongX[i];
        const float dy = y - t * bones_.alongY[i];
        const float dz = z - t * bones_.alongZ[i];
        result.share[i] = t;
        result.metres[i] = std::sqrt(dx * dx + dy * dy + dz * dz) - (bones_.radius[i] + t * bones_.taper[i]);
    }
    const Eigen::Vector3f offset = point - middle_;
    result.height = std::clamp(offset.dot(up_), -halfTrunk_, (1.0F - 2.0F * kSlabDrop) * halfTrunk_);
    result.across = std::clamp(offset.dot(left_), -slab_, slab_);
    result.onSlab = middle_ + result.height * up_ + result.across * left_;
    result.metres[place(BodyPart::trunk)] = (point - result.onSlab).norm() - trunkRadius_;
    return result;
}

float BodySurface::outside(const Eigen::Vector3f& point) const {
    const Distances all = distances(point);
    return *std::min_element(all.metres.begin(), all.metres.begin() + kBodyPartCount);
}

BodySurface::Place BodySurface::nearest(const Eigen::Vector3f& point) const {
    const Distances all = distances(point);
    std::size_t best = 0;
    for (std::size_t i = 1; i < kBodyPartCount; ++i) {
        if (std::abs(all.metres[i]) < std::abs(all.metres[best])) best = i;
    }
    Place nearest{.part = static_cast<BodyPart>(best), .distance = all.metres[best]};
    if (nearest.part == BodyPart::trunk) {
        nearest.point = all.onSlab;
        nearest.along = 0.5F * all.height / halfTrunk_;
        nearest.across = all.across / slab_;
        nearest.radius = trunkRadius_;
        return nearest;
    }
    const float t = all.share[best];
    nearest.along = t;
    nearest.point = {bones_.x[best] + t * bones_.alongX[best], bones_.y[best] + t * bones_.alongY[best],
                     bones_.z[best] + t * bones_.alongZ[best]};
    nearest.radius = bones_.radius[best] + t * bones_.taper[best];
    return nearest;
}

}  // namespace cheval::fitting::tracking

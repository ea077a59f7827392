#include "fitting/body/silhouette.h"

#include <algorithm>
#include <cmath>

#include "fitting/body/arm_reach.h"

namespace cheval::fitting {

namespace {

constexpr float kSeen = 0.5F;         // Confidence from which a joint counts as seen.
constexpr int kBridgedPixels = 3;     // Drop-outs of the sensor within the outline.
constexpr int kBorderPixels = 2;      // An outline that comes this near to the border may go on beyond it.
constexpr float kHeadReach = 0.35F;   // metres from the head's centre to the highest hair
constexpr float kFootHeight = 0.25F;  // metres; an ankle above it does not stand on the floor

}  // namespace

Silhouette::Silhouette(const hal::DepthFrame& frame, hal::ImageView<const std::uint8_t> map, std::uint8_t label,
                       const Skeleton& skeleton, const SensorPlacement& placement)
    : frame_(frame), map_(map), label_(label), skeleton_(skeleton), placement_(placement) {}

std::optional<Silhouette::Pixel> Silhouette::pixelOf(const Eigen::Vector3f& point) const {
    const Eigen::Vector3f sensor = placement_.toSensor(point);
    if (!sensor.allFinite() || sensor.z() < 100.0F) return std::nullopt;
    const Eigen::Vector2f at = project(frame_.intrinsics, sensor);
    if (!(at.x() >= 0.0F && at.y() >= 0.0F && at.x() < static_cast<float>(map_.width) &&
          at.y() < static_cast<float>(map_.height))) {
        return std::nullopt;
    }
    return Pixel{.u = static_cast<int>(at.x()), .v = static_cast<int>(at.y())};
}

bool Silhouette::inside(int u, int v) const {
    return map_.contains(u, v) && map_.at(u, v) == label_;
}

bool Silhouette::onArm(int u, int v, float depth) const {
    const std::uint16_t reading = frame_.depth.at(u, v);
    const float z = reading != 0 ? static_cast<float>(reading) : depth;
    const Eigen::Vector3f point =
        placement_.toMirror(unproject(frame_.intrinsics, static_cast<float>(u), static_cast<float>(v), z));
    return fitting::onArm(skeleton_, point);
}

std::optional<int> Silhouette::outlineEnd(Pixel from, int step, float depth) const {
    int last = from.u;
    for (int u = from.u; std::abs(u - last) <= kBridgedPixels; u += step) {
        if (u < kBorderPixels || u >= map_.width - kBorderPixels) return std::nullopt;
        if (!inside(u, from.v)) continue;
        if (onArm(u, from.v, depth)) return std::nullopt;
        last = u;
    }
    return last;
}

std::optional<float> Silhouette::breadthAt(const Eigen::Vector3f& centre) const {
    const auto pixel = pixelOf(centre);
    if (!pixel || !inside(pixel->u, pixel->v)) return std::nullopt;
    // The outline of a rounded body lies about as far away as its axis, not as its front.
    const float depth = placement_.toSensor(centre).z();
    const auto left = outlineEnd(*pixel, -1, depth);
    const auto right = outlineEnd(*pixel, 1, depth);
    if (!left || !right) return std::nullopt;
    return static_cast<float>(*right - *left + 1) * depth / frame_.intrinsics.fx * 1e-3F;
}

std::optional<float> Silhouette::crownHeight() const {
    const JointState& head = skeleton_[Joint::head];
    if (head.confidence < kSeen) return std::nullopt;
    const auto centre = pixelOf(head.position);
    if (!centre || !inside(centre->u, centre->v)) return std::nullopt;
    const float depth = placement_.toSensor(head.position).z();
    const int halfBreadth = static_cast<int>(0.06F * frame_.intrinsics.fx / (depth * 1e-3F));
    const int reach = static_cast<int>(kHeadReach * frame_.intrinsics.fy / (depth * 1e-3F));
    // The second highest column: one stray pixel is no crown.
    int highest = centre->v;
    int second = centre->v;
    for (int u = centre->u - halfBreadth; u <= centre->u + halfBreadth; ++u) {
        int last = centre->v;
        for (int v = centre->v; last - v <= kBridgedPixels && centre->v - v <= reach; --v) {
            if (v < kBorderPixels) return std::nullopt;
            if (inside(u, v)) last = v;
        }
        if (last < highest) {
            second = highest;
            highest = last;
        } else {
            second = std::min(second, last);
        }
    }
    // The crown is as far away as the head's centre; the pixel's upper edge is where it ends.
    const Eigen::Vector3f crown = placement_.toMirror(
        unproject(frame_.intrinsics, static_cast<float>(centre->u), static_cast<float>(second) - 0.5F, depth));
    return crown.y();
}

bool Silhouette::standsInPicture() const {
    for (const Joint foot : {Joint::leftFoot, Joint::rightFoot}) {
        const JointState& joint = skeleton_[foot];
        if (joint.confidence < kSeen || joint.position.y() > kFootHeight) continue;
        const auto pixel = pixelOf(joint.position);
        if (pixel && pixel->v < map_.height - kBorderPixels) return true;
    }
    return false;
}

std::optional<float> Silhouette::crotchHeight() const {
    const JointState& leftKnee = skeleton_[Joint::leftKnee];
    const JointState& rightKnee = skeleton_[Joint::rightKnee];
    const JointState& leftHip = skeleton_[Joint::leftHip];
    const JointState& rightHip = skeleton_[Joint::rightHip];
    for (const JointState* joint : {&leftKnee, &rightKnee, &leftHip, &rightHip}) {
        if (joint->confidence < kSeen) return std::nullopt;
    }
    const auto knees = pixelOf(0.5F * (leftKnee.position + rightKnee.position));
    const Eigen::Vector3f hipCentre = 0.5F * (leftHip.position + rightHip.position);
    const auto hips = pixelOf(hipCentre);
    if (!knees || !hips || inside(knees->u, knees->v)) return std::nullopt;
    const float depth = placement_.toSensor(hipCentre).z();
    // Up between the legs, along the line from knees to hips.
    for (int v = knees->v; v > hips->v; --v) {
        const int u = hips->u + (knees->u - hips->u) * (v - hips->v) / std::max(knees->v - hips->v, 1);
        if (!inside(u, v)) continue;
        const Eigen::Vector3f crotch = placement_.toMirror(
            unproject(frame_.intrinsics, static_cast<float>(u), static_cast<float>(v) + 0.5F, depth));
        return crotch.y();
    }
    return std::nullopt;
}

}  // namespace cheval::fitting

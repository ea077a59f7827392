#include "tests/fitting/tracking/visit_recording.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "fitting/tracking/tracker.h"
#include "hal/sim/view.h"

namespace cheval::fitting::test {

namespace {

using Eigen::Vector3f;
namespace sim = hal::sim;

/// A body part as a capsule: the bone between two joints, its radius in metres, and the joints that are its own.
struct BodyPart {
    Joint from, to;
    float radius;
};
constexpr std::array<BodyPart, 16> kParts = {{{Joint::head, Joint::neck, 0.09F},
                                              {Joint::neck, Joint::torso, 0.13F},
                                              {Joint::torso, Joint::leftHip, 0.13F},
                                              {Joint::torso, Joint::rightHip, 0.13F},
                                              {Joint::leftShoulder, Joint::rightShoulder, 0.08F},
                                              {Joint::leftShoulder, Joint::leftHip, 0.10F},
                                              {Joint::rightShoulder, Joint::rightHip, 0.10F},
                                              {Joint::leftHip, Joint::rightHip, 0.11F},
                                              {Joint::leftShoulder, Joint::leftElbow, 0.05F},
                                              {Joint::rightShoulder, Joint::rightElbow, 0.05F},
                                              {Joint::leftElbow, Joint::leftHand, 0.045F},
                                              {Joint::rightElbow, Joint::rightHand, 0.045F},
                                              {Joint::leftHip, Joint::leftKnee, 0.08F},
                                              {Joint::rightHip, Joint::rightKnee, 0.08F},
                                              {Joint::leftKnee, Joint::leftFoot, 0.06F},
                                              {Joint::rightKnee, Joint::rightFoot, 0.06F}}};

float distanceTo(const Vector3f& point, const Vector3f& from, const Vector3f& to) {
    const Vector3f way = to - from;
    const float share = std::clamp((point - from).dot(way) / std::max(1e-6F, way.squaredNorm()), 0.0F, 1.0F);
    return (point - from - share * way).norm();
}

bool isTrunk(const BodyPart& part) {
    const auto middle = [](Joint joint) {
        return joint == Joint::neck || joint == Joint::torso || joint == Joint::leftShoulder ||
               joint == Joint::rightShoulder || joint == Joint::leftHip || joint == Joint::rightHip;
    };
    return middle(part.from) && middle(part.to);
}

/// The part on whose surface the point most likely lies.
const BodyPart& partAt(const Vector3f& point, const Skeleton& skeleton) {
    const auto outside = [&](const BodyPart& part) {
        return distanceTo(point, skeleton[part.from].position, skeleton[part.to].position) - part.radius;
    };
    return *std::min_element(kParts.begin(), kParts.end(),
                             [&](const BodyPart& a, const BodyPart& b) { return outside(a) < outside(b); });
}

bool ownPart(const BodyPart& part, Joint joint) {
    if (part.from == joint || part.to == joint) return true;
    // The trunk is one part of all its joints.
    return isTrunk(part) && isTrunk({joint, joint, 0.0F});
}

/// Whom most pixels of the active user show.
int figureOf(const Users& users, const sim::ExactView& exact) {
    const User* active = users.active();
    if (active == nullptr || users.map.empty()) return kNobody;
    std::array<int, sim::kMaximumFigures + 1> pixels{};
    for (int y = 0; y < users.map.height; ++y) {
        const std::uint8_t* label = users.map.row(y);
        const std::uint8_t* owner = exact.owner.row(y);
        for (int x = 0; x < users.map.width; ++x) {
            if (label[x] == active->label) ++pixels[owner[x]];
        }
    }
    const auto most = std::max_element(pixels.begin(), pixels.end());
    if (*most == 0) return kNobody;
    const auto figure = static_cast<int>(most - pixels.begin());
    return figure == 0 ? kRoom : figure - 1;
}

std::optional<Vector3f> nearestOther(const sim::WorldTruth& truth, const sim::View& view) {
    std::optional<Vector3f> nearest;
    for (std::size_t i = 1; i < truth.figureCount; ++i) {
        const sim::FigureTruth& figure = truth.figures[i];
        if (!figure.inRoom || figure.kind != sim::FigureKind::shopper) continue;
        const Vector3f torso = figure.skeleton[Joint::torso].position;
        const auto at = view.project(view.toSensor(torso));
        if (at.x() < 0.0F || at.x() >= static_cast<float>(view.intrinsics().width)) continue;
        const Vector3f way = torso - truth.skeleton[Joint::torso].position;
        if (!nearest || way.norm() < nearest->norm()) nearest = way;
    }
    return nearest;
}

}  // namespace

std::array<bool, kJointCount> visibleJoints(const Skeleton& skeleton, const SensorPlacement& placement,
                                            const hal::Intrinsics& intrinsics, const sim::ExactView& exact,
                                            std::uint8_t figure) {
    std::array<bool, kJointCount> visible{};
    for (std::size_t i = 0; i < kJointCount; ++i) {
        const auto joint = static_cast<Joint>(i);
        const Vector3f there = placement.toSensor(skeleton[joint].position);
        if (there.z() < 300.0F) continue;
        const Eigen::Vector2f pixel = project(intrinsics, there);
        const int x = static_cast<int>(std::lround(pixel.x()));
        const int y = static_cast<int>(std::lround(pixel.y()));
        if (!exact.depth.contains(x, y)) continue;
        const float surface = exact.depth.at(x, y);
        const float before = surface > 0.0F ? there.z() - surface : 0.0F;
        const bool own = exact.owner.at(x, y) == figure;
        const BodyPart& part =
            partAt(placement.toMirror(unproject(intrinsics, pixel.x(), pixel.y(), surface)), skeleton);
        const bool ownSurface = own && ownPart(part, joint);
        float limit = ownSurface ? 250.0F : 150.0F;
        if ((joint == Joint::leftHand || joint == Joint::rightHand) && !ownSurface) limit = 60.0F;
        visible[i] = before <= limit;
    }
    return visible;
}

VisitRecording recordVisit(sim::Script script, std::uint32_t seed, double seconds) {
    const auto world = sim::makeWorld({.seed = seed,
                                       .framesPerSecond = kVisitFramesPerSecond,
                                       .colour = false,
                                       .script = script,
                                       .visitSeconds = seconds});
    const sim::View view(hal::Intrinsics{}, world->options().mount);
    SensorPlacement placement;
    for (int axis = 0; axis < 3; ++axis)
        placement.rotation.col(axis) = view.toMirror(Vector3f::Unit(axis)) - view.place();
    placement.translation = view.place();

    VisitRecording recording{.script = script, .seed = seed};
    recording.meant.resize(128);
    recording.meant.resize(sim::gesturesOf(*world, 0.0, seconds, recording.meant));
    const auto frameCount = static_cast<std::uint64_t>(seconds * kVisitFramesPerSecond);
    recording.frames.reserve(frameCount);
    Tracker tracker(TrackerOptions{.mount = world->options().mount});
    hal::Image<std::uint16_t> depth;
    hal::Image<hal::Rgb8> none;
    for (std::uint64_t i = 0; i < frameCount; ++i) {
        sim::renderFrame(*world, i, depth, none);
        SeenFrame seen;
        seen.time = world->timeOf(i);
        const hal::DepthFrame frame{.sequence = i,
                                    .sourceIndex = i,
                                    .captureTime = hal::TimePoint(hal::fromSeconds(seen.time)),
                                    .restart = i == 0,
                                    .lastOfStill = true,
                                    .intrinsics = view.intrinsics(),
                                    .depth = depth.view()};
        tracker.track(frame);
        tracker.readHands(frame);
        const sim::WorldTruth truth = sim::truthAt(*world, seen.time);
        const sim::ExactView exact = sim::exactView(*world);
        const sim::FigureTruth& first = truth.figures[0];
        recording.shopper = first.wheelchair              ? ShopperKind::seated
                            : first.statureMetres < 1.45F ? ShopperKind::child
                                                          : ShopperKind::adult;
        seen.inRoom = truth.skeleton.present();
        seen.whollyInView = truth.present;
        seen.truth = truth.skeleton;
        seen.trueHands = truth.hands;
        if (seen.inRoom) {
            seen.visible = visibleJoints(truth.skeleton, placement, view.intrinsics(), exact, 1);
            seen.other = nearestOther(truth, view);
            const auto torso = view.project(view.toSensor(truth.skeleton[Joint::torso].position));
            seen.torsoInPicture = exact.depth.contains(static_cast<int>(torso.x()), static_cast<int>(torso.y()));
        }
        seen.tracked = tracker.skeleton();
        seen.hands = tracker.hands();
        seen.activeId = tracker.users().activeId;
        seen.activeFigure = figureOf(tracker.users(), exact);
        recording.frames.push_back(seen);
    }
    return recording;
}

}  // namespace cheval::fitting::test

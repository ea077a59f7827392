#include "hal/sim/world.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/sim/script.h"
#include "hal/sim/world_parts.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::HandState;
using fitting::Side;

/// Options as they are used: no visit without length, no rate without frames.
WorldOptions sane(WorldOptions options) {
    options.framesPerSecond = std::clamp(options.framesPerSecond, 1.0, 240.0);
    options.visitSeconds = std::max(options.visitSeconds, 1.0);
    options.pauseSeconds = std::max(options.pauseSeconds, 0.0);
    options.noiseScale = std::clamp(options.noiseScale, 0.0F, 5.0F);
    return options;
}

HandState handState(const View& view, const Rig& rig, const Pose& pose, Side side) {
    const std::size_t hand = bone(side, SideBone::hand);
    const std::size_t elbow = bone(side, SideBone::forearm);
    const float curl = pose.curl[fitting::index(side)];
    // Hanging hands are relaxed, whatever they look like.
    if (pose.position[hand].y() < pose.position[elbow].y()) return HandState::unknown;
    const Vector3f along = (rig.rest[hand] - rig.rest[elbow]).normalized();
    const Vector3f palm = pose.rotation[hand] * along.cross(Vector3f::UnitZ());
    const Vector3f toSensor = (view.place() - pose.position[hand]).normalized();
    if (std::abs(palm.dot(toSensor)) < 0.5F) return HandState::unknown;
    if (curl < 0.2F) return HandState::open;
    return curl > 0.8F ? HandState::closed : HandState::unknown;
}

bool whollyInView(const View& view, const Rig& rig, const Pose& pose) {
    const Intrinsics& lens = view.intrinsics();
    constexpr float kMargin = 4.0F;
    const auto inside = [&](const Vector3f& point) {
        const Vector3f seen = view.toSensor(point);
        if (seen.z() < 0.3F) return false;
        const auto at = view.project(seen);
        return at.x() >= kMargin && at.y() >= kMargin && at.x() <= static_cast<float>(lens.width) - kMargin &&
               at.y() <= static_cast<float>(lens.height) - kMargin;
    };
    bool all = inside(pose.apply(rig, bone(Bone::head), rig.crown));
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t foot = bone(side, SideBone::foot);
        const std::size_t tip = phalanx(side, 2, kPhalanxCount - 1);
        all = all && inside(pose.apply(rig, foot, rig.rest[foot] + rig.crown.y() * Vector3f(0.0F, -0.05F, 0.108F)));
        all = all && inside(pose.position[tip]) && inside(pose.position[bone(side, SideBone::upperArm)]);
    }
    return all;
}

FigureTruth truthOf(const View& view, const Cast& cast, const Performer& performer, const Moment& moment) {
    FigureTruth figure;
    figure.kind = performer.kind;
    figure.inRoom = inRoom(cast, performer, moment);
    figure.statureMetres = performer.kind == FigureKind::dog ? performer.dog.shoulderHeight
                                                             : performer.shopper.stature + performer.shopper.lift;
    figure.wheelchair = performer.shopper.wheelchair;
    if (performer.kind != FigureKind::dog) figure.measurements = measureBare(performer.shopper);
    if (!figure.inRoom || performer.kind == FigureKind::dog) return figure;
    const Rig rig = makeRig(performer.shopper);
    const Pose pose = poseOf(cast, performer, rig, moment);
    figure.whollyInView = whollyInView(view, rig, pose);
    figure.skeleton = skeletonOf(rig, pose);
    figure.skeleton.userId = 1;
    for (const Side side : {Side::left, Side::right})
        figure.hands[fitting::index(side)] = handState(view, rig, pose, side);
    return figure;
}

}  // namespace

World::Parts::Parts(const WorldOptions& theOptions)
    : options(sane(theOptions)), view(Intrinsics{}, options.mount), room(makeRoom(view, options.seed)) {}

World::World(const WorldOptions& options) : parts_(std::make_unique<Parts>(options)) {}
World::~World() = default;

const WorldOptions& World::options() const {
    return parts_->options;
}

double World::timeOf(std::uint64_t frame) const {
    return static_cast<double>(frame) / parts_->options.framesPerSecond;
}

TimePoint World::startAt(TimePoint now) {
    const std::lock_guard lock(parts_->zeroMutex);
    if (!parts_->zero) parts_->zero = now;
    return *parts_->zero;
}

void World::setFault(CameraFault fault) {
    parts_->fault = fault;
}
CameraFault World::fault() const {
    return parts_->fault;
}
void World::setLateness(Duration lateness) {
    parts_->lateness = std::max<Duration::rep>(0, lateness.count());
}
Duration World::lateness() const {
    return Duration(parts_->lateness);
}

std::shared_ptr<World> makeWorld(const WorldOptions& options) {
    return std::make_shared<World>(options);
}

WorldTruth truthAt(const World& world, double worldSeconds) {
    const World::Parts& parts = world.parts();
    const Moment moment = momentAt(parts.options, worldSeconds);
    Cast cast;
    castVisit(parts.options, moment.visit, cast);
    WorldTruth truth;
    truth.visit = moment.visit;
    for (const Performer& performer : cast.performers.view()) {
        FigureTruth& figure = truth.figures[truth.figureCount++];
        figure = truthOf(parts.view, cast, performer, moment);
        if (!figure.skeleton.present()) continue;
        figure.skeleton.userId = moment.visit + static_cast<std::uint32_t>(truth.figureCount);
        figure.skeleton.captureTime = TimePoint(fromSeconds(worldSeconds));
    }
    const FigureTruth& first = truth.figures[0];
    if (first.kind != FigureKind::shopper || !first.inRoom) return truth;
    truth.present = first.whollyInView;
    truth.skeleton = first.skeleton;
    truth.hands = first.hands;
    truth.statureMetres = first.statureMetres;
    return truth;
}

std::size_t gesturesOf(const World& world, double fromSeconds, double toSeconds, std::span<MeantGesture> gestures) {
    const WorldOptions& options = world.parts().options;
    Cast cast;
    std::size_t count = 0;
    const std::uint32_t last = momentAt(options, toSeconds).visit;
    for (std::uint32_t visit = momentAt(options, fromSeconds).visit; visit <= last; ++visit) {
        const double began = visit * (options.visitSeconds + options.pauseSeconds);
        castVisit(options, visit, cast);
        for (MeantGesture gesture : cast.meant.view()) {
            gesture.start += began;
            gesture.end += began;
            if (gesture.end < fromSeconds || gesture.start > toSeconds) continue;
            if (count == gestures.size()) return count;
            gestures[count++] = gesture;
        }
    }
    return count;
}

ExactView exactView(const World& world) {
    const World::Parts& parts = world.parts();
    return parts.scene ? std::as_const(*parts.scene).exact() : ExactView{};
}

void renderFrame(World& world, std::uint64_t frame, Image<std::uint16_t>& depth, Image<Rgb8>& colour) {
    World::Parts& parts = *world.parts_;
    const Intrinsics& lens = parts.view.intrinsics();
    if (depth.width != lens.width || depth.height != lens.height) depth.resize(lens.width, lens.height);
    if (!parts.options.colour) {
        colour = {};
    } else if (colour.width != lens.width || colour.height != lens.height) {
        colour.resize(lens.width, lens.height);
    }
    const std::lock_guard lock(parts.sceneMutex);
    if (!parts.scene) parts.scene = std::make_unique<Scene>(parts.options, parts.view, parts.room);
    parts.scene->render(frame, world.timeOf(frame), depth.view(), colour.view());
}

}  // namespace cheval::hal::sim

#include "hal/sim/part_writer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using fitting::Side;

/// How far one turns away to leave: a little short of the picture's own direction.
constexpr float kExitYaw = 1.45F;
constexpr std::uint32_t kChildKind = 2;

Reach onLap() {
    return {.palm = {-0.03F, -0.195F, 0.16F},
            .elbow = {0.7F, -0.5F, -0.5F},
            .fingers = {-0.25F, -0.25F, 0.93F},
            .facing = {0.0F, -1.0F, -0.2F},
            .curl = 0.3F};
}

}  // namespace

Shopper drawPerson(Draw& draw, bool grownUp) {
    std::uint32_t kind = draw.choice(6);
    if (grownUp && kind == kChildKind) kind = 3;
    Shopper shopper = makeShopper(0, 6 * draw.choice(1'000'000) + kind);
    shopper.wheelchair = draw.choice(25) == 0 && !grownUp && kind != kChildKind;
    return shopper;
}

Performer& addPerformer(Cast& cast, FigureKind kind, const Shopper& shopper) {
    Performer& performer = cast.performers.add({});
    performer.kind = kind;
    performer.shopper = shopper;
    return performer;
}

PartWriter::PartWriter(Performer& performer, Draw& draw) : performer_(performer), draw_(draw), rig_(rigOf(performer)) {
    if (!seated()) return;
    for (const Side side : {Side::left, Side::right})
        move(side, -1.0, 0.5, onLap());
}

int PartWriter::stepsFor(float metres, bool sideways) const {
    const float step = sideways ? 0.19F : 0.31F;  // Statures.
    return std::max(2, static_cast<int>(std::lround(metres / (step * performer_.shopper.stature))));
}

void PartWriter::beginAt(const Place& place) {
    if (performer_.part.walks.empty()) performer_.part.begin = place;
    place_ = place;
}

double PartWriter::walkIn(double start, float side, const Vector2f& spot) {
    const float entry = std::min(3.4F, spot.y() + draw_.between(0.4F, 0.75F));
    const Walk walk{.control = {Vector2f(side * 2.35F, entry), Vector2f(side * 1.25F + 0.5F * spot.x(), entry + 0.1F),
                                Vector2f(spot.x(), spot.y() + 0.7F), spot},
                    .start = start,
                    .end = start + draw_.between(2.5F, 3.4F),
                    .steps = stepsFor(2.9F, false),
                    .kind = WalkKind::arriving};
    if (performer_.part.walks.empty()) performer_.part.enters = start;
    performer_.part.walks.add(walk);
    place_ = {.position = spot, .yaw = 0.0F};
    return walk.end;
}

double PartWriter::walkOut(double start, float side) {
    const float yaw = -side * kExitYaw;
    const double turned = turn(start, 0.45 + 0.35 * std::abs(static_cast<double>(yaw - place_.yaw)), yaw);
    const Vector2f away(-std::sin(yaw), -std::cos(yaw));
    const float length = std::abs(side * kOutOfView - place_.position.x());
    const Vector2f from = place_.position;
    const Walk walk{
        .control = {from, from + length / 3.0F * away, from + 2.0F * length / 3.0F * away, from + length * away},
        .start = turned,
        .end = turned + 0.4 + static_cast<double>(length / draw_.between(1.0F, 1.4F)),
        .steps = stepsFor(length, false),
        .kind = WalkKind::leaving};
    performer_.part.walks.add(walk);
    performer_.part.leaves = walk.end;
    place_ = {.position = from + length * away, .yaw = yaw};
    return walk.end;
}

double PartWriter::turn(double start, double seconds, float yaw) {
    performer_.part.turns.add({.start = start, .end = start + seconds, .from = place_.yaw, .to = yaw});
    place_.yaw = yaw;
    return start + seconds;
}

double PartWriter::pace(double start, const Vector2f& to, float metresPerSecond, std::optional<float> facing) {
    const Vector2f from = place_.position;
    const float length = (to - from).norm();
    // Speed rises and falls evenly, so that the two ramps together cost the time of one.
    const float seconds = length / metresPerSecond + kPacingRamp;
    const Walk walk{.control = {from, from + (to - from) / 3.0F, from + 2.0F * (to - from) / 3.0F, to},
                    .start = start,
                    .end = start + static_cast<double>(seconds),
                    .steps = stepsFor(length, facing.has_value()),
                    .kind = WalkKind::pacing,
                    .ramp = kPacingRamp / seconds,
                    .facing = facing};
    performer_.part.walks.add(walk);
    place_ = walk.place(1.0F);
    return walk.end;
}

double PartWriter::passThrough(double start, float side, float depth, float metresPerSecond) {
    beginAt({.position = {side * kOutOfView, depth}, .yaw = 0.0F});
    if (performer_.part.walks.empty()) performer_.part.enters = start;
    performer_.part.leaves = pace(start, {-side * kOutOfView, depth}, metresPerSecond, std::nullopt);
    return performer_.part.leaves;
}

double PartWriter::move(Side side, double start, double seconds, const ArmAttitude& pose) {
    performer_.part.arms[fitting::index(side)].add({.start = start, .end = start + seconds, .pose = pose});
    return start + seconds;
}

double PartWriter::move(Side side, double start, double seconds, const Reach& reach) {
    return move(side, start, seconds, reaching(rig_, reach));
}

double PartWriter::rest(Side side, double start, double seconds) {
    return seated() ? move(side, start, seconds, onLap()) : move(side, start, seconds, attitude(ArmPose::hanging));
}

void PartWriter::glance(double start, double end, float pitch, float yaw) {
    performer_.part.glances.add({.start = start, .end = end, .pitch = pitch, .yaw = yaw});
}

bool PartWriter::hasRoom(std::size_t moves) const {
    const Part& part = performer_.part;
    return part.arms[0].room() >= moves && part.arms[1].room() >= moves && part.glances.room() > 0 &&
           part.turns.room() > 3 && part.walks.room() > 1;
}

}  // namespace cheval::hal::sim

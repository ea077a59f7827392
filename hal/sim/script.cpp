#include "hal/sim/script.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/sim/motion.h"
#include "hal/sim/part_writer.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using fitting::Side;

constexpr float kQuarter = 0.5F * std::numbers::pi_v<float>;

float drawSide(Draw& draw) {
    return draw.choice(2) == 0 ? -1.0F : 1.0F;
}

void writeVisit(const WorldOptions& options, std::uint32_t visit, Cast& cast) {
    addPerformer(cast, FigureKind::shopper, makeShopper(options.seed, visit));
    const double scale = options.visitSeconds / kScriptSeconds;
    for (MeantGesture gesture : kMeantInVisit) {
        gesture.start *= scale;
        gesture.end *= scale;
        cast.meant.add(gesture);
    }
}

void writeResting(Draw& draw, Cast& cast) {
    Performer& shopper = addPerformer(cast, FigureKind::shopper, drawPerson(draw));
    PartWriter writer(shopper, draw);
    shopper.part.sway = 0.0F;
    const double there = writer.walkIn(0.0, drawSide(draw), {draw.between(-0.3F, 0.3F), draw.between(2.45F, 2.55F)});
    const auto yaw = draw.between(-0.3F, 0.3F);
    if (std::abs(yaw) > 0.1F) writer.turn(there + 0.1, 0.5, yaw);
    // Some rest with a hand on the hip.
    if (draw.choice(3) == 0 && !writer.seated()) {
        writer.move(draw.choice(2) == 0 ? Side::left : Side::right, there, 0.6,
                    Reach{.palm = {0.05F, -0.225F, 0.02F},
                          .elbow = {1.0F, 0.0F, -0.4F},
                          .fingers = {-0.75F, -0.5F, 0.4F},
                          .facing = {-0.6F, 0.4F, -0.3F},
                          .curl = 0.2F});
    }
}

void writePacing(const WorldOptions& options, Draw& draw, Cast& cast) {
    Shopper person = drawPerson(draw);
    const bool facing = draw.choice(2) == 0;
    // A wheelchair does not roll sideways.
    if (facing) person.wheelchair = false;
    Performer& shopper = addPerformer(cast, FigureKind::shopper, person);
    PartWriter writer(shopper, draw);
    shopper.part.sway = 0.0F;
    float side = drawSide(draw);
    const float depth = draw.between(2.5F, 2.9F);
    const float reach = draw.between(0.7F, 0.85F);
    double now = writer.walkIn(0.0, side, {side * reach, depth}) + 0.3;
    while (now < options.visitSeconds && writer.hasRoom(1)) {
        side = -side;
        if (!facing) now = writer.turn(now, 0.8, -side * kQuarter);
        now = writer.pace(now, {side * reach, depth}, 1.0F,
                          facing ? std::optional<float>(0.0F) : std::optional<float>()) +
              draw.between(0.1F, 0.5F);
    }
}

/// The shopper comes and stays; two others come one after another, from either side and in any order.
void writePassersBy(Draw& draw, Cast& cast) {
    Performer& shopper = addPerformer(cast, FigureKind::shopper, drawPerson(draw));
    const Vector2f spot(draw.between(-0.3F, 0.3F), draw.between(2.4F, 2.55F));
    double now = PartWriter(shopper, draw).walkIn(0.0, drawSide(draw), spot) + draw.between(0.5F, 1.0F);
    enum Pass : std::uint8_t { before, behind, beside };
    std::array<Pass, 3> order = {before, behind, beside};
    for (std::uint32_t i = 2; i > 0; --i)
        std::swap(order[i], order[draw.choice(i + 1)]);
    PartWriter first(addPerformer(cast, FigureKind::shopper, drawPerson(draw)), draw);
    PartWriter second(addPerformer(cast, FigureKind::shopper, drawPerson(draw)), draw);
    PartWriter& friendly = draw.choice(2) == 0 ? first : second;
    for (const Pass pass : order) {
        const float side = drawSide(draw);
        const float speed = draw.between(1.0F, 1.4F);
        if (pass == before) {
            now = first.passThrough(now, side, spot.y() - draw.between(0.6F, 1.0F), speed);
        } else if (pass == behind) {
            now = second.passThrough(now, side, std::min(3.3F, spot.y() + draw.between(0.65F, 0.9F)), speed);
        } else {
            const Vector2f place = spot + Vector2f(side * draw.between(0.62F, 0.8F), draw.between(-0.12F, 0.12F));
            const double there = friendly.walkIn(now, side, place);
            now = friendly.walkOut(there + draw.between(0.8F, 1.6F), side);
        }
        now += draw.between(0.2F, 0.6F);
    }
}

void writeOcclusion(const WorldOptions& options, Draw& draw, Cast& cast) {
    Performer& shopper = addPerformer(cast, FigureKind::shopper, drawPerson(draw));
    const Vector2f spot(draw.between(-0.25F, 0.25F), draw.between(2.5F, 2.7F));
    const double there = PartWriter(shopper, draw).walkIn(0.0, drawSide(draw), spot);
    // Somebody large in a coat, on the line from the sensor, so near that trunk covers arms and shoulders cover
    // shoulders.
    constexpr std::uint32_t kTallKind = 5;
    Shopper large = makeShopper(0, 6 * draw.choice(1'000'000) + kTallKind);
    large.build = draw.between(0.6F, 0.9F);
    large.clothEase = draw.between(0.018F, 0.026F);
    large.sleeves = Sleeves::longSleeves;
    Performer& other = addPerformer(cast, FigureKind::shopper, large);
    const float halfShopper = (shopper.shopper.wheelchair ? 0.23F : 0.175F) * shopper.shopper.stature;
    const float halfOther = 0.16F * large.stature;
    const float eye = 1e-3F * options.mount.heightMm;
    const float above = 0.83F * shopper.shopper.stature - eye;
    float depth = spot.y() * halfOther / (halfShopper + 0.06F);
    if (above > 0.05F) depth = std::min(depth, spot.y() * (0.81F * large.stature - eye) / above);
    depth = std::clamp(depth, 1.05F, 1.5F);
    const Vector2f before(spot.x() * depth / spot.y(), depth);
    PartWriter writer(other, draw);
    const float side = drawSide(draw);
    const float yaw = draw.choice(2) == 0 ? 0.0F : 2.0F * kQuarter;
    writer.beginAt({.position = {side * kOutOfView, depth}, .yaw = yaw});
    other.part.enters = there + draw.between(0.3F, 0.8F);
    const double stood = writer.pace(other.part.enters, before, 1.0F, yaw);
    // While the other comes and goes, the shopper shows between their legs.
    other.part.leaves = writer.pace(stood + draw.between(0.65F, 0.75F),
                                    {(draw.choice(2) == 0 ? side : -side) * kOutOfView, depth}, 1.0F, yaw);
}

/// The mannequin is the same in every visit.
void writeMannequin(std::uint32_t seed, Draw& draw, Cast& cast) {
    Draw fixed(scramble(seed, 0x3a77U));
    const float side = drawSide(fixed);
    Performer& shopper = addPerformer(cast, FigureKind::shopper, drawPerson(draw));
    PartWriter writer(shopper, draw);
    const double there =
        writer.walkIn(draw.between(1.5F, 2.5F), side, {side * draw.between(0.0F, 0.25F), draw.between(2.4F, 2.8F)});
    writer.walkOut(there + draw.between(3.0F, 4.0F), side);
    Performer& mannequin = addPerformer(cast, FigureKind::mannequin, makeMannequin(fixed.choice(1U << 30U)));
    PartWriter still(mannequin, fixed);
    mannequin.part.sway = 0.0F;
    still.beginAt({.position = {-side * fixed.between(0.75F, 1.1F), fixed.between(2.7F, 3.2F)},
                   .yaw = fixed.between(-0.5F, 0.5F)});
    still.move(fixed.choice(2) == 0 ? Side::left : Side::right, -1.0, 0.5,
               Reach{.palm = {0.06F, -0.2F, 0.08F},
                     .elbow = {1.0F, -0.2F, -0.5F},
                     .fingers = {-0.2F, -0.5F, 0.8F},
                     .facing = {-0.9F, 0.0F, -0.2F},
                     .curl = 0.2F});
}

void writeDog(Draw& draw, Cast& cast) {
    Performer& performer = addPerformer(cast, FigureKind::dog, Shopper{});
    performer.dog = makeDog(draw.choice(1U << 30U));
    const float side = drawSide(draw);
    const float depth = draw.between(1.7F, 3.1F);
    const float other = draw.between(1.7F, 3.1F);
    const float middle = draw.between(-0.4F, 0.4F);
    const Walk walk{.control = {Vector2f(side * 2.6F, depth), Vector2f(side * 0.8F + middle, depth),
                                Vector2f(-side * 0.8F + middle, other), Vector2f(-side * 2.6F, other)},
                    .start = draw.between(0.5F, 1.0F),
                    .end = draw.between(5.5F, 7.0F),
                    .steps = 14,
                    .kind = WalkKind::pacing,
                    .ramp = 0.1F};
    performer.part.walks.add(walk);
    performer.part.enters = walk.start;
    performer.part.leaves = walk.end;
}

}  // namespace

Moment momentAt(const WorldOptions& options, double worldSeconds) {
    const double cycle = options.visitSeconds + options.pauseSeconds;
    const double visits = std::floor(std::max(0.0, worldSeconds) / cycle);
    const double within = std::max(0.0, worldSeconds) - visits * cycle;
    return {.visit = static_cast<std::uint32_t>(visits),
            .seconds = within,
            .scriptTime = within * kScriptSeconds / options.visitSeconds,
            .visiting = within < options.visitSeconds};
}

void castVisit(const WorldOptions& options, std::uint32_t visit, Cast& cast) {
    cast.script = options.script;
    cast.performers.clear();
    cast.meant.clear();
    Draw draw(scramble(scramble(options.seed, 0x5c217U + static_cast<std::uint32_t>(options.script)), visit));
    switch (options.script) {
        case Script::visit:
            return writeVisit(options, visit, cast);
        case Script::resting:
            return writeResting(draw, cast);
        case Script::pacing:
            return writePacing(options, draw, cast);
        case Script::gestures:
            return writeGestures(options, draw, cast);
        case Script::fidgeting:
            return writeFidgeting(options, draw, cast);
        case Script::passersBy:
            return writePassersBy(draw, cast);
        case Script::occlusion:
            return writeOcclusion(options, draw, cast);
        case Script::mannequin:
            return writeMannequin(options.seed, draw, cast);
        case Script::dog:
            return writeDog(draw, cast);
        case Script::measuring:
            return writeMeasuring(options, visit, draw, cast);
    }
}

std::size_t figuresOf(Script script) {
    switch (script) {
        case Script::passersBy:
            return 3;
        case Script::occlusion:
        case Script::mannequin:
            return 2;
        default:
            return 1;
    }
}

Rig rigOf(const Performer& performer) {
    return performer.kind == FigureKind::dog ? makeDogRig(performer.dog) : makeRig(performer.shopper);
}

bool inRoom(const Cast& cast, const Performer& performer, const Moment& moment) {
    // It stays when people leave.
    if (performer.kind == FigureKind::mannequin) return true;
    if (!moment.visiting) return false;
    return cast.script == Script::visit ||
           (moment.seconds >= performer.part.enters && moment.seconds <= performer.part.leaves);
}

Pose poseOf(const Cast& cast, const Performer& performer, const Rig& rig, const Moment& moment) {
    if (cast.script == Script::visit) return solvePose(rig, postureAt(performer.shopper, rig, moment.scriptTime));
    if (performer.kind == FigureKind::dog)
        return solveDog(performer.dog, rig, performer.part.walks.view().front(), moment.seconds);
    // A mannequin's arm, which a move has to bring where it is, is there from the first.
    const double seconds = performer.kind == FigureKind::mannequin ? 1.0 : moment.seconds;
    return solvePose(rig, postureAt(performer.part, rig, performer.shopper.wheelchair, seconds));
}

}  // namespace cheval::hal::sim

// Script::measuring: somebody stands before the mirror and turns, as who tries something on does.
#include <algorithm>
#include <numbers>

#include "hal/sim/part_writer.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using fitting::Side;

constexpr std::array<Side, 2> kSides = {Side::left, Side::right};
constexpr float kQuarter = 0.5F * std::numbers::pi_v<float>;

/// Arms hang a hand's breadth off the hips.
ArmAttitude slightlyAway(float away) {
    return {.upper = {0.25F + away, -0.95F, -0.03F},
            .forearm = {0.20F + away, -0.95F, 0.20F},
            .fingers = {0.15F + away, -0.97F, 0.16F},
            .palm = {-0.95F, -0.20F, -0.15F},
            .curl = 0.3F};
}
ArmAttitude halfRaised(float away) {
    return {.upper = {0.80F + away, -0.45F, 0.25F},
            .forearm = {0.70F, 0.10F, 0.70F},
            .fingers = {0.60F, 0.20F, 0.77F},
            .palm = {0.0F, -0.95F, 0.25F},
            .curl = 0.15F};
}

}  // namespace

void writeMeasuring(const WorldOptions& options, std::uint32_t visit, Draw& draw, Cast& cast) {
    const Shopper person = makeMeasuredShopper(options.seed, visit, options.clothing, options.everybody);
    Performer& shopper = addPerformer(cast, FigureKind::shopper, person);
    shopper.part.stoop = person.shares.stoop;
    PartWriter writer(shopper, draw);
    const auto between = [&](float low, float high) { return static_cast<double>(draw.between(low, high)); };
    const auto both = [&](double start, double seconds, const auto& pose) {
        double done = start;
        for (const Side side : kSides)
            done = writer.move(side, start, seconds, pose);
        return done;
    };
    // Nearer, the crown would leave the picture.
    const float eye = 1e-3F * options.mount.heightMm;
    const float crown = person.stature + person.lift + 0.12F;
    const float least = std::clamp((crown - eye) / 0.33F, 2.0F, 2.6F);
    const float side = draw.choice(2) == 0 ? -1.0F : 1.0F;
    const Vector2f spot(draw.between(-0.25F, 0.25F), draw.between(least, 2.65F));
    const double there = writer.walkIn(0.0, side, spot);
    const float away = draw.between(0.0F, 0.18F);
    if (writer.seated()) return;
    both(there - 0.4, 0.7, slightlyAway(away));
    double now = there + between(2.8F, 3.2F);
    now = both(now, 0.6, attitude(ArmPose::aPose)) + 1.5;
    now = both(now, 0.6, slightlyAway(away));
    // Shifts from one foot to the other.
    now = writer.pace(now, spot + Vector2f(draw.between(-0.12F, 0.12F), draw.between(-0.06F, 0.06F)), 0.4F, 0.0F) + 0.2;
    const float first = draw.choice(2) == 0 ? -kQuarter : kQuarter;
    for (const float yaw : {first, -first}) {
        now = writer.turn(now, between(0.9F, 1.2F), yaw) + 1.0;
        now = writer.turn(now, between(0.9F, 1.2F), 0.0F) + between(0.2F, 0.5F);
    }
    // Once round.
    for (int quarter = 1; quarter <= 4; ++quarter)
        now = writer.turn(now, between(0.65F, 0.8F),
                          static_cast<float>(quarter) * (first > 0.0F ? 1.0F : -1.0F) * kQuarter);
    const float facing = writer.place().yaw;
    for (int step = 0; step < 2; ++step)
        now = writer.pace(now + 0.1, spot + Vector2f(draw.between(-0.15F, 0.15F), draw.between(-0.1F, 0.1F)), 0.45F,
                          facing);
    now = both(now, 0.6, halfRaised(draw.between(-0.1F, 0.15F))) + between(0.6F, 1.0F);
    both(now, 0.6, slightlyAway(away));
}

}  // namespace cheval::hal::sim

// Script::fidgeting: all that people do before a mirror and mean nothing by.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/sim/part_writer.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using fitting::Side;

constexpr std::array<Side, 2> kSides = {Side::left, Side::right};
constexpr float kSixtyDegrees = std::numbers::pi_v<float> / 3.0F;

Reach atHem() {
    return {.palm = {-0.05F, -0.25F, 0.12F},
            .elbow = {0.9F, -0.2F, -0.5F},
            .fingers = {-0.45F, -0.75F, 0.35F},
            .facing = {-0.3F, 0.1F, -1.0F},
            .curl = 0.55F};
}
Reach atCollar() {
    return {.palm = {-0.065F, -0.015F, 0.085F},
            .elbow = {0.75F, -0.75F, 0.3F},
            .fingers = {-0.75F, 0.55F, -0.1F},
            .facing = {-0.1F, 0.0F, -1.0F},
            .curl = 0.5F};
}
Reach onHead() {
    return {.palm = {-0.04F, 0.155F, 0.0F},
            .elbow = {1.0F, -0.1F, 0.3F},
            .fingers = {-0.75F, 0.6F, -0.2F},
            .facing = {-0.7F, -0.6F, -0.1F},
            .curl = 0.3F};
}
Reach onHip() {
    return {.palm = {0.035F, -0.225F, 0.03F},
            .elbow = {1.0F, 0.0F, -0.5F},
            .fingers = {-0.7F, -0.5F, 0.45F},
            .facing = {-0.6F, 0.4F, -0.3F},
            .curl = 0.25F};
}
/// Forearms on each other before the chest; `upper` lies on top.
Reach folded(bool upper) {
    return {.palm = {-0.155F, upper ? -0.115F : -0.145F, upper ? 0.115F : 0.09F},
            .elbow = {0.7F, -0.7F, 0.1F},
            .fingers = {-0.9F, upper ? 0.25F : 0.05F, -0.2F},
            .facing = {-0.2F, 0.0F, -1.0F},
            .curl = 0.2F};
}
Reach lookingAtWatch() {
    return {.palm = {-0.10F, -0.085F, 0.175F},
            .elbow = {0.8F, -0.6F, 0.0F},
            .fingers = {-0.9F, 0.1F, 0.25F},
            .facing = {0.0F, -1.0F, 0.3F},
            .curl = 0.5F};
}

class Fidget {
  public:
    Fidget(PartWriter& writer, Draw& draw, double now)
        : writer_(writer), draw_(draw), spot_(writer.place().position), now_(now) {}

    [[nodiscard]] double now() const { return now_; }
    void next();

  private:
    double between(float low, float high) { return static_cast<double>(draw_.between(low, high)); }
    Side aSide() { return draw_.choice(2) == 0 ? Side::left : Side::right; }
    void rest(Side side) { now_ = std::max(now_, writer_.rest(side, now_, between(0.5F, 0.8F))); }
    void restBoth() {
        const double seconds = between(0.5F, 0.8F);
        for (const Side side : kSides)
            writer_.rest(side, now_, seconds);
        now_ += seconds;
    }
    /// Comes to `reach` and rubs or pulls about it.
    void workAt(Side side, const Reach& reach, const Vector3f& stroke, std::uint32_t times) {
        double time = writer_.move(side, now_, between(0.5F, 0.8F), reach);
        for (std::uint32_t i = 0; i < 2 * times; ++i) {
            Reach there = reach;
            if (i % 2 == 0) there.palm += stroke;
            time = writer_.move(side, time, between(0.14F, 0.25F), there);
        }
        now_ = time;
    }
    void step();
    void turnAside();
    void adjustClothes();
    void scratchHead();
    void talk();
    void foldArms();
    void handsOnHips();
    void lookAtWatch();

    PartWriter& writer_;
    Draw& draw_;
    Vector2f spot_;  ///< Where all happens about.
    double now_;
};

void Fidget::step() {
    const Vector2f to = spot_ + Vector2f(draw_.between(-0.3F, 0.3F), draw_.between(-0.15F, 0.25F));
    if ((to - writer_.place().position).norm() < 0.1F) return;
    now_ = writer_.pace(now_, to, draw_.between(0.45F, 0.8F), writer_.place().yaw) + 0.2;
}

void Fidget::turnAside() {
    const float yaw = (draw_.choice(2) == 0 ? -1.0F : 1.0F) * draw_.between(0.6F, 1.0F) * kSixtyDegrees;
    const double start = now_;
    now_ = writer_.turn(now_, between(0.8F, 1.3F), yaw) + between(0.4F, 1.2F);
    now_ = writer_.turn(now_, between(0.8F, 1.3F), 0.0F);
    writer_.glance(start + 0.2, now_, 0.0F, -0.5F * yaw);
}

void Fidget::adjustClothes() {
    if (draw_.choice(2) == 0) {
        const Side side = aSide();
        workAt(side, atCollar(), {draw_.between(-0.02F, 0.02F), -0.025F, 0.015F}, 1 + draw_.choice(3));
        rest(side);
        return;
    }
    const double start = now_;
    double done = now_;
    for (const Side side : kSides) {
        now_ = start;
        workAt(side, atHem(), {draw_.between(0.0F, 0.04F), -0.03F, 0.01F}, 2);
        done = std::max(done, now_);
    }
    now_ = done;
    writer_.glance(start, now_, 0.35F, 0.0F);
    restBoth();
}

void Fidget::scratchHead() {
    const Side side = aSide();
    workAt(side, onHead(), {0.02F, -0.02F, 0.015F}, 2 + draw_.choice(4));
    rest(side);
}

/// Both hands go about before the belly and the chest, as a talker's do: never twice the same way.
void Fidget::talk() {
    const double end = now_ + between(2.5F, 4.5F);
    double done = now_;
    for (const Side side : kSides) {
        double time = now_ + between(0.0F, 0.2F);
        while (time < end) {
            const Reach reach{
                .palm = {draw_.between(-0.10F, 0.08F), draw_.between(-0.21F, -0.08F), draw_.between(0.12F, 0.20F)},
                .elbow = {0.5F, -0.8F, -0.4F},
                .fingers = {draw_.between(-0.5F, 0.2F), draw_.between(-0.1F, 0.5F), 0.8F},
                .facing = {-0.7F, draw_.between(0.0F, 0.7F), 0.1F},
                .curl = draw_.between(0.1F, 0.45F)};
            time = writer_.move(side, time, between(0.3F, 0.6F), reach) + between(0.0F, 0.25F);
        }
        done = std::max(done, time);
    }
    writer_.glance(now_, done, 0.05F, draw_.between(-0.6F, 0.6F));
    now_ = done;
    restBoth();
}

void Fidget::foldArms() {
    const Side top = aSide();
    const double seconds = between(0.6F, 0.9F);
    for (const Side side : kSides)
        writer_.move(side, now_, seconds, folded(side == top));
    now_ += seconds + between(1.0F, 2.5F);
    restBoth();
}

void Fidget::handsOnHips() {
    const double seconds = between(0.5F, 0.8F);
    const bool both = draw_.choice(3) > 0;
    const Side one = aSide();
    for (const Side side : kSides) {
        if (both || side == one) writer_.move(side, now_, seconds, onHip());
    }
    now_ += seconds + between(1.0F, 2.0F);
    restBoth();
}

void Fidget::lookAtWatch() {
    const Side side = aSide();
    const double start = now_;
    now_ = writer_.move(side, now_, between(0.5F, 0.8F), lookingAtWatch()) + between(0.6F, 1.2F);
    writer_.glance(start, now_, 0.4F, side == Side::left ? 0.15F : -0.15F);
    rest(side);
}

void Fidget::next() {
    // Nobody steps or turns on the spot in a wheelchair, or reaches what they sit on.
    constexpr std::uint32_t kActions = 8;
    constexpr std::uint32_t kSeatedFrom = 3;
    const std::uint32_t first = writer_.seated() ? kSeatedFrom : 0;
    switch (first + draw_.choice(kActions - first)) {
        case 0:
            step();
            break;
        case 1:
            turnAside();
            break;
        case 2:
            handsOnHips();
            break;
        case 3:
            adjustClothes();
            break;
        case 4:
            scratchHead();
            break;
        case 5:
            talk();
            break;
        case 6:
            foldArms();
            break;
        default:
            lookAtWatch();
            break;
    }
    now_ += between(0.1F, 0.7F);
}

}  // namespace

void writeFidgeting(const WorldOptions& options, Draw& draw, Cast& cast) {
    Performer& shopper = addPerformer(cast, FigureKind::shopper, drawPerson(draw));
    PartWriter writer(shopper, draw);
    const float from = draw.choice(2) == 0 ? -1.0F : 1.0F;
    const double there = writer.walkIn(0.0, from, {draw.between(-0.25F, 0.25F), draw.between(2.5F, 2.75F)});
    Fidget fidget(writer, draw, there + 0.3);
    // Longest is a talk: 16 moves of each hand.
    while (fidget.now() < options.visitSeconds && writer.hasRoom(18))
        fidget.next();
}

}  // namespace cheval::hal::sim

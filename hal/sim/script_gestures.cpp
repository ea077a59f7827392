// Script::gestures: what the mirror is to react to.
#include <algorithm>

#include "hal/sim/part_writer.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::Side;
using fitting::SwipeDirection;

/// Shares of an ease between open and closed at which a hand counts as closed and no longer.
constexpr double kClosed = 0.68;
constexpr double kOpening = 1.0 - kClosed;

Side otherOf(Side side) {
    return side == Side::left ? Side::right : Side::left;
}

/// A hand held up to swipe: `x` and `y` as Reach::palm has them.
Reach heldUp(float x, float y, float ahead, float curl) {
    return {.palm = {x, y, ahead},
            .elbow = {0.75F, -0.75F, -0.1F},
            .fingers = {0.55F * x, 0.85F, 0.45F},
            .facing = {-0.15F, -0.35F, 0.9F},
            .curl = curl};
}

/// What one hand does, one thing after another, with its meaning noted down.
struct Hand {
    PartWriter& writer;
    Draw& draw;
    Cast& cast;
    Side side;
    double now;

    double seconds(float low, float high) const { return static_cast<double>(draw.between(low, high)); }
    void pause(float low, float high) { now += seconds(low, high); }
    void note(MeantKind kind, SwipeDirection direction, double start, double end) const {
        cast.meant.add({.kind = kind, .hand = side, .direction = direction, .start = start, .end = end});
    }
    void goTo(const Reach& reach, double duration) {
        note(MeantKind::transition, {}, now, now + duration);
        now = writer.move(side, now, duration, reach);
    }
    void drop() {
        const double duration = seconds(0.6F, 0.9F);
        note(MeantKind::transition, {}, now, now + duration);
        now = writer.rest(side, now, duration);
    }
    void stroke(const Reach& to, bool inward, float length, float speed) {
        const double duration = std::clamp(static_cast<double>(length / speed), 0.30, 0.65);
        // A left hand that goes inward goes to the shopper's right.
        const bool toLeft = inward == (side == Side::right);
        note(MeantKind::swipe, toLeft ? SwipeDirection::left : SwipeDirection::right, now, now + duration);
        now = writer.move(side, now, duration, to);
    }
    /// In a row, 1 … `most` times.
    void swipe(std::uint32_t most);
    void grab(std::uint32_t most);
};

void Hand::swipe(std::uint32_t most) {
    const float length = draw.between(0.23F, 0.36F);
    const float speed = draw.between(0.55F, 0.95F);  // Mean, statures a second.
    const float y = draw.between(-0.13F, 0.06F);
    const float ahead = draw.between(0.17F, 0.22F);
    const float curl = draw.between(0.02F, 0.15F);
    const float outer = draw.between(0.09F, 0.15F);
    const Reach out = heldUp(outer, y, ahead, curl);
    const Reach in = heldUp(outer - length, y + draw.between(-0.02F, 0.02F), ahead + 0.02F, curl);
    bool inward = draw.choice(2) == 0;
    goTo(inward ? out : in, seconds(0.7F, 0.95F));
    pause(0.2F, 0.5F);
    const std::uint32_t repeats = 1 + draw.choice(most);
    for (std::uint32_t i = 0; i < repeats; ++i) {
        stroke(inward ? in : out, inward, length, speed);
        pause(0.2F, 0.45F);
        if (i + 1 == repeats) break;
        if (draw.choice(2) == 0) {
            inward = !inward;
            continue;
        }
        // The same again: the hand sinks, and comes up where it began.
        Reach low = inward ? out : in;
        low.palm = {0.5F * (out.palm.x() + in.palm.x()), y - 0.13F, 0.9F * ahead};
        goTo(low, seconds(0.45F, 0.6F));
        goTo(inward ? out : in, seconds(0.45F, 0.65F));
        pause(0.2F, 0.4F);
    }
    drop();
}

void Hand::grab(std::uint32_t most) {
    const Reach open = heldUp(draw.between(0.04F, 0.11F), draw.between(-0.04F, 0.09F), draw.between(0.14F, 0.21F),
                              draw.between(0.0F, 0.06F));
    Reach closed = open;
    closed.curl = 1.0F;
    goTo(open, seconds(0.7F, 0.95F));
    const std::uint32_t repeats = 1 + draw.choice(most);
    for (std::uint32_t i = 0; i < repeats; ++i) {
        pause(0.4F, 0.8F);
        const double closing = seconds(0.16F, 0.28F);
        const double held = seconds(0.3F, 0.9F);
        const double opening = seconds(0.16F, 0.28F);
        note(MeantKind::grab, {}, now + kClosed * closing, now + closing + held + kOpening * opening);
        now = writer.move(side, now, closing, closed) + held;
        now = writer.move(side, now, opening, open);
    }
    pause(0.3F, 0.5F);
    drop();
}

}  // namespace

void writeGestures(const WorldOptions& options, Draw& draw, Cast& cast) {
    Performer& shopper = addPerformer(cast, FigureKind::shopper, drawPerson(draw));
    PartWriter writer(shopper, draw);
    const float from = draw.choice(2) == 0 ? -1.0F : 1.0F;
    double now = writer.walkIn(0.0, from, {draw.between(-0.3F, 0.3F), draw.between(2.4F, 2.95F)}) + 0.3;
    const float yaw = draw.between(-0.26F, 0.26F);
    if (!writer.seated()) now = writer.turn(now, 0.5, yaw);
    Side side = draw.choice(2) == 0 ? Side::left : Side::right;
    // One takes 5 seconds at most, each further one 2.3; 9 moves suffice for three.
    while (now + 6.0 < options.visitSeconds && writer.hasRoom(12) && cast.meant.room() > 12) {
        now += draw.between(0.2F, 1.0F);
        Hand hand{.writer = writer, .draw = draw, .cast = cast, .side = side, .now = now};
        const double left = options.visitSeconds - now;
        if (draw.choice(5) < 3) {
            hand.swipe(left > 9.6 ? 3 : left > 7.3 ? 2 : 1);
        } else {
            hand.grab(left > 7.3 ? 2 : 1);
        }
        now = hand.now;
        if (draw.choice(3) > 0) side = otherOf(side);
    }
}

}  // namespace cheval::hal::sim

#include "fitting/tracking/gestures.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting::tracking {
namespace {

/// Seconds over which the velocities of hands and of the whole person are averaged.
constexpr float kVelocitySpan = 0.05F;
constexpr float kWalkSpan = 0.25F;
/// Mean confidence of a hand that is closed to grab.
constexpr float kSurelyClosed = 0.7F;
/// A hand that is still on its way, statures a second, has not come to rest.
constexpr float kArrived = 0.20F;
/// What the state's confidence must be for a hold to count, and how far a hold is that waits for it.
constexpr float kSurelyOpen = 0.5F;
constexpr float kNearlyHeld = 0.99F;

void append(Hands& hands, const GestureEvent& event) {
    if (hands.gestureCount < kMaximumGestures) hands.gestures[hands.gestureCount++] = event;
}

float between(hal::TimePoint from, hal::TimePoint to) {
    return static_cast<float>(hal::seconds(to - from));
}

}  // namespace

void GestureReader::reset() {
    watches_ = {};
    userId_ = 0;
    neckVelocity_.setZero();
}

void GestureReader::update(const hal::DepthFrame& frame, const Skeleton& skeleton, float stature, Hands& hands) {
    if (skeleton.userId != userId_) reset();
    if (!skeleton.present() || stature <= 0.0F) return;
    const Moment now{frame.captureTime, frame.sourceIndex};
    const float elapsed = userId_ == 0 ? 0.0F : between(lastTime_, now.time);
    userId_ = skeleton.userId;
    lastTime_ = now.time;
    const Eigen::Vector3f neck = skeleton[Joint::neck].position;
    if (elapsed > 0.0F && elapsed < 0.5F) {
        const float weight = 1.0F - std::exp(-elapsed / kWalkSpan);
        neckVelocity_ += weight * ((neck - lastNeck_) / (elapsed * stature) - neckVelocity_);
    }
    lastNeck_ = neck;
    const bool walking = neckVelocity_.norm() > options_.walkingSpeed;
    // Sideways as the shopper sees it is sideways before the glass: the trunk may turn while the hand swipes.
    for (const Side side : {Side::left, Side::right}) {
        HandWatch& watch = watches_[index(side)];
        Hand hand = hands[side];
        hand.raised = hand.raised && !walking;
        const Eigen::Vector3f about = (hand.position - neck) / stature;
        const Eigen::Vector2f at(-about.x(), about.y());
        if (watch.seen && elapsed > 0.0F && elapsed < 0.5F) {
            const float weight = 1.0F - std::exp(-elapsed / kVelocitySpan);
            watch.velocity += weight * ((at - watch.last) / elapsed - watch.velocity);
        } else {
            watch.velocity.setZero();
            watch.still = false;
        }
        watch.last = at;
        watch.seen = true;
        const bool swiped = watchSwipe(watch, now, at, hand.raised, side, hands);
        if (watch.grab == Grab::closed) watch.sureness += hand.confidence * elapsed;
        const bool grabbed = watchGrab(watch, now, at, hand, side, hands);
        hands[side].holding = watchHold(watch, now, hand, about, swiped || grabbed, side, hands);
        const Joint shoulder = side == Side::left ? Joint::leftShoulder : Joint::rightShoulder;
        watchRaise(watch, now, hand.raised && hand.position.y() > skeleton[shoulder].position.y(), side, hands);
    }
}

bool GestureReader::watchSwipe(HandWatch& watch, const Moment& now, const Eigen::Vector2f& at, bool raised, Side side,
                               Hands& hands) const {
    const float speed = watch.velocity.x();
    if (!watch.stroke) {
        if (raised && std::abs(speed) >= options_.swipeStartSpeed) {
            watch.stroke = true;
            watch.direction = speed > 0.0F ? 1.0F : -1.0F;
            watch.peak = 0.0F;
            watch.from = at;
            watch.strokeStart = now;
        }
        return false;
    }
    watch.peak = std::max(watch.peak, speed * watch.direction);
    const float lasted = between(watch.strokeStart.time, now.time);
    if (speed * watch.direction > options_.swipeEndSpeed && raised && lasted < options_.swipeLongest) return false;
    watch.stroke = false;
    const Eigen::Vector2f way = at - watch.from;
    if (!raised || lasted >= options_.swipeLongest || watch.peak < options_.swipePeakSpeed) return false;
    if (way.x() * watch.direction < options_.swipeDistance) return false;
    if (std::abs(way.y()) > options_.swipeSteepest * std::abs(way.x())) return false;
    append(hands, {.kind = GestureKind::swipe,
                   .hand = side,
                   .direction = watch.direction > 0.0F ? SwipeDirection::left : SwipeDirection::right,
                   .start = watch.strokeStart.time,
                   .end = now.time,
                   .startFrame = watch.strokeStart.frame,
                   .endFrame = now.frame});
    return true;
}

bool GestureReader::watchGrab(HandWatch& watch, const Moment& now, const Eigen::Vector2f& at, const Hand& hand,
                              Side side, Hands& hands) const {
    if (!hand.raised || hand.state == HandState::unknown) {
        watch.grab = Grab::idle;
        return false;
    }
    const float lasted = between(watch.grabStart.time, now.time);
    switch (watch.grab) {
        case Grab::idle:
            if (hand.state == HandState::open) {
                watch.grab = Grab::open;
                watch.grabStart = now;
            }
            break;
        case Grab::open:
            if (hand.state == HandState::closed) {
                watch.grab = lasted >= options_.grabOpenBefore ? Grab::closed : Grab::idle;
                watch.grabStart = now;
                watch.sureness = 0.0F;
            }
            break;
        case Grab::closed:
            if (hand.state != HandState::open) break;
            watch.grab = Grab::open;
            // Hands that talk do so before the chest, half closed.
            if (lasted >= options_.grabClosedLeast && lasted <= options_.grabClosedLongest &&
                at.y() >= options_.grabLowest && watch.sureness >= kSurelyClosed * lasted) {
                append(hands, {.kind = GestureKind::grab,
                               .hand = side,
                               .start = watch.grabStart.time,
                               .end = now.time,
                               .startFrame = watch.grabStart.frame,
                               .endFrame = now.frame});
                watch.grabStart = now;
                return true;
            }
            watch.grabStart = now;
            break;
    }
    return false;
}

float GestureReader::watchHold(HandWatch& watch, const Moment& now, const Hand& hand, const Eigen::Vector3f& about,
                               bool gestured, Side side, Hands& hands) const {
    if (hand.raised == watch.lowered) {
        watch.lowered = !hand.raised;
        watch.loweredSince = now;
    }
    const bool rested = watch.lowered && between(watch.loweredSince.time, now.time) >= options_.holdRest;
    if (rested || (about - watch.spentAt).norm() > options_.holdAway) watch.spent = watch.held = false;
    if (gestured) {
        // Whoever has swiped or grabbed waits for what comes of it, with the hand where it is.
        watch.spent = true;
        watch.held = false;
        watch.spentAt = about;
    }
    if (watch.stroke || watch.spent || !hand.raised || hand.state != HandState::open) {
        watch.still = false;
        return watch.held ? 1.0F : 0.0F;
    }
    if (!watch.still || (about - watch.stillAt).norm() > options_.holdMovement) {
        watch.still = watch.velocity.norm() < kArrived;
        watch.stillAt = about;
        watch.stillSince = now;
        return 0.0F;
    }
    const float lasted = between(watch.stillSince.time, now.time);
    // A fist is read as open now and then, but seldom surely.
    if (lasted < options_.holdTime || hand.confidence < kSurelyOpen)
        return std::min(lasted / options_.holdTime, kNearlyHeld);
    watch.spent = watch.held = true;
    watch.spentAt = about;
    append(hands, {.kind = GestureKind::hold,
                   .hand = side,
                   .start = watch.stillSince.time,
                   .end = now.time,
                   .startFrame = watch.stillSince.frame,
                   .endFrame = now.frame});
    return 1.0F;
}

void GestureReader::watchRaise(HandWatch& watch, const Moment& now, bool up, Side side, Hands& hands) const {
    if (up != watch.up) {
        watch.up = up;
        (up ? watch.upSince : watch.downSince) = now;
    }
    if (!up) {
        if (between(watch.downSince.time, now.time) >= options_.raiseRest) watch.counted = false;
        return;
    }
    if (watch.counted || between(watch.upSince.time, now.time) < options_.raiseHold) return;
    watch.counted = true;
    append(hands, {.kind = GestureKind::raise,
                   .hand = side,
                   .start = watch.upSince.time,
                   .end = now.time,
                   .startFrame = watch.upSince.frame,
                   .endFrame = now.frame});
}

}  // namespace cheval::fitting::tracking

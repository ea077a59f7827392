#include "hal/sim/part.h"

#include <algorithm>
#include <cmath>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using fitting::Side;

/// Seconds around a walk in which sway fades.
constexpr double kSettling = 0.6;

/// The last walk that has begun, and 0 before the first; the walk after it.
struct Way {
    const Walk* last = nullptr;
    const Walk* next = nullptr;
};
Way wayAt(const Part& part, double time) {
    Way way;
    for (const Walk& walk : part.walks.view()) {
        if (walk.start > time) {
            way.next = &walk;
            break;
        }
        way.last = &walk;
    }
    return way;
}

/// The turns of the stand that follows `walk`.
std::span<const Turn> turnsAfter(const Part& part, const Walk* walk) {
    std::span<const Turn> turns = part.turns.view();
    while (walk != nullptr && !turns.empty() && turns.front().start < walk->end - 1e-6)
        turns = turns.subspan(1);
    return turns;
}

void sit(const Rig& rig, Posture& posture) {
    const float h = rig.crown.y();
    posture.pelvis.y() = kSeatedHip * h;
    const Vector3f ahead(-std::sin(posture.yaw), 0.0F, -std::cos(posture.yaw));
    const Vector3f left(-std::cos(posture.yaw), 0.0F, std::sin(posture.yaw));
    for (const Side side : {Side::left, Side::right}) {
        const float outward = (side == Side::left ? 1.0F : -1.0F) * rig.at(Side::left, SideBone::foot).x();
        posture.feet[fitting::index(side)] = {
            .ankle = Vector3f(posture.pelvis.x(), kSeatedAnkleHeight * h, posture.pelvis.z()) +
                     h * kSeatedAnkleAhead * ahead + outward * left,
            .yaw = posture.yaw};
    }
}

}  // namespace

Posture postureAt(const Part& part, const Rig& rig, bool seated, double time) {
    const Gait gait = gaitOf(rig);
    Posture posture;
    posture.pelvis.y() = rig.at(Bone::pelvis).y() - 0.013F * gait.legLength;
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t i = fitting::index(side);
        posture.arms[i] = armAt(part.arms[i].view(), time);
    }
    const Way way = wayAt(part, time);
    float strength = part.sway;
    if (way.last != nullptr) strength *= ease(way.last->end - kSettling, way.last->end + kSettling, time);
    if (way.next != nullptr) strength *= 1.0F - ease(way.next->start - kSettling, way.next->start, time);
    posture.chestPitch += part.stoop;
    posture.headPitch -= 0.8F * part.stoop;
    sway(time, seated ? 0.4F * strength : strength, posture);
    const float swayX = posture.pelvis.x();
    const float swayZ = posture.pelvis.z();
    if (way.last != nullptr && time < way.last->end) {
        if (seated) {
            const Place place = way.last->place(way.last->progress(time));
            posture.pelvis.x() = place.position.x();
            posture.pelvis.z() = place.position.y();
            posture.yaw = place.yaw;
        } else {
            walkBody(*way.last, gait, time, posture);
            walkFeet(*way.last, gait, time, posture);
        }
    } else {
        const Place place = way.last != nullptr ? way.last->place(1.0F) : part.begin;
        stand(gait, place.position, place.yaw, turnsAfter(part, way.last), time, posture);
    }
    posture.pelvis.x() += swayX;
    posture.pelvis.z() += swayZ;
    if (seated) sit(rig, posture);
    for (const Glance& glance : part.glances.view()) {
        const double fade = std::min(0.35, 0.5 * (glance.end - glance.start));
        const float share = ease(glance.start, glance.start + fade, time) - ease(glance.end - fade, glance.end, time);
        posture.headPitch += share * glance.pitch;
        posture.headYaw += share * glance.yaw;
    }
    return posture;
}

}  // namespace cheval::hal::sim

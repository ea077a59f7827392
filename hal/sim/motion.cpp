#include "hal/sim/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "hal/sim/arms.h"
#include "hal/sim/gait.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using fitting::Side;
using fitting::SwipeDirection;

constexpr float kPi = std::numbers::pi_v<float>;

struct PoseMove {
    double start, end;
    ArmPose pose;
};
constexpr std::array<PoseMove, 7> kRightMoves = {{{3.2, 3.95, ArmPose::aPose},
                                                  {5.95, 6.6, ArmPose::hanging},
                                                  {9.8, 10.55, ArmPose::raised},
                                                  {12.5, 12.9, ArmPose::outward},
                                                  {13.0, 13.45, ArmPose::inward},
                                                  {13.7, 14.15, ArmPose::outward},
                                                  {14.35, 15.1, ArmPose::hanging}}};
constexpr std::array<PoseMove, 6> kLeftMoves = {{{3.2, 3.95, ArmPose::aPose},
                                                 {5.95, 6.6, ArmPose::hanging},
                                                 {14.6, 15.35, ArmPose::outward},
                                                 {15.5, 15.95, ArmPose::inward},
                                                 {16.2, 16.65, ArmPose::outward},
                                                 {16.75, 17.5, ArmPose::hanging}}};
constexpr double kGrabFrom = 11.1;  ///< The raised right hand begins to close …
constexpr double kGrabTo = 12.0;    ///< … and to open again.
constexpr double kGrabEase = 0.22;
/// Shares of the hand's ease at which it counts as closed and no longer.
constexpr double kClosed = 0.673;
constexpr double kOpening = 1.0 - kClosed;

constexpr double kArrived = 3.3;
constexpr double kLeaving = 18.05;
constexpr float kTurnAngle = 40.0F * kPi / 180.0F;

template <std::size_t N>
ArmAttitude armAfter(const std::array<PoseMove, N>& table, double time) {
    std::array<ArmMove, N> moves;
    for (std::size_t i = 0; i < N; ++i)
        moves[i] = {.start = table[i].start, .end = table[i].end, .pose = attitude(table[i].pose)};
    return armAt(moves, time);
}

}  // namespace

const std::array<MeantGesture, 13> kMeantInVisit = {{
    {MeantKind::transition, Side::left, {}, 3.2, 3.95},
    {MeantKind::transition, Side::right, {}, 3.2, 3.95},
    {MeantKind::transition, Side::left, {}, 5.95, 6.6},
    {MeantKind::transition, Side::right, {}, 5.95, 6.6},
    {MeantKind::grab, Side::right, {}, kGrabFrom + kClosed* kGrabEase, kGrabTo + kOpening* kGrabEase},
    {MeantKind::transition, Side::right, {}, 12.5, 12.9},
    {MeantKind::swipe, Side::right, SwipeDirection::left, 13.0, 13.45},
    {MeantKind::swipe, Side::right, SwipeDirection::right, 13.7, 14.15},
    {MeantKind::transition, Side::right, {}, 14.35, 15.1},
    {MeantKind::transition, Side::left, {}, 14.6, 15.35},
    {MeantKind::swipe, Side::left, SwipeDirection::right, 15.5, 15.95},
    {MeantKind::swipe, Side::left, SwipeDirection::left, 16.2, 16.65},
    {MeantKind::transition, Side::left, {}, 16.75, 17.5},
}};

Posture postureAt(const Shopper& shopper, const Rig& rig, double time) {
    const Gait gait = gaitOf(rig);
    const float exitYaw = shopper.exitSide < 0.0F ? 1.45F : -1.45F;
    const std::array<Turn, 5> turns = {{{6.7, 7.55, 0.0F, kTurnAngle},
                                        {7.75, 9.0, kTurnAngle, -kTurnAngle},
                                        {9.15, 9.9, -kTurnAngle, 0.0F},
                                        {16.9, 17.5, 0.0F, 0.5F * exitYaw},
                                        {17.5, kLeaving, 0.5F * exitYaw, exitYaw}}};
    const int steps = shopper.stature < 1.5F ? 7 : 6;
    const Vector2f spot(0.0F, kStandDepth);
    const Vector2f away(-std::sin(exitYaw), -std::cos(exitYaw));
    const Walk in{.control = {Vector2f(-2.35F, shopper.entryDepth), Vector2f(-1.25F, shopper.entryDepth + 0.15F),
                              Vector2f(0.0F, kStandDepth + 0.75F), spot},
                  .start = 0.0,
                  .end = kArrived,
                  .steps = steps,
                  .kind = WalkKind::arriving};
    const Walk out{.control = {spot, spot + 0.7F * away, spot + 1.4F * away, spot + 2.1F * away},
                   .start = kLeaving,
                   .end = kScriptSeconds,
                   .steps = shopper.stature < 1.5F ? 5 : 4,
                   .kind = WalkKind::leaving};

    Posture posture;
    posture.pelvis.y() = rig.at(Bone::pelvis).y() - 0.013F * gait.legLength;
    posture.arms[fitting::index(Side::left)] = armAfter(kLeftMoves, time);
    posture.arms[fitting::index(Side::right)] = armAfter(kRightMoves, time);
    posture.arms[fitting::index(Side::right)].curl +=
        ease(kGrabFrom, kGrabFrom + kGrabEase, time) - ease(kGrabTo, kGrabTo + kGrabEase, time);

    sway(time, ease(kArrived - 0.6, kArrived + 0.6, time) - ease(kLeaving - 0.6, kLeaving + 0.2, time), posture);
    const float swayX = posture.pelvis.x();
    const float swayZ = posture.pelvis.z();
    if (time < kArrived) {
        walkBody(in, gait, time, posture);
        walkFeet(in, gait, time, posture);
    } else if (time > kLeaving) {
        walkBody(out, gait, time, posture);
        walkFeet(out, gait, time, posture);
    } else {
        stand(gait, spot, 0.0F, turns, time, posture);
    }
    posture.pelvis.x() += swayX;
    posture.pelvis.z() += swayZ;
    // While turned aside, one keeps an eye on the mirror.
    if (time >= kArrived && time < 16.9) posture.headYaw -= 0.55F * posture.yaw;
    return posture;
}

}  // namespace cheval::hal::sim

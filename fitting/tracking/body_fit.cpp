#include "fitting/tracking/body_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace cheval::fitting::tracking {
namespace {

// --- The unknowns ---------------------------------------------------------------------------------------------------

constexpr int kMove = 0;    ///< Three: the trunk's middle.
constexpr int kTurn = 3;    ///< Three: rotation vector of the trunk, mirror frame.
constexpr int kHead = 6;    ///< Two: the head's direction in its tangent plane.
constexpr int kLimbs = 8;   ///< Four a limb: upper bone, lower bone; left arm, right arm, left leg, right leg.
constexpr int kSizes = 24;  ///< The lengths.
constexpr int kUnknowns = kSizes + static_cast<int>(kBodyLengthCount);

using Matrix = Eigen::Matrix<float, kUnknowns, kUnknowns>;
using Vector = Eigen::Matrix<float, kUnknowns, 1>;

/// Depth points of one surface err together (cloth, a shape that is not ours): all of them weigh as this many.
constexpr float kIndependentPoints = 140.0F;
constexpr float kSurfaceSpread = 0.014F;  ///< Metres, one standard deviation.
constexpr float kRobust = 0.055F;         ///< Beyond this a point counts ever less.
constexpr float kBoneSpread = 0.020F;
/// Exchanged legs explain the same points: only this tells them from the right ones.
constexpr float kCrossedCost = 2.0F;
/// How much of the forward direction may point away from the glass, and away from where a person walks.
constexpr float kTurnedAway = 0.35F;
constexpr float kWalkedAway = 0.20F;
constexpr float kSettled = 0.004F;
constexpr float kHopeless = 1.6F;
/// Of the ankle's joint above the floor, in shares of the leg's two bones.
constexpr float kAnkleHeight = 0.087F;

/// One row of the Jacobian with few entries.
struct Row {
    std::array<std::pair<int, float>, 24> entries;
    int count = 0;

    void add(int unknown, float value) { entries[static_cast<std::size_t>(count++)] = {unknown, value}; }
    void add(int unknown, const Eigen::Vector3f& values) {
        for (int k = 0; k < 3; ++k) {
            add(unknown + k, values[k]);
        }
    }
};

struct System {
    Matrix hessian = Matrix::Zero();
    Vector gradient = Vector::Zero();
    float cost = 0.0F;

    /// A residual (in standard deviations) whose row has been divided by the same.
    void add(const Row& row, float residual, float weight) {
        for (int i = 0; i < row.count; ++i) {
            const auto [a, x] = row.entries[static_cast<std::size_t>(i)];
            gradient[a] += weight * x * residual;
            for (int k = 0; k <= i; ++k) {
                const auto [b, y] = row.entries[static_cast<std::size_t>(k)];
                hessian(std::max(a, b), std::min(a, b)) += weight * x * y;
            }
        }
    }
    /// value / spread drawn to 0, for one unknown.
    void hold(int unknown, float value, float spread) {
        const float inverse = 1.0F / spread;
        gradient[unknown] += value * inverse * inverse;
        hessian(unknown, unknown) += inverse * inverse;
    }
};

/// Two unit vectors that span the plane across a direction.
struct Tangent {
    Eigen::Vector3f first, second;
    explicit Tangent(const Eigen::Vector3f& direction)
        : first(direction.unitOrthogonal()), second(direction.cross(first)) {}
};

constexpr int limbUnknown(bool leg, Side side) {
    return kLimbs + (leg ? 8 : 0) + (side == Side::left ? 0 : 4);
}

/// What one linearisation needs to know about the pose.
struct Linear {
    explicit Linear(const ArticulatedPose& thePose)
        : pose(thePose),
          headTangent(pose.headDirection),
          tangents{{{Tangent(pose.arms[0].upper), Tangent(pose.arms[0].lower)},
                    {Tangent(pose.arms[1].upper), Tangent(pose.arms[1].lower)},
                    {Tangent(pose.legs[0].upper), Tangent(pose.legs[0].lower)},
                    {Tangent(pose.legs[1].upper), Tangent(pose.legs[1].lower)}}} {}

    const ArticulatedPose& pose;
    Tangent headTangent;
    std::array<std::array<Tangent, 2>, 4> tangents;  ///< Of limbs in the unknowns' order, upper and lower.

    /// How n·q moves, for the point `at` that is fixed to the trunk.
    void trunkPoint(Row& row, const Eigen::Vector3f& at, const Eigen::Vector3f& n) const {
        row.add(kMove, n);
        row.add(kTurn, (at - pose.middle).cross(n));
    }
    void neckPoint(Row& row, const Eigen::Vector3f& n) const {
        trunkPoint(row, pose.neck(), n);
        row.add(kSizes + static_cast<int>(index(BodyLength::trunk)), 0.5F * n.dot(pose.up()));
    }
    /// The joint from which a limb hangs.
    void rootPoint(Row& row, bool leg, Side side, const Eigen::Vector3f& n) const {
        trunkPoint(row, leg ? pose.hip(side) : pose.shoulder(side), n);
        row.add(kSizes + static_cast<int>(index(BodyLength::trunk)),
                (leg ? -0.5F : 0.5F - kShoulderDrop) * n.dot(pose.up()));
        row.add(kSizes + static_cast<int>(index(leg ? BodyLength::hipHalfBreadth : BodyLength::shoulderHalfBreadth)),
                outwards(side) * n.dot(pose.left()));
    }
    /// A point of a limb: `upper` and `lower` metres along its two bones, the shares of the bones' own lengths in them.
    void limbPoint(Row& row, bool leg, Side side, float upper, float lower, float upperShare, float lowerShare,
                   const Eigen::Vector3f& n) const {
        rootPoint(row, leg, side, n);
        const LimbDirections& limb = (leg ? pose.legs : pose.arms)[fitting::index(side)];
        const auto& tangent = tangents[(leg ? 2U : 0U) + fitting::index(side)];
        const int unknown = limbUnknown(leg, side);
        row.add(unknown, upper * n.dot(tangent[0].first));
        row.add(unknown + 1, upper * n.dot(tangent[0].second));
        row.add(kSizes + static_cast<int>(index(leg ? BodyLength::thigh : BodyLength::upperArm)),
                upperShare * n.dot(limb.upper));
        if (lower == 0.0F) return;
        row.add(unknown + 2, lower * n.dot(tangent[1].first));
        row.add(unknown + 3, lower * n.dot(tangent[1].second));
        row.add(kSizes + static_cast<int>(index(leg ? BodyLength::shank : BodyLength::forearm)),
                lowerShare * n.dot(limb.lower));
    }
    /// The place of the body that a depth point belongs to.
    void partPoint(Row& row, const BodySurface::Place& at, const Eigen::Vector3f& n) const;
};

void Linear::partPoint(Row& row, const BodySurface::Place& at, const Eigen::Vector3f& n) const {
    const BodyPart part = at.part;
    if (part == BodyPart::trunk) {
        trunkPoint(row, at.point, n);
        row.add(kSizes + static_cast<int>(index(BodyLength::trunk)), at.along * n.dot(pose.up()));
        row.add(kSizes + static_cast<int>(index(BodyLength::hipSetback)), (0.5F - at.along) * n.dot(pose.forward()));
        const float sideways = at.across * n.dot(pose.left());
        row.add(kSizes + static_cast<int>(index(BodyLength::trunkHalfWidth)), sideways);
        // The slab is as wide as the depth leaves it.
        row.add(kSizes + static_cast<int>(index(BodyLength::trunkDepth)), -sideways);
        return;
    }
    if (part == BodyPart::head || part == BodyPart::neck) {
        neckPoint(row, n);
        const float reach = (at.point - pose.neck()).dot(pose.headDirection);
        row.add(kHead, reach * n.dot(headTangent.first));
        row.add(kHead + 1, reach * n.dot(headTangent.second));
        return;
    }
    const auto number = static_cast<int>(part) - static_cast<int>(BodyPart::leftUpperArm);
    const Side side = number % 2 == 0 ? Side::left : Side::right;
    const int kind = number / 2;  // 0 upper arm, 1 thigh, 2 forearm, 3 shank, 4 foot.
    const bool leg = kind % 2 == 1 || kind == 4;
    const float upperLength = pose.length(leg ? BodyLength::thigh : BodyLength::upperArm);
    const float lowerLength = pose.length(leg ? BodyLength::shank : BodyLength::forearm);
    if (kind < 2) {
        limbPoint(row, leg, side, at.along * upperLength, 0.0F, at.along, 0.0F, n);
    } else if (kind == 4) {
        limbPoint(row, leg, side, upperLength, lowerLength, 1.0F, 1.0F, n);
    } else {
        const Eigen::Vector3f middle = leg ? pose.knee(side) : pose.elbow(side);
        limbPoint(row, leg, side, upperLength, (at.point - middle).norm(), 1.0F, std::min(1.0F, at.along), n);
    }
}

// --- What the depth says --------------------------------------------------------------------------------------------

void addPoints(const BodyFitJob& job, const Linear& linear, const BodySurface& surface, System& system) {
    const float share = std::min(1.0F, kIndependentPoints / static_cast<float>(job.points.size()));
    const Eigen::Vector3f eye = job.cloud->placement.translation;
    for (const Eigen::Vector3f& point : job.points) {
        const BodySurface::Place nearest = surface.nearest(point);
        Eigen::Vector3f normal = point - nearest.point;
        const float away = normal.norm();
        if (away < 1e-4F) continue;
        normal /= away;
        float residual = nearest.distance;
        const Eigen::Vector3f towardsEye = (eye - point).normalized();
        if (normal.dot(towardsEye) < -0.1F) {
            // The point lies behind the bone, but only the near side can be seen.
            normal = towardsEye;
            residual = (point - nearest.point).dot(towardsEye) - nearest.radius;
        }
        const float robust = 1.0F / (1.0F + (residual * residual) / (kRobust * kRobust));
        system.cost += share * (residual * residual) * robust / (kSurfaceSpread * kSurfaceSpread);
        Row row;
        linear.partPoint(row, nearest, -normal);
        if (nearest.part == BodyPart::trunk) row.add(kSizes + static_cast<int>(index(BodyLength::trunkDepth)), -1.0F);
        for (int k = 0; k < row.count; ++k) {
            row.entries[static_cast<std::size_t>(k)].second /= kSurfaceSpread;
        }
        system.add(row, residual / kSurfaceSpread, share * robust * robust);
    }
}

/// One place of a bone against the outline and the front surface.
void addBonePlace(const BodyFitJob& job, const Linear& linear, bool leg, Side side, float share, bool lower,
                  float radius, System& system) {
    const ArticulatedPose& pose = linear.pose;
    const LimbDirections& limb = (leg ? pose.legs : pose.arms)[fitting::index(side)];
    const float upperLength = pose.length(leg ? BodyLength::thigh : BodyLength::upperArm);
    const float lowerLength = pose.length(leg ? BodyLength::shank : BodyLength::forearm);
    const Eigen::Vector3f root = leg ? pose.hip(side) : pose.shoulder(side);
    const Eigen::Vector3f at = lower
                                   ? Eigen::Vector3f(root + upperLength * limb.upper + share * lowerLength * limb.lower)
                                   : Eigen::Vector3f(root + share * upperLength * limb.upper);
    const Silhouette& s = *job.silhouette;
    const Eigen::Vector3f cell = job.cloud->toCell(at);
    const int column = static_cast<int>(std::lround(cell.x()));
    const int row = static_cast<int>(std::lround(cell.y()));
    if (cell.z() <= 0.0F || column < 1 || row < 1 || column >= kCloudWidth - 1 || row >= kCloudHeight - 1) return;
    Eigen::Vector3f direction;
    float residual = 0.0F;
    if (!s.contains(column - 1, row - 1) || !s.contains(column + 1, row + 1)) {
        system.cost += 4.0F;  // Far outside; nothing says where to.
        return;
    }
    const std::size_t i = cellIndex(column, row);
    const Eigen::Matrix3f& rotation = job.cloud->placement.rotation;
    if (s.inside[i] == 0) {
        const float across = s.outside[i + 1] - s.outside[i - 1];
        const float down = s.outside[i + kCloudWidth] - s.outside[i - kCloudWidth];
        const Eigen::Vector3f sensor(across, -down, 0.0F);
        if (sensor.norm() < 1e-3F) return;
        direction = rotation * sensor.normalized();
        residual = s.outside[i] * job.cloud->cellSize(cell.z());
        if (job.cloud->depth[i] <= 0.0F) residual *= 0.6F;  // Perhaps a shadow, or a dark sleeve.
    } else {
        const float before = s.surface[i] - (cell.z() - radius);
        if (before <= 0.0F) return;  // On the surface or hidden behind it.
        direction = rotation * Eigen::Vector3f(0.0F, 0.0F, -1.0F);
        residual = before;
    }
    const float robust = 1.0F / (1.0F + residual * residual / (0.12F * 0.12F));
    system.cost += residual * residual * robust / (kBoneSpread * kBoneSpread);
    Row jacobian;
    linear.limbPoint(jacobian, leg, side, lower ? upperLength : share * upperLength, lower ? share * lowerLength : 0.0F,
                     lower ? 1.0F : share, lower ? share : 0.0F, direction / kBoneSpread);
    system.add(jacobian, residual / kBoneSpread, robust * robust);
}

void addBones(const BodyFitJob& job, const Linear& linear, System& system) {
    const float scale = linear.pose.length(BodyLength::trunk);
    for (const Side side : {Side::left, Side::right}) {
        for (const bool leg : {false, true}) {
            const float radius = (leg ? 0.11F : 0.07F) * scale;
            for (const float share : {0.4F, 0.7F, 1.0F}) {
                addBonePlace(job, linear, leg, side, share, false, radius, system);
                addBonePlace(job, linear, leg, side, share, true, 0.8F * radius, system);
            }
        }
    }
}

// --- What bodies do -------------------------------------------------------------------------------------------------

/// Draws a direction to where another points: (direction − target) in the tangent plane, in standard deviations.
void drawDirection(System& system, int unknown, const Tangent& tangent, const Eigen::Vector3f& direction,
                   const Eigen::Vector3f& target, float spread) {
    const Eigen::Vector3f off = direction - target.normalized();
    system.hold(unknown, off.dot(tangent.first), spread);
    system.hold(unknown + 1, off.dot(tangent.second), spread);
    system.cost += off.squaredNorm() / (spread * spread);
}

/// Pushes a direction so that its product with `axis` falls to 0: only where it is above.
void pushOff(System& system, int unknown, const Tangent& tangent, const Eigen::Vector3f& axis, float excess,
             float spread) {
    if (excess <= 0.0F) return;
    Row row;
    row.add(unknown, tangent.first.dot(axis) / spread);
    row.add(unknown + 1, tangent.second.dot(axis) / spread);
    system.add(row, excess / spread, 1.0F);
    system.cost += excess * excess / (spread * spread);
}

/// The lower foot stands on the floor, and neither is under it.
void addStanding(const Linear& linear, System& system) {
    const ArticulatedPose& pose = linear.pose;
    constexpr float kSpread = 0.02F;
    const float ankle = kAnkleHeight * (pose.length(BodyLength::thigh) + pose.length(BodyLength::shank));
    const bool leftIsLower = pose.foot(Side::left).y() < pose.foot(Side::right).y();
    for (const Side side : {Side::left, Side::right}) {
        const float above = pose.foot(side).y() - ankle;
        if (above > 0.0F && (side == Side::left) != leftIsLower) continue;
        const float robust = 1.0F / (1.0F + above * above / (0.10F * 0.10F));
        Row row;
        linear.limbPoint(row, true, side, pose.length(BodyLength::thigh), pose.length(BodyLength::shank), 1.0F, 1.0F,
                         Eigen::Vector3f(0.0F, 1.0F / kSpread, 0.0F));
        system.add(row, above / kSpread, robust * robust);
        system.cost += above * above * robust / (kSpread * kSpread);
    }
}

void addBody(const BodyFitJob& job, const Linear& linear, System& system) {
    const ArticulatedPose& pose = linear.pose;
    const auto& tangents = linear.tangents;
    // Trunks stand upright and, without evidence, face the glass. Whoever leaves that does so wholly: beyond `far` the
    // pull lets go.
    const auto tilt = [&](const Eigen::Vector3f& axis, const Eigen::Vector3f& of, float spread, float far) {
        const float value = of.dot(axis);
        const float robust = 1.0F / (1.0F + value * value / (far * far));
        Row row;
        row.add(kTurn, Eigen::Vector3f(of.cross(axis) / spread));
        system.add(row, value / spread, robust * robust);
        system.cost += value * value * robust / (spread * spread);
    };
    tilt(Eigen::Vector3f::UnitX(), pose.up(), 0.08F, 0.25F);
    tilt(Eigen::Vector3f::UnitZ(), pose.up(), 0.05F, 0.15F);
    tilt(Eigen::Vector3f::UnitZ(), pose.left(), 1.2F, 10.0F);
    // Nobody looks into a mirror backwards, and nobody walks sideways backwards.
    const auto turnFrom = [&](const Eigen::Vector3f& direction, float most) {
        constexpr float kSpread = 0.08F;
        const float excess = pose.forward().dot(direction) - most;
        if (excess <= 0.0F) return;
        Row row;
        row.add(kTurn, Eigen::Vector3f(pose.forward().cross(direction) / kSpread));
        system.add(row, excess / kSpread, 1.0F);
        system.cost += excess * excess / (kSpread * kSpread);
    };
    turnFrom(Eigen::Vector3f::UnitZ(), kTurnedAway);
    if (std::abs(job.sideways) > kWalking) {
        turnFrom(Eigen::Vector3f(job.sideways > 0.0F ? -1.0F : 1.0F, 0.0F, 0.0F), kWalkedAway);
    }
    // Heads are held up and a little forwards.
    drawDirection(system, kHead, linear.headTangent, pose.headDirection, pose.up() + 0.27F * pose.forward(), 0.13F);
    if (job.headSeen) {
        constexpr float kSpread = 0.018F;
        const Eigen::Vector3f off = pose.head() - job.head;
        const float reach = (1.0F - kHeadCentre) * pose.length(BodyLength::headDrop);
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3f n = Eigen::Vector3f::Unit(axis) / kSpread;
            Row row;
            linear.neckPoint(row, n);
            row.add(kHead, reach * n.dot(linear.headTangent.first));
            row.add(kHead + 1, reach * n.dot(linear.headTangent.second));
            row.add(kSizes + static_cast<int>(index(BodyLength::headDrop)),
                    (1.0F - kHeadCentre) * n.dot(pose.headDirection));
            system.add(row, off[axis] / kSpread, 1.0F);
        }
        system.cost += off.squaredNorm() / (kSpread * kSpread);
    }
    for (const Side side : {Side::left, Side::right}) {
        const float out = outwards(side);
        const LimbDirections& arm = pose.arms[fitting::index(side)];
        const auto& armTangent = tangents[fitting::index(side)];
        const int armUnknown = limbUnknown(false, side);
        constexpr float kHinge = 0.15F;
        pushOff(system, armUnknown, armTangent[0], -pose.forward(), -arm.upper.dot(pose.forward()) - 0.45F, kHinge);
        pushOff(system, armUnknown, armTangent[0], -out * pose.left(), -out * arm.upper.dot(pose.left()) - 0.40F,
                kHinge);
        const float bend = arm.upper.dot(arm.lower);
        pushOff(system, armUnknown + 2, armTangent[1], -arm.upper, -bend - 0.75F, kHinge);
        const Eigen::Vector3f fold = arm.lower - bend * arm.upper;
        pushOff(system, armUnknown + 2, armTangent[1], -pose.forward(), -fold.dot(pose.forward()) - 0.10F, kHinge);
        // Weakly, for an arm that nothing shows: it hangs.
        drawDirection(system, armUnknown, armTangent[0], arm.upper, 0.15F * out * pose.left() - pose.up(), 1.6F);
        drawDirection(system, armUnknown + 2, armTangent[1], arm.lower, arm.upper + 0.2F * pose.forward(), 1.2F);

        const LimbDirections& leg = pose.legs[fitting::index(side)];
        const auto& legTangent = tangents[2 + fitting::index(side)];
        const int legUnknown = limbUnknown(true, side);
        const Eigen::Vector3f down = -Eigen::Vector3f::UnitY();
        if (job.seated) {
            const auto [thigh, shank] = seatedLeg(pose.axes);
            drawDirection(system, legUnknown, legTangent[0], leg.upper, thigh + 0.1F * out * pose.left(), 0.20F);
            drawDirection(system, legUnknown + 2, legTangent[1], leg.lower, shank, 0.20F);
        } else {
            drawDirection(system, legUnknown, legTangent[0], leg.upper,
                          down + 0.05F * out * pose.left() + 0.03F * pose.forward(), 0.30F);
            // A shank slants backwards from the knee: the ankle lies behind the leg's axis.
            drawDirection(system, legUnknown + 2, legTangent[1], leg.lower, leg.upper - 0.27F * pose.forward(), 0.25F);
        }
        // Each foot keeps to its own side of the body, or legs that pass each other would exchange their names.
        constexpr float kCrossed = 0.05F;
        const float acrossMiddle = 0.01F - out * (pose.foot(side) - pose.hipMiddle()).dot(pose.left());
        if (acrossMiddle > 0.0F) {
            const Eigen::Vector3f inwards = -out * pose.left() / kCrossed;
            const float thigh = pose.length(BodyLength::thigh);
            const float shank = pose.length(BodyLength::shank);
            Row row;
            row.add(legUnknown, thigh * inwards.dot(legTangent[0].first));
            row.add(legUnknown + 1, thigh * inwards.dot(legTangent[0].second));
            row.add(legUnknown + 2, shank * inwards.dot(legTangent[1].first));
            row.add(legUnknown + 3, shank * inwards.dot(legTangent[1].second));
            system.add(row, acrossMiddle / kCrossed, 1.0F);
            system.cost += kCrossedCost * acrossMiddle * acrossMiddle / (kCrossed * kCrossed);
        }
        const Eigen::Vector3f bent = leg.lower - leg.upper.dot(leg.lower) * leg.upper;
        pushOff(system, legUnknown + 2, legTangent[1], pose.forward(), bent.dot(pose.forward()), 0.05F);
    }
    if (job.floorKnown && !job.seated) addStanding(linear, system);
}

void addSizes(const BodyFitJob& job, const ArticulatedPose& pose, System& system) {
    for (std::size_t k = 0; k < kBodyLengthCount; ++k) {
        const float off = pose.size[k] - job.usual[k];
        system.hold(kSizes + static_cast<int>(k), off, job.spread[k]);
        system.cost += off * off / (job.spread[k] * job.spread[k]);
        if (job.learnt != nullptr) {
            system.hold(kSizes + static_cast<int>(k), pose.size[k] - (*job.learnt)[k], 0.4F * job.spread[k]);
        }
    }
}

/// Weakly to the frame before, for what nothing else holds. Not part of the cost.
void addPrevious(const BodyFitJob& job, const Linear& linear, System& system) {
    if (job.previous == nullptr) return;
    const ArticulatedPose& pose = linear.pose;
    const ArticulatedPose& before = *job.previous;
    const float cost = system.cost;
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t k = fitting::index(side);
        for (const bool leg : {false, true}) {
            const int unknown = limbUnknown(leg, side);
            const auto& tangent = linear.tangents[(leg ? 2U : 0U) + k];
            const LimbDirections& now = leg ? pose.legs[k] : pose.arms[k];
            const LimbDirections& then = leg ? before.legs[k] : before.arms[k];
            drawDirection(system, unknown, tangent[0], now.upper, then.upper, 0.6F);
            drawDirection(system, unknown + 2, tangent[1], now.lower, then.lower, 0.8F);
        }
    }
    system.cost = cost;
}

void turn(Eigen::Vector3f& direction, const Tangent& tangent, float first, float second) {
    constexpr float kMost = 0.6F;
    direction = (direction + std::clamp(first, -kMost, kMost) * tangent.first +
                 std::clamp(second, -kMost, kMost) * tangent.second)
                    .normalized();
}

ArticulatedPose stepped(const Linear& linear, const Vector& step, const BodyFitJob& job) {
    ArticulatedPose pose = linear.pose;
    Eigen::Vector3f move = step.segment<3>(kMove);
    if (move.norm() > 0.15F) move *= 0.15F / move.norm();
    pose.middle += move;
    Eigen::Vector3f rotation = step.segment<3>(kTurn);
    const float angle = std::min(rotation.norm(), 0.4F);
    if (angle > 1e-6F) pose.axes = Eigen::AngleAxisf(angle, rotation.normalized()) * pose.axes;
    turn(pose.headDirection, linear.headTangent, step[kHead], step[kHead + 1]);
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t k = fitting::index(side);
        for (const bool leg : {false, true}) {
            const int unknown = limbUnknown(leg, side);
            LimbDirections& limb = leg ? pose.legs[k] : pose.arms[k];
            const auto& tangent = linear.tangents[(leg ? 2U : 0U) + k];
            turn(limb.upper, tangent[0], step[unknown], step[unknown + 1]);
            turn(limb.lower, tangent[1], step[unknown + 2], step[unknown + 3]);
        }
    }
    for (std::size_t k = 0; k < kBodyLengthCount; ++k) {
        const float most = 2.5F * job.spread[k];
        pose.size[k] =
            std::clamp(pose.size[k] + step[kSizes + static_cast<int>(k)], job.usual[k] - most, job.usual[k] + most);
    }
    return pose;
}

}  // namespace

void BodyFitJob::run() {
    ArticulatedPose trial = start;
    pose = start;
    cost = 1e9F;
    for (int round = 0; round <= rounds; ++round) {
        const Linear linear(trial);
        const BodySurface surface(trial);
        System system;
        addPoints(*this, linear, surface, system);
        addBones(*this, linear, system);
        addBody(*this, linear, system);
        addSizes(*this, trial, system);
        if (!std::isfinite(system.cost)) break;
        const float gain = cost - system.cost;
        if (gain > 0.0F) {
            cost = system.cost;
            pose = trial;
        }
        // Settled, or so far from what is already known that the rounds left will not reach it.
        const bool settled = round > 1 && std::abs(gain) < kSettled * cost;
        const bool hopeless = round > 1 && cost > kHopeless * toBeat;
        if (round == rounds || settled || hopeless) break;
        addPrevious(*this, linear, system);
        system.hessian.diagonal() *= 1.02F;
        system.hessian.diagonal().array() += 1e-3F;
        const Vector step = system.hessian.selfadjointView<Eigen::Lower>().ldlt().solve(-system.gradient);
        if (!step.allFinite()) break;
        trial = stepped(linear, step, *this);
    }
    // Rotations drift from orthonormal by rounding.
    pose.axes.col(1).normalize();
    pose.axes.col(0) = (pose.axes.col(0) - pose.axes.col(1) * pose.axes.col(1).dot(pose.axes.col(0))).normalized();
    pose.axes.col(2) = pose.axes.col(0).cross(pose.axes.col(1));
}

}  // namespace cheval::fitting::tracking

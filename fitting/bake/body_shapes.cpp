#include "fitting/bake/body_shapes.h"

#include <array>
#include <cmath>
#include <functional>

#include <Eigen/LU>

#include "fitting/bake/spline.h"
#include "fitting/body/body_measures.h"

namespace cheval::fitting::bake {
namespace {

constexpr std::size_t kCount = kShapeParameterCount;

/// A point of the mannequin's surface or skeleton and what it hangs on.
struct Place {
    Vec3 point;
    double arm = 0.0, leg = 0.0;  ///< Shares of the limbs' bones; the rest is trunk and head.
};

double bell(double x, double width) {
    return std::exp(-0.5 * x * x / (width * width));
}

/// 1 at `middle`, 0 from `low` down and from `high` up.
double hump(double low, double middle, double high, double x) {
    return x < middle ? smoothStep(low, middle, x) : 1.0 - smoothStep(middle, high, x);
}

// Heights of the mannequin, metres. Girths are changed most at their own height and not at all at the next one's.
constexpr double kStature = 1.75;
constexpr double kMiddle = 0.015;  // Half the breadth over which the two halves meet.
constexpr double kAnkleHeight = 0.086;
constexpr double kCrotch = 0.800;
constexpr double kSeat = 0.885;
constexpr double kWaist = 1.106;
constexpr double kBust = 1.280;
constexpr double kArmpit = 1.360;
constexpr double kNeckBase = 1.478;
constexpr double kThroat = 1.530;
constexpr double kChin = 1.545;

class Fields {
  public:
    explicit Fields(const BodyField& body) : body_(body) {}

    /// Displacement of a place by one unit of a raw field. Raw fields have the parameters' names but change other
    /// dimensions as well.
    [[nodiscard]] Vec3 at(ShapeParameter field, const Place& place) const {
        // Described for the left half.
        const double side = place.point.x() < 0.0 ? -1.0 : 1.0;
        Place left = place;
        left.point.x() = std::abs(place.point.x());
        Vec3 moved = leftHalf(field, left);
        // What is on the middle stays there.
        moved.x() *= side * std::min(1.0, left.point.x() / kMiddle);
        return moved;
    }

  private:
    [[nodiscard]] double axisDepth(double y) const { return body_.trunkLoft().centre(std::min(y, 1.56)).z(); }
    /// Away from the trunk's axis.
    [[nodiscard]] Vec3 outward(const Vec3& p) const { return {p.x(), 0.0, p.z() - axisDepth(p.y())}; }
    [[nodiscard]] Vec3 shoulder() const { return body_.joints()[index(Joint::leftShoulder)]; }

    /// Away from a limb's axis, and how far along it.
    struct Limb {
        Vec3 outward;
        double along;
    };
    [[nodiscard]] static Limb limb(const Loft& loft, const Vec3& p) {
        const double along = (p - loft.shape().origin).dot(loft.shape().axis);
        const Vec3 off = p - loft.centre(std::clamp(along, 0.0, 0.84));
        return {.outward = off - off.dot(loft.shape().axis) * loft.shape().axis, .along = along};
    }
    /// Scales the trunk's sections round its axis, by `share` of their size, where `where` says; arms stay.
    [[nodiscard]] Vec3 girth(const Place& place, double where, double aroundMetres) const {
        return (1.0 - place.arm) * where / aroundMetres * outward(place.point);
    }

    [[nodiscard]] Vec3 leftHalf(ShapeParameter field, const Place& place) const {
        const Vec3& p = place.point;
        const double trunk = 1.0 - place.arm;
        switch (field) {
            case ShapeParameter::stature:
                return p / kStature;
            case ShapeParameter::chestGirth:
                return girth(place, hump(kWaist - 0.14, kBust + 0.01, kNeckBase + 0.02, p.y()), 0.95);
            case ShapeParameter::waistGirth:
                return girth(place, hump(kSeat - 0.13, kWaist - 0.01, kArmpit + 0.04, p.y()), 0.80);
            case ShapeParameter::hipGirth:
                // The thighs take it up and lose it on their way to the knees.
                return girth(place, hump(0.45, kSeat, kBust - 0.04, p.y()), 0.98);
            case ShapeParameter::neckGirth: {
                const double where = hump(kNeckBase - 0.06, kThroat, kChin + 0.07, p.y());
                return trunk * where / 0.36 * Vec3(p.x(), 0.0, p.z() - axisDepth(p.y()));
            }
            case ShapeParameter::shoulderBreadth: {
                const double where = hump(kWaist + 0.05, kArmpit + 0.02, kNeckBase + 0.01, p.y());
                const double outwards = std::min(1.0, p.x() / shoulder().x());
                return Vec3(0.5 * (place.arm + trunk * where * outwards), 0.0, 0.0);
            }
            case ShapeParameter::armLength: {
                const Loft::Shape& arm = body_.armLoft().shape();
                const double along = std::clamp((p - arm.origin).dot(arm.axis), 0.0, kWristAlong);
                return place.arm * along / kWristAlong * arm.axis;
            }
            case ShapeParameter::insideLeg:
                return Vec3(0.0, std::clamp((p.y() - kAnkleHeight) / (kCrotch - kAnkleHeight), 0.0, 1.0), 0.0) *
                           (1.0 - place.arm) +
                       place.arm * Vec3::UnitY();
            case ShapeParameter::headHeight: {
                const double head = trunk * smoothStep(kThroat - 0.04, kChin + 0.05, p.y());
                return head / 0.205 * (p - Vec3(0.0, kChin, 0.0));
            }
            case ShapeParameter::chestDepth:
                return trunk * hump(kWaist - 0.14, kBust + 0.01, kNeckBase + 0.02, p.y()) / 0.22 *
                       Vec3(0.0, 0.0, outward(p).z());
            case ShapeParameter::waistDepth: {
                // The front half grows: a belly, which hangs low.
                const double where = hump(kSeat - 0.13, 1.065, kBust + 0.03, p.y());
                return trunk * where * std::max(outward(p).z(), 0.0) / 0.10 * Vec3::UnitZ();
            }
            case ShapeParameter::hipDepth:
                // The back half grows: a seat.
                return trunk * hump(kSeat - 0.19, kSeat, kSeat + 0.20, p.y()) * std::min(outward(p).z(), 0.0) / 0.11 *
                       Vec3::UnitZ();
            case ShapeParameter::thighGirth: {
                const Limb leg = limb(body_.legLoft(), p);
                const Limb arm = limb(body_.armLoft(), p);
                const double thigh = place.leg * (1.0 - 0.85 * smoothStep(0.10, 0.80, leg.along));
                const double upperArm = 0.7 * place.arm * (1.0 - 0.85 * smoothStep(0.10, 0.52, arm.along));
                // Thighs that meet in the middle grow outwards.
                return thigh / 0.52 * (leg.outward + Vec3(0.045, 0.0, 0.0)) + upperArm / 0.52 * arm.outward;
            }
            case ShapeParameter::waistRise:
                return trunk * hump(kSeat - 0.05, kWaist, kBust + 0.05, p.y()) * Vec3::UnitY();
            case ShapeParameter::bust: {
                const Vec3 from = p - Vec3(0.076, kBust - 0.006, 0.085);
                const double breast =
                    std::exp(-0.5 * (from.x() * from.x() / (0.046 * 0.046) + from.y() * from.y() / (0.042 * 0.042) +
                                     from.z() * from.z() / (0.075 * 0.075)));
                return trunk * breast * Vec3(0.15, -0.12, 1.0);
            }
            case ShapeParameter::masculine:
                return masculine(place, smoothStep(-0.4, 0.6, outward(p).z() / 0.1));
            case ShapeParameter::ribs:
                return girth(place, hump(kWaist - 0.04, 0.5 * (kWaist + kBust), kBust + 0.04, p.y()), 0.90);
            case ShapeParameter::flanks:
                return girth(place, hump(kSeat - 0.02, 0.5 * (kSeat + kWaist), kWaist + 0.02, p.y()), 0.88);
            case ShapeParameter::chestSquareness: {
                const Vec3 away = outward(p);
                const double length = away.norm();
                if (length < 1e-6) return Vec3::Zero();
                // Most where the section's corners are: as far to the side as to the front or back, for its size.
                const double side = away.x() / 0.16;
                const double ahead = away.z() / 0.115;
                const double corner = 4.0 * side * side * ahead * ahead / std::pow(side * side + ahead * ahead, 2.0);
                return trunk * hump(kWaist - 0.06, kBust, kNeckBase - 0.02, p.y()) * corner / length * away;
            }
        }
        return Vec3::Zero();
    }

    /// Of a man's build: trapezius and broad back, straight waist, narrow and flat hips, strong arms, a broader jaw.
    [[nodiscard]] Vec3 masculine(const Place& place, double front) const {
        const Vec3& p = place.point;
        const double trunk = 1.0 - place.arm;
        Vec3 moved = Vec3::Zero();
        moved.y() += 0.008 * trunk * bell(p.y() - 1.44, 0.025) * hump(0.02, 0.085, 0.17, p.x());
        moved.x() += 0.07 * trunk * p.x() * hump(kWaist, kArmpit - 0.02, kNeckBase, p.y());
        moved.x() += 0.05 * trunk * p.x() * hump(kSeat + 0.02, kWaist, kBust - 0.02, p.y());
        moved.x() -= 0.05 * trunk * p.x() * hump(0.55, kSeat + 0.03, kWaist, p.y());
        moved.z() += 0.006 * trunk * (1.0 - front) * bell(p.y() - kSeat, 0.06) * bell(p.x() - 0.06, 0.07);
        moved += 0.05 * trunk * hump(kNeckBase - 0.05, kThroat, kChin + 0.06, p.y()) *
                 Vec3(p.x(), 0.0, p.z() - axisDepth(p.y()));
        moved.x() += 0.035 * trunk * p.x() * hump(kChin - 0.02, kChin + 0.035, kChin + 0.10, p.y());
        const Limb arm = limb(body_.armLoft(), p);
        moved += 0.07 * place.arm * (1.0 - 0.5 * smoothStep(0.05, 0.54, arm.along)) * arm.outward;
        return moved;
    }

    const BodyField& body_;
};

double shareOf(const SkinningWeights& weights, bool arms) {
    double share = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
        const auto joint = static_cast<Joint>(weights.joint[k]);
        const bool isArm = joint >= Joint::leftShoulder && joint <= Joint::rightHand;
        const bool isLeg = joint >= Joint::leftHip;
        if (arms ? isArm : isLeg) share += static_cast<double>(weights.weight[k]);
    }
    return share;
}

Place placeOf(const Eigen::Vector3f& point, const SkinningWeights& weights) {
    return {.point = point.cast<double>(), .arm = shareOf(weights, true), .leg = shareOf(weights, false)};
}

Eigen::MatrixXd displacements(const Fields& fields, const std::vector<Place>& places) {
    Eigen::MatrixXd raw(3 * static_cast<Eigen::Index>(places.size()), static_cast<Eigen::Index>(kCount));
    for (std::size_t i = 0; i < places.size(); ++i) {
        for (std::size_t k = 0; k < kCount; ++k) {
            raw.block<3, 1>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(k)) =
                fields.at(static_cast<ShapeParameter>(k), places[i]);
        }
    }
    return raw;
}

/// How the measured dimensions change with each raw field: central differences on the mannequin.
Eigen::MatrixXd measuredSlopes(const Body& body, const BodyMeasures& measures) {
    constexpr float kStep = 0.01F;
    Eigen::MatrixXd slopes(static_cast<Eigen::Index>(kMeasuredParameterCount), static_cast<Eigen::Index>(kCount));
    BodyShape shape;
    shape.fitted = 1.0F;
    ShapedBody shaped;
    for (std::size_t k = 0; k < kCount; ++k) {
        std::array<MeasuredParameters, 2> values;
        for (const int end : {0, 1}) {
            shape.parameters.setZero();
            shape.parameters[static_cast<Eigen::Index>(k)] = end == 0 ? -kStep : kStep;
            shapeBody(body, shape, shaped);
            values[static_cast<std::size_t>(end)] = measures.measure(shaped.positions, shaped.joints);
        }
        slopes.col(static_cast<Eigen::Index>(k)) = (values[1] - values[0]).cast<double>() / (2.0 * kStep);
    }
    return slopes;
}

}  // namespace

void makeBodyShapes(BodyModel& model) {
    Body& body = model.body;
    const Fields fields(model.field);
    std::vector<Place> mesh;
    for (std::size_t i = 0; i < body.mesh.positions.size(); ++i)
        mesh.push_back(placeOf(body.mesh.positions[i], body.mesh.weights[i]));
    std::vector<Place> cage;
    for (std::size_t i = 0; i < body.outerCage.size(); ++i)
        cage.push_back(placeOf(body.outerCage[i], body.cageWeights[i]));
    std::vector<Place> joints;
    for (std::size_t j = 0; j < kJointCount; ++j) {
        SkinningWeights whole;
        whole.joint[0] = static_cast<std::uint8_t>(j);
        joints.push_back(placeOf(body.joints[j], whole));
    }
    const Eigen::MatrixXd rawMesh = displacements(fields, mesh);
    const Eigen::MatrixXd rawCage = displacements(fields, cage);
    const Eigen::MatrixXd rawJoints = displacements(fields, joints);
    body.shapes.mesh = rawMesh.cast<float>();
    body.shapes.cage = rawCage.cast<float>();
    body.shapes.joints = rawJoints.cast<float>();

    // Each measured parameter takes the mixture of the first fields that changes it alone; the others (bust, masculine)
    // are their own field less what it changes of lengths and girths.
    const BodyMeasures measures(body);
    const Eigen::MatrixXd slopes = measuredSlopes(body, measures);
    constexpr auto kMeasured = static_cast<Eigen::Index>(kMeasuredParameterCount);
    constexpr auto kAll = static_cast<Eigen::Index>(kCount);
    const Eigen::MatrixXd inverse = slopes.leftCols(kMeasured).inverse();
    Eigen::MatrixXd mixture = Eigen::MatrixXd::Identity(kAll, kAll);
    mixture.topLeftCorner(kMeasured, kMeasured) = inverse;
    mixture.topRightCorner(kMeasured, kAll - kMeasured) = -inverse * slopes.rightCols(kAll - kMeasured);
    body.shapes.mesh = (rawMesh * mixture).cast<float>();
    body.shapes.cage = (rawCage * mixture).cast<float>();
    body.shapes.joints = (rawJoints * mixture).cast<float>();
}

}  // namespace cheval::fitting::bake

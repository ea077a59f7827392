#include "fitting/bake/body_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cheval::fitting::bake {
namespace {

constexpr double kStature = 1.750;
const Vec3 kShoulder(0.170, 1.386, -0.026);
const Vec3 kHip(0.091, 0.905, -0.008);
const Vec3 kAnkle(0.116, 0.086, -0.008);
const double kHalfRightAngle = std::sqrt(0.5);

/// The smooth minimum of two distances: blends over `width` metres.
double smoothUnion(double a, double b, double width) {
    const double h = std::max(width - std::abs(a - b), 0.0) / width;
    return std::min(a, b) - h * h * width * 0.25;
}

/// The signed distance to an ellipsoid, good near its surface.
double ellipsoid(const Vec3& point, const Vec3& centre, const Vec3& radii) {
    const Vec3 q = point - centre;
    const double k0 = q.cwiseQuotient(radii).norm();
    const double k1 = q.cwiseQuotient(radii.cwiseProduct(radii)).norm();
    return k1 > 0.0 ? k0 * (k0 - 1.0) / k1 : -radii.minCoeff();
}

/// The signed distance to a capsule whose radius goes from `r0` at `a` to `r1` at `b`.
double taperedCapsule(const Vec3& point, const Vec3& a, const Vec3& b, double r0, double r1) {
    const Vec3 ab = b - a;
    const double t = std::clamp((point - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
    return (point - a - t * ab).norm() - (r0 + t * (r1 - r0));
}

Loft::Shape trunkShape() {
    Loft::Shape shape{.origin = Vec3::Zero(),
                      .axis = Vec3::UnitY(),
                      .first = Vec3::UnitX(),
                      .second = Vec3::UnitZ(),
                      .exponent = 2.25,
                      .roundStart = 0.075};
    struct Level {
        double y, halfBreadth, front, back;
    };
    // Height, half the breadth, and where the front and the back are.
    constexpr Level kLevels[] = {
        {0.795, 0.128, 0.068, -0.086}, {0.850, 0.157, 0.088, -0.104},  {0.900, 0.167, 0.097, -0.110},
        {0.950, 0.162, 0.101, -0.102}, {1.000, 0.150, 0.100, -0.086},  {1.050, 0.139, 0.097, -0.074},
        {1.090, 0.135, 0.097, -0.070}, {1.130, 0.138, 0.101, -0.074},  {1.180, 0.146, 0.107, -0.086},
        {1.230, 0.154, 0.111, -0.098}, {1.280, 0.161, 0.110, -0.108},  {1.320, 0.165, 0.103, -0.113},
        {1.360, 0.167, 0.088, -0.113}, {1.390, 0.164, 0.071, -0.108},  {1.412, 0.153, 0.058, -0.101},
        {1.430, 0.134, 0.047, -0.094}, {1.447, 0.108, 0.040, -0.086},  {1.465, 0.084, 0.037, -0.078},
        {1.487, 0.067, 0.038, -0.070}, {1.512, 0.0590, 0.043, -0.062}, {1.545, 0.0560, 0.050, -0.054},
        {1.600, 0.0560, 0.056, -0.048}};
    for (const Level& level : kLevels) {
        const double depth = 0.5 * (level.front - level.back);
        shape.sections.push_back(
            {level.y, 0.0, 0.5 * (level.front + level.back), level.halfBreadth, level.halfBreadth, depth, depth});
    }
    return shape;
}

Loft::Shape armShape() {
    // 45° down; forearm and fingers come forward and the fingers bend a little towards the palm, as relaxed ones do.
    return {.origin = kShoulder,
            .axis = Vec3(kHalfRightAngle, -kHalfRightAngle, 0.0),
            .first = Vec3::UnitZ(),
            .second = Vec3(kHalfRightAngle, kHalfRightAngle, 0.0),
            .roundStart = 0.050,
            .roundEnd = 0.036,
            .sections = {{-0.055, 0.000, -0.004, 0.048, 0.050, 0.040, 0.048},
                         {0.000, 0.000, 0.000, 0.053, 0.055, 0.045, 0.050},
                         {0.050, 0.000, 0.000, 0.053, 0.054, 0.048, 0.048},
                         {0.110, 0.001, 0.000, 0.049, 0.048, 0.046, 0.045},
                         {0.180, 0.002, 0.000, 0.044, 0.043, 0.042, 0.042},
                         {0.240, 0.001, 0.000, 0.039, 0.040, 0.038, 0.038},
                         {kElbowAlong, 0.001, 0.000, 0.037, 0.038, 0.037, 0.036},
                         {0.335, 0.005, 0.000, 0.041, 0.038, 0.037, 0.036},
                         {0.390, 0.011, 0.000, 0.038, 0.036, 0.034, 0.033},
                         {0.460, 0.018, 0.000, 0.031, 0.031, 0.027, 0.027},
                         {0.510, 0.023, 0.000, 0.028, 0.028, 0.022, 0.022},
                         {kWristAlong, 0.026, 0.000, 0.028, 0.028, 0.020, 0.020},
                         {0.575, 0.030, 0.000, 0.036, 0.034, 0.019, 0.018},
                         {0.615, 0.034, 0.000, 0.041, 0.040, 0.017, 0.016},
                         {0.650, 0.037, -0.003, 0.040, 0.039, 0.0145, 0.0145},
                         {0.690, 0.040, -0.009, 0.037, 0.036, 0.0125, 0.0125},
                         {0.728, 0.043, -0.017, 0.033, 0.033, 0.0120, 0.0120}}};
}

Loft::Shape legShape() {
    const Vec3 axis = (kAnkle - kHip).normalized();
    const Vec3 forward = (Vec3::UnitZ() - axis * axis.z()).normalized();
    return {.origin = kHip,
            .axis = axis,
            .first = forward,
            .second = forward.cross(axis),
            .roundStart = 0.100,
            .sections = {{-0.080, 0.000, 0.000, 0.078, 0.080, 0.070, 0.064},
                         {-0.020, 0.002, 0.000, 0.080, 0.082, 0.074, 0.068},
                         {0.040, 0.004, 0.000, 0.083, 0.088, 0.078, 0.075},
                         {0.090, 0.006, 0.000, 0.084, 0.088, 0.077, 0.079},
                         {0.150, 0.008, 0.000, 0.082, 0.082, 0.073, 0.076},
                         {0.220, 0.009, 0.000, 0.078, 0.074, 0.068, 0.069},
                         {0.300, 0.008, 0.000, 0.069, 0.064, 0.060, 0.061},
                         {0.360, 0.005, 0.000, 0.059, 0.056, 0.053, 0.055},
                         {kKneeAlong, 0.002, 0.000, 0.054, 0.050, 0.050, 0.051},
                         {0.460, -0.003, 0.000, 0.047, 0.052, 0.048, 0.047},
                         {0.520, -0.009, 0.000, 0.043, 0.058, 0.051, 0.048},
                         {0.570, -0.012, 0.000, 0.040, 0.056, 0.049, 0.046},
                         {0.650, -0.015, 0.000, 0.036, 0.043, 0.040, 0.039},
                         {0.720, -0.018, 0.000, 0.032, 0.034, 0.033, 0.033},
                         {0.780, -0.020, 0.000, 0.032, 0.033, 0.031, 0.031},
                         {0.850, -0.018, 0.000, 0.036, 0.036, 0.033, 0.033}}};
}

Loft::Shape footShape() {
    const double toeOut = 0.14;  // Radians.
    const Vec3 axis(std::sin(toeOut), 0.0, std::cos(toeOut));
    const Vec3 outward(axis.z(), 0.0, -axis.x());
    return {.origin = Vec3(kAnkle.x(), 0.0, kAnkle.z() - 0.018),
            .axis = axis,
            .first = Vec3::UnitY(),
            .second = outward,
            .exponent = 2.3,
            .roundStart = 0.035,
            .roundEnd = 0.050,
            .sections = {{-0.058, 0.038, 0.000, 0.034, 0.044, 0.029, 0.029},
                         {-0.020, 0.042, 0.000, 0.046, 0.050, 0.033, 0.033},
                         {0.030, 0.040, 0.000, 0.050, 0.050, 0.034, 0.035},
                         {0.075, 0.032, 0.001, 0.040, 0.040, 0.037, 0.038},
                         {0.120, 0.024, 0.003, 0.028, 0.030, 0.042, 0.041},
                         {0.155, 0.018, 0.002, 0.020, 0.024, 0.043, 0.042},
                         {0.205, 0.013, -0.003, 0.016, 0.018, 0.038, 0.038}}};
}

}  // namespace

Loft::Loft(Shape shape) : shape_(std::move(shape)) {
    std::vector<double> xs;
    for (const Section& section : shape_.sections) {
        xs.push_back(section.along);
    }
    const auto spline = [&](double Section::*field) {
        std::vector<double> ys;
        for (const Section& section : shape_.sections) {
            ys.push_back(section.*field);
        }
        return Spline(xs, ys);
    };
    splines_ = {spline(&Section::centre1), spline(&Section::centre2), spline(&Section::plus1),
                spline(&Section::minus1),  spline(&Section::plus2),   spline(&Section::minus2)};
    start_ = xs.front();
    end_ = xs.back();
}

Vec3 Loft::centre(double along) const {
    return shape_.origin + along * shape_.axis + splines_[0](along) * shape_.first + splines_[1](along) * shape_.second;
}

double Loft::distance(const Vec3& point) const {
    const Vec3 q = point - shape_.origin;
    const double along = q.dot(shape_.axis);
    const double clamped = std::clamp(along, start_, end_);
    const double q1 = q.dot(shape_.first) - splines_[0](clamped);
    const double q2 = q.dot(shape_.second) - splines_[1](clamped);
    const double h1 = q1 >= 0.0 ? splines_[2](clamped) : splines_[3](clamped);
    const double h2 = q2 >= 0.0 ? splines_[4](clamped) : splines_[5](clamped);
    // A domed end is an ellipsoid's half: the sections stay, the distance along the axis joins in.
    double dome = 0.0;
    if (shape_.roundStart > 0.0 && along < start_ + shape_.roundStart) {
        dome = (start_ + shape_.roundStart - along) / shape_.roundStart;
    } else if (shape_.roundEnd > 0.0 && along > end_ - shape_.roundEnd) {
        dome = (along - end_ + shape_.roundEnd) / shape_.roundEnd;
    }
    const double n = shape_.exponent;
    const double section = std::pow(std::pow(std::abs(q1) / h1, n) + std::pow(std::abs(q2) / h2, n), 1.0 / n);
    const double f = std::sqrt(section * section + dome * dome);
    const double domeLength =
        dome > 0.0 ? dome * (along < 0.5 * (start_ + end_) ? shape_.roundStart : shape_.roundEnd) : 0.0;
    const double reach = std::sqrt(q1 * q1 + q2 * q2 + domeLength * domeLength);
    double distance = f > 1e-9 ? reach * (1.0 - 1.0 / f) : -std::min(h1, h2);
    // Flat ends: outside them the way along the axis counts.
    const double beyond =
        std::max(shape_.roundStart > 0.0 ? 0.0 : start_ - along, shape_.roundEnd > 0.0 ? 0.0 : along - end_);
    if (beyond > 0.0) {
        distance = distance > 0.0 ? std::hypot(distance, beyond) : beyond;
    }
    return distance;
}

BodyField::BodyField() : trunk_(trunkShape()), arm_(armShape()), leg_(legShape()), foot_(footShape()) {
    const auto set = [&](Joint joint, const Vec3& place) { joints_[index(joint)] = place; };
    const auto setBoth = [&](Joint left, Joint right, const Vec3& place) {
        set(left, place);
        set(right, Vec3(-place.x(), place.y(), place.z()));
    };
    const Vec3 neck(0.0, 1.478, -0.028);
    set(Joint::head, Vec3(0.0, 0.5 * (kStature + 1.528), 0.010));
    set(Joint::neck, neck);
    set(Joint::torso, Vec3(0.0, 0.5 * (neck.y() + kHip.y()), 0.5 * (neck.z() + kHip.z())));
    setBoth(Joint::leftShoulder, Joint::rightShoulder, kShoulder);
    setBoth(Joint::leftElbow, Joint::rightElbow, arm_.centre(kElbowAlong));
    setBoth(Joint::leftHand, Joint::rightHand, arm_.centre(0.615));
    setBoth(Joint::leftHip, Joint::rightHip, kHip);
    setBoth(Joint::leftKnee, Joint::rightKnee, leg_.centre(kKneeAlong));
    setBoth(Joint::leftFoot, Joint::rightFoot, leg_.centre(kAnkleAlong));
}

Vec3 BodyField::thumbRoot() const {
    return arm_.centre(0.562) + 0.020 * arm_.shape().first - 0.004 * arm_.shape().second;
}

Vec3 BodyField::thumbTip() const {
    return arm_.centre(0.640) + 0.066 * arm_.shape().first - 0.012 * arm_.shape().second;
}

double BodyField::trunk(const Vec3& point) const {
    double d = trunk_.distance(point);
    // Breast, shoulder blade and seat, each flowing into the trunk.
    d = smoothUnion(d, ellipsoid(point, {0.072, 1.280, 0.068}, {0.072, 0.062, 0.044}), 0.050);
    d = smoothUnion(d, ellipsoid(point, {0.080, 1.330, -0.080}, {0.060, 0.085, 0.034}), 0.045);
    d = smoothUnion(d, ellipsoid(point, {0.074, 0.880, -0.066}, {0.074, 0.082, 0.062}), 0.040);
    // The skull and the face, down to a soft chin.
    const double skull = ellipsoid(point, {0.0, 1.655, -0.006}, {0.0745, 0.095, 0.094});
    const double face = ellipsoid(point, {0.0, 1.601, 0.029}, {0.055, 0.080, 0.064});
    return smoothUnion(d, smoothUnion(skull, face, 0.060), 0.022);
}

double BodyField::arm(const Vec3& point) const {
    return arm_.distance(point);
}

double BodyField::leg(const Vec3& point) const {
    // The sole is flat on the floor.
    const double foot = -smoothUnion(-foot_.distance(point), point.y(), 0.012);
    return smoothUnion(leg_.distance(point), foot, 0.040);
}

double BodyField::whole(const Vec3& point) const {
    const double arms = smoothUnion(arm(point), taperedCapsule(point, thumbRoot(), thumbTip(), 0.0150, 0.0105), 0.018);
    const double legs = smoothUnion(leg(point), leg(Vec3(-point.x(), point.y(), point.z())), 0.012);
    return smoothUnion(smoothUnion(trunk(point), arms, 0.040), legs, 0.036);
}

double BodyField::mirrored(const Vec3& point) const {
    return whole(Vec3(std::abs(point.x()), point.y(), point.z()));
}

Vec3 gradient(const Field& field, const Vec3& point) {
    constexpr double kStep = 1e-4;
    Vec3 result;
    for (int i = 0; i < 3; ++i) {
        Vec3 ahead = point;
        Vec3 behind = point;
        ahead[i] += kStep;
        behind[i] -= kStep;
        result[i] = (field(ahead) - field(behind)) / (2.0 * kStep);
    }
    return result;
}

Vec3 project(const Field& field, Vec3 point, double level, bool onMidPlane) {
    constexpr int kMaximumSteps = 16;
    constexpr double kLongestStep = 0.012;
    for (int i = 0; i < kMaximumSteps; ++i) {
        const double error = field(point) - level;
        if (std::abs(error) < 1e-7) break;
        Vec3 slope = gradient(field, point);
        if (onMidPlane) slope.x() = 0.0;
        const double steepness = slope.squaredNorm();
        if (steepness < 1e-8) break;
        Vec3 step = -error / steepness * slope;
        if (step.norm() > kLongestStep) step *= kLongestStep / step.norm();
        point += step;
        if (onMidPlane) point.x() = 0.0;
    }
    return point;
}

Vec3 castOut(const Field& field, const Vec3& origin, const Vec3& direction, double reach) {
    constexpr double kStride = 0.004;
    double inside = 0.0;
    double outside = kStride;
    while (outside < reach && field(origin + outside * direction) < 0.0) {
        inside = outside;
        outside += kStride;
    }
    for (int i = 0; i < 24; ++i) {
        const double middle = 0.5 * (inside + outside);
        (field(origin + middle * direction) < 0.0 ? inside : outside) = middle;
    }
    return origin + 0.5 * (inside + outside) * direction;
}

}  // namespace cheval::fitting::bake

#include "fitting/body/shape_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "fitting/body/arm_reach.h"
#include "fitting/body/trunk_rings.h"

namespace cheval::fitting {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// The unknowns that stay: the parameters, then the clothes' thickness. Those of one frame alone: where the trunk is
// moved to and turned by.
constexpr int kParameters = static_cast<int>(kShapeParameterCount);
constexpr int kKept = kParameters + 1;
constexpr int kPose = 6;
constexpr int kAll = kKept + kPose;
using KeptMatrix = Eigen::Matrix<double, kKept, kKept>;
using ParameterMatrix = Eigen::Matrix<double, kParameters, kParameters>;
using ParameterVector = Eigen::Matrix<double, kParameters, 1>;
using KeptVector = Eigen::Matrix<double, kKept, 1>;
using PoseMatrix = Eigen::Matrix<double, kPose, kPose>;
using PoseVector = Eigen::Matrix<double, kPose, 1>;
using Row = Eigen::Matrix<double, kAll, 1>;

// Sides from which a trunk is seen: eighths of a turn.
constexpr std::size_t kSides = 8;
// The same place of the outline seen again from the same side says the same thing again, with the same clothes and the
// same faults of the model: the n-th time counts 1 / (1 + n / kFresh). What is old fades, so that what was taken for
// another place at first does not stay.
constexpr double kFresh = 2.0;
constexpr double kRemembered = 0.998;

// Standard deviations of one point: pixel, cloth and model for the outline; the sensor's noise besides for the surface.
constexpr double kOutlineDeviation = 0.010;
constexpr double kSurfaceDeviation = 0.020;
// Neighbours err together: so many points count as one.
constexpr double kOutlineTogether = 3.0;
constexpr double kSurfaceTogether = 20.0;
constexpr double kRobust = 3.0;
constexpr float kOutlineAstray = 0.060F;  // metres; farther away it is something else
constexpr float kSurfaceAstray = 0.070F;

// How far the tracked trunk may be from where it is: across, up, away (metres), and turned (radians).
constexpr double kAcrossDeviation = 0.02;
constexpr double kUpDeviation = 0.03;
constexpr double kUpStanding = 0.03;
constexpr double kAwayDeviation = 0.05;
constexpr double kTurnDeviation = 0.10;
constexpr float kSoles = 0.012F;  // metres under a shopper's feet

constexpr double kUsualClothes = 0.002;
constexpr double kClothesDeviation = 0.002;

constexpr float kSeen = 0.5F;
constexpr float kSlopes = 0.45F;       // Sine of a slope.
constexpr float kFacesSensor = 0.35F;  // Cosine; flatter surfaces are seen too badly.
// Pixels of every outline that a structured-light sensor does not see: its correlation window meets the background.
// Measured on exact outlines: 0.5 to 0.9 a side.
constexpr float kOutlineLost = 0.7F;
constexpr int kBridgedPixels = 3;
constexpr int kBorderPixels = 2;
constexpr float kSearchBeyond = 0.09F;  // metres past the expected outline
constexpr std::size_t kFewestOutline = 10;
constexpr float kFarthestDeviations = 4.5F;

}  // namespace

struct ShapeFit::State {
    const Body& body;
    TrunkRings rings;
    bool able = false;
    KeptMatrix priorInformation = KeptMatrix::Identity();
    KeptVector priorMean = KeptVector::Zero();
    ShapeParameters priorDeviation = ShapeParameters::Ones();

    struct Side {
        KeptMatrix information = KeptMatrix::Zero();
        KeptVector weighted = KeptVector::Zero();
        /// Equations so far of either end of each level's outline, and of each level's surface.
        std::array<double, 2 * TrunkRings::kLevels> outlines{};
        std::array<double, TrunkRings::kLevels> surfaces{};
    };
    std::array<Side, kSides> sides{};
    Estimate estimate;
    Misfit misfit;

    // The frame at hand.
    std::vector<Vector3f> rest = std::vector<Vector3f>(TrunkRings::kSamples, Vector3f::Zero());
    std::vector<Vector3f> placed = std::vector<Vector3f>(TrunkRings::kSamples, Vector3f::Zero());
    Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
    Vector3f move = Vector3f::Zero();
    Vector3f pivot = Vector3f::Zero();  ///< Rest pose: what the trunk turns about.
    Eigen::Matrix<double, kAll, kAll> normal = Eigen::Matrix<double, kAll, kAll>::Zero();
    Row right = Row::Zero();

    explicit State(const Body& theBody) : body(theBody), rings(theBody) {
        able = body.shapes.mesh.cols() == kParameters && body.shapes.covariance.rows() == kParameters;
        if (!able) return;
        priorInformation.setZero();
        const ParameterMatrix covariance = body.shapes.covariance.cast<double>();
        priorInformation.topLeftCorner<kParameters, kParameters>() = covariance.inverse();
        priorMean.head<kParameters>() = body.shapes.mean.cast<double>();
        priorDeviation = body.shapes.covariance.diagonal().cwiseSqrt();
    }

    void reset();
    bool takePose(const TrunkView& view);
    void placeSamples();
    [[nodiscard]] std::size_t sideSeen(const TrunkView& view) const;
    struct Sums {
        double outlineSquares = 0.0, surfaceSquares = 0.0, fresh = 0.0;
        int outlinePoints = 0, surfacePoints = 0;
    };
    Sums gather(const TrunkView& view, Side* side);
    void gatherOutline(const TrunkView& view, std::size_t level, Side* side, Sums& sums);
    void gatherSurface(const TrunkView& view, std::size_t level, Side* side, Sums& sums);
    void addRow(std::size_t sample, const Vector3f& direction, float residual, float clothes, double weight);
    [[nodiscard]] Vector3f toMirror(const Vector3f& point) const { return turn * (point - pivot) + move; }
};

namespace {

Vector3f middleOf(const Vector3f& a, const Vector3f& b) {
    return 0.5F * (a + b);
}

std::optional<Vector2f> pixelOf(const TrunkView& view, const Vector3f& point) {
    const Vector3f sensor = view.placement->toSensor(point);
    if (!sensor.allFinite() || sensor.z() < 100.0F) return std::nullopt;
    const Vector2f at = project(view.frame->intrinsics, sensor);
    const auto border = static_cast<float>(kBorderPixels);
    if (!(at.x() >= border && at.y() >= border && at.x() < static_cast<float>(view.map.width) - border - 1.0F &&
          at.y() < static_cast<float>(view.map.height) - border - 1.0F)) {
        return std::nullopt;
    }
    return at;
}

struct Pixel {
    int u = 0, v = 0;
};
Pixel nearest(const Vector2f& at) {
    return {.u = static_cast<int>(std::lround(at.x())), .v = static_cast<int>(std::lround(at.y()))};
}

// Where a pixel's reading lies; with none, at `millimetres`.
Vector3f pointAt(const TrunkView& view, Pixel pixel, float millimetres) {
    const std::uint16_t reading = view.frame->depth.at(pixel.u, pixel.v);
    const float z = reading != 0 ? static_cast<float>(reading) : millimetres;
    return view.placement->toMirror(
        unproject(view.frame->intrinsics, static_cast<float>(pixel.u), static_cast<float>(pixel.v), z));
}

double freshness(double& count) {
    count = kRemembered * count + 1.0;
    return 1.0 / (1.0 + count / kFresh);
}

// From inside the outline along the picture to where the shopper ends, half a pixel past the last one of theirs.
// Nothing where an arm is in the way, or where they end beyond `farthest`.
std::optional<Vector2f> outlineFrom(const TrunkView& view, const Vector2f& from, const Vector2f& to, float beyond) {
    const Vector2f way = to - from;
    const float steps = way.cwiseAbs().maxCoeff();
    if (!(steps >= 2.0F)) return std::nullopt;
    const Vector2f step = way / steps;
    const float millimetres = 0.0F;
    int last = -1;
    // What lies well within is the trunk's own.
    const int first = static_cast<int>(0.55F * steps);
    const int end = static_cast<int>(steps + beyond);
    for (int i = first; i <= end + kBridgedPixels; ++i) {
        const Vector2f at = from + static_cast<float>(i) * step;
        const Pixel pixel = nearest(at);
        if (pixel.u < kBorderPixels || pixel.v < kBorderPixels || pixel.u >= view.map.width - kBorderPixels ||
            pixel.v >= view.map.height - kBorderPixels) {
            return std::nullopt;
        }
        if (view.map.at(pixel.u, pixel.v) != view.label) {
            if (last < 0 || i - last > kBridgedPixels) break;
            continue;
        }
        if (i > end) return std::nullopt;
        if (view.frame->depth.at(pixel.u, pixel.v) != 0 && onArm(*view.skeleton, pointAt(view, pixel, millimetres))) {
            return std::nullopt;
        }
        last = i;
    }
    if (last < 0) return std::nullopt;
    return from + (static_cast<float>(last) + 0.5F + kOutlineLost) * step;
}

}  // namespace

void ShapeFit::State::reset() {
    sides = {};
    misfit = {};
    estimate = {};
    estimate.parameters = body.shapes.mean;
    if (able) estimate.uncertainty = priorDeviation;
    estimate.clothes = static_cast<float>(kUsualClothes);
    estimate.clothesUncertainty = static_cast<float>(kClothesDeviation);
}

bool ShapeFit::State::takePose(const TrunkView& view) {
    const Skeleton& skeleton = *view.skeleton;
    // In profile the far shoulder and hip are hidden; the tracker still knows how the trunk is turned.
    const JointState& torso = skeleton[Joint::torso];
    const JointState& neck = skeleton[Joint::neck];
    if (torso.confidence < kSeen || neck.confidence < kSeen || !torso.position.allFinite() ||
        !neck.position.allFinite() || !(std::abs(torso.orientation.norm() - 1.0F) < 0.01F)) {
        return false;
    }
    turn = torso.orientation.toRotationMatrix();
    if (!turn.allFinite()) return false;

    // Where the model's own joints would be.
    std::array<Vector3f, kJointCount> joints;
    for (std::size_t j = 0; j < kJointCount; ++j) {
        joints[j] =
            body.joints[j] + body.shapes.joints.middleRows<3>(static_cast<Eigen::Index>(3 * j)) * estimate.parameters;
    }
    const Vector3f modelHips = middleOf(joints[index(Joint::leftHip)], joints[index(Joint::rightHip)]);
    pivot = middleOf(modelHips, joints[index(Joint::neck)]);
    move = torso.position;  // Midway between hips and neck.
    if (view.stands) {
        // On straight legs the trunk is as high above the floor as the model's.
        move.y() = kSoles + modelHips.y() + (turn * (pivot - modelHips)).y();
    }
    return true;
}

void ShapeFit::State::placeSamples() {
    for (std::size_t i = 0; i < TrunkRings::kSamples; ++i)
        placed[i] = toMirror(rest[i]);
}

// One equation: the surface at the sample lies `residual` metres further along `direction` than the model's.
void ShapeFit::State::addRow(std::size_t sample, const Vector3f& direction, float residual, float clothes,
                             double weight) {
    Row row;
    const Vector3f inRest = turn.transpose() * direction;
    row.head<kParameters>() = (inRest.transpose() * rings.basis(sample)).transpose().cast<double>();
    row[kParameters] = static_cast<double>(clothes);
    row.segment<3>(kKept) = direction.cast<double>();
    row.segment<3>(kKept + 3) = (placed[sample] - move).cross(direction).cast<double>();
    normal.noalias() += weight * row * row.transpose();
    right += weight * (static_cast<double>(residual) - static_cast<double>(clothes * estimate.clothes)) * row;
}

void ShapeFit::State::gatherOutline(const TrunkView& view, std::size_t level, Side* side, Sums& sums) {
    const Vector3f& sensor = view.placement->translation;
    Vector3f middle = Vector3f::Zero();
    float count = 0.0F;
    for (std::size_t column = 0; column < TrunkRings::kColumns; ++column) {
        const std::size_t at = TrunkRings::sample(level, column);
        if (!rings.valid(at)) continue;
        middle += placed[at];
        count += 1.0F;
    }
    if (count < 12.0F) return;
    middle /= count;
    const Vector3f ahead = (middle - sensor).normalized();
    const Vector3f across = ahead.cross(turn.col(1)).normalized();
    const auto from = pixelOf(view, middle);
    if (!from) return;
    const auto slope = [&](const Vector3f& point) {
        const Vector3f way = point - sensor;
        return way.dot(across) / way.dot(ahead);
    };
    for (const float sign : {-1.0F, 1.0F}) {
        // The sample that reaches farthest to this side of the picture.
        std::size_t best = TrunkRings::kSamples;
        float reach = 0.0F;
        for (std::size_t column = 0; column < TrunkRings::kColumns; ++column) {
            const std::size_t at = TrunkRings::sample(level, column);
            if (!rings.valid(at)) continue;
            const float out = sign * slope(placed[at]);
            if (best != TrunkRings::kSamples && out <= reach) continue;
            best = at;
            reach = out;
        }
        // At the armpits the outline is the arm's.
        const std::size_t column = best % TrunkRings::kColumns;
        if (!rings.valid(TrunkRings::sample(level, column + 1)) ||
            !rings.valid(TrunkRings::sample(level, column + TrunkRings::kColumns - 1))) {
            continue;
        }
        // Where it slopes, as at the shoulders, the outline says little about breadth.
        if (std::abs(rings.normal(rest, best).y()) > kSlopes) continue;
        const auto to = pixelOf(view, placed[best]);
        if (!to) continue;
        const float distance = (placed[best] - sensor).dot(ahead);
        const float pixelsPerMetre = view.frame->intrinsics.fx / distance;
        const auto edge = outlineFrom(view, *from, *to, kSearchBeyond * pixelsPerMetre);
        if (!edge) continue;
        const Vector3f ray = view.placement->toMirror(unproject(view.frame->intrinsics, edge->x(), edge->y(), 1000.0F));
        const float residual = (slope(ray) - slope(placed[best])) * distance;
        const float outward = sign * residual;
        if (std::abs(outward) > kOutlineAstray) continue;
        const Vector3f direction = across - slope(placed[best]) * ahead;
        const double ratio = std::abs(static_cast<double>(residual)) / (kRobust * kOutlineDeviation);
        const double robust = ratio > 1.0 ? 1.0 / ratio : 1.0;
        const double fresh = side == nullptr ? 1.0 : freshness(side->outlines[2 * level + (sign > 0.0F ? 1 : 0)]);
        sums.fresh += fresh;
        addRow(best, direction, residual, sign,
               fresh * robust / (kOutlineDeviation * kOutlineDeviation * kOutlineTogether));
        sums.outlineSquares += static_cast<double>(residual) * static_cast<double>(residual);
        ++sums.outlinePoints;
    }
}

void ShapeFit::State::gatherSurface(const TrunkView& view, std::size_t level, Side* side, Sums& sums) {
    const Vector3f& sensor = view.placement->translation;
    const double fresh = side == nullptr ? 1.0 : freshness(side->surfaces[level]);
    for (std::size_t column = level % 2; column < TrunkRings::kColumns; column += 2) {
        const std::size_t at = TrunkRings::sample(level, column);
        if (!rings.valid(at)) continue;
        const Vector3f direction = turn * rings.normal(rest, at);
        const Vector3f way = (placed[at] - sensor).normalized();
        if (-direction.dot(way) < kFacesSensor) continue;
        const auto pixel = pixelOf(view, placed[at]);
        if (!pixel) continue;
        const Pixel seen = nearest(*pixel);
        if (view.map.at(seen.u, seen.v) != view.label || view.frame->depth.at(seen.u, seen.v) == 0) continue;
        const Vector3f point = pointAt(view, seen, 0.0F);
        const float residual = direction.dot(point - placed[at]);
        if (std::abs(residual) > kSurfaceAstray || onArm(*view.skeleton, point)) continue;
        const double ratio = std::abs(static_cast<double>(residual)) / (kRobust * kSurfaceDeviation);
        const double robust = ratio > 1.0 ? 1.0 / ratio : 1.0;
        addRow(at, direction, residual, 1.0F,
               fresh * robust / (kSurfaceDeviation * kSurfaceDeviation * kSurfaceTogether));
        sums.surfaceSquares += static_cast<double>(residual) * static_cast<double>(residual);
        ++sums.surfacePoints;
    }
}

// Which eighth of a turn the sensor sees; 0: the front.
std::size_t ShapeFit::State::sideSeen(const TrunkView& view) const {
    const Vector3f ahead = move - view.placement->translation;
    const Vector3f& front = turn.col(2);
    const float heading = std::atan2(ahead.x() * front.z() - ahead.z() * front.x(), -ahead.dot(front));
    return static_cast<std::size_t>(std::lround(heading * 4.0F / 3.14159265F)) & 7U;
}

ShapeFit::State::Sums ShapeFit::State::gather(const TrunkView& view, Side* side) {
    normal.setZero();
    right.setZero();
    placeSamples();
    Sums sums;
    for (std::size_t level = 0; level < TrunkRings::kLevels; ++level) {
        gatherOutline(view, level, side, sums);
        gatherSurface(view, level, side, sums);
    }
    return sums;
}

ShapeFit::ShapeFit(const Body& body) : state_(std::make_unique<State>(body)) {
    state_->reset();
}

ShapeFit::~ShapeFit() = default;

void ShapeFit::reset() {
    state_->reset();
}

bool ShapeFit::add(const TrunkView& view) {
    State& s = *state_;
    if (!s.able || !s.takePose(view)) return false;
    s.rings.place(s.estimate.parameters, s.rest);

    // How far the tracked pose may be off, in the trunk's own directions: none of them is better known to the sensor
    // than across and up.
    PoseMatrix prior = PoseMatrix::Zero();
    const Vector3f ahead = (s.move - view.placement->translation).cwiseProduct(Vector3f(1, 0, 1)).normalized();
    const Vector3f across = ahead.cross(Vector3f::UnitY());
    const auto information = [](double deviation) { return 1.0 / (deviation * deviation); };
    const double up = view.stands ? kUpStanding : kUpDeviation;
    const Eigen::Vector3d a = ahead.cast<double>();
    const Eigen::Vector3d c = across.cast<double>();
    prior.topLeftCorner<3, 3>() =
        information(kAwayDeviation) * a * a.transpose() + information(kAcrossDeviation) * c * c.transpose();
    prior(1, 1) += information(up);
    prior.bottomRightCorner<3, 3>().diagonal().setConstant(information(kTurnDeviation));

    // First the pose alone, then the equations.
    State::Side* side = nullptr;
    PoseVector moved = PoseVector::Zero();
    State::Sums sums;
    for (int round = 0; round < 2; ++round) {
        sums = s.gather(view, side);
        if (static_cast<std::size_t>(sums.outlinePoints) < kFewestOutline) return false;
        if (round == 1) break;
        PoseMatrix inner = s.normal.bottomRightCorner<kPose, kPose>();
        inner += prior;
        const PoseVector step = inner.ldlt().solve(s.right.tail<kPose>() - prior * moved);
        if (!step.allFinite() || step.head<3>().norm() > 0.3 || step.tail<3>().norm() > 0.6) return false;
        moved += step;
        s.move += step.head<3>().cast<float>();
        const Vector3f turned = step.tail<3>().cast<float>();
        side = &s.sides[s.sideSeen(view)];
        if (turned.norm() > 1e-6F) s.turn = Eigen::AngleAxisf(turned.norm(), turned.normalized()) * s.turn;
    }
    PoseMatrix inner = s.normal.bottomRightCorner<kPose, kPose>();
    prior *= sums.fresh / sums.outlinePoints;
    inner += prior;
    const PoseVector innerRight = s.right.tail<kPose>() - prior * moved;
    const Eigen::Matrix<double, kPose, kKept> coupling = s.normal.bottomLeftCorner<kPose, kKept>();
    const Eigen::LDLT<PoseMatrix> eliminated(inner);
    KeptMatrix kept = s.normal.topLeftCorner<kKept, kKept>();
    kept -= coupling.transpose() * eliminated.solve(coupling);
    KeptVector keptRight = s.right.head<kKept>() - coupling.transpose() * eliminated.solve(innerRight);
    KeptVector now;
    now.head<kParameters>() = s.estimate.parameters.cast<double>();
    now[kParameters] = static_cast<double>(s.estimate.clothes);
    keptRight += kept * now;
    if (!kept.allFinite() || !keptRight.allFinite()) return false;

    side->information = kRemembered * side->information + kept;
    side->weighted = kRemembered * side->weighted + keptRight;
    s.misfit.outlinePoints = sums.outlinePoints;
    s.misfit.surfacePoints = sums.surfacePoints;
    s.misfit.outline = static_cast<float>(std::sqrt(sums.outlineSquares / std::max(sums.outlinePoints, 1)));
    s.misfit.surface = static_cast<float>(std::sqrt(sums.surfaceSquares / std::max(sums.surfacePoints, 1)));
    return true;
}

void ShapeFit::solve(std::span<const ParameterReading> readings) {
    State& s = *state_;
    if (!s.able) return;
    KeptMatrix information = s.priorInformation;
    KeptVector weighted = s.priorInformation * s.priorMean;
    for (const State::Side& side : s.sides) {
        information += side.information;
        weighted += side.weighted;
    }
    for (const ParameterReading& reading : readings) {
        const auto i = static_cast<Eigen::Index>(index(reading.parameter));
        if (!std::isfinite(reading.value) || !(reading.uncertainty > 0.0F)) continue;
        const double weight =
            1.0 / (static_cast<double>(reading.uncertainty) * static_cast<double>(reading.uncertainty));
        information(i, i) += weight;
        weighted[i] += weight * static_cast<double>(reading.value);
    }
    // A thicker body and thicker clothes look alike, and where the model's sections differ from a shopper's, clothes
    // would make up for it. So their thickness is taken as given, and what is not known of it goes into the uncertainty
    // (Schmidt's consider parameter).
    const Eigen::LDLT<ParameterMatrix> solver(information.topLeftCorner<kParameters, kParameters>());
    const ParameterVector coupling = information.topRightCorner<kParameters, 1>();
    const ParameterVector solution =
        solver.solve(weighted.head<kParameters>() - coupling * static_cast<double>(s.estimate.clothes));
    const ParameterVector slope = solver.solve(coupling);
    const double unsure = static_cast<double>(s.estimate.clothesUncertainty);
    const ParameterMatrix covariance =
        solver.solve(ParameterMatrix::Identity()) + unsure * unsure * slope * slope.transpose();
    if (!solution.allFinite() || !covariance.allFinite()) return;
    const ShapeParameters wanted = solution.cast<float>();
    const ShapeParameters reach = kFarthestDeviations * s.priorDeviation;
    s.estimate.parameters = wanted.cwiseMax(s.body.shapes.mean - reach).cwiseMin(s.body.shapes.mean + reach);
    s.estimate.uncertainty = covariance.diagonal().cwiseMax(0.0).cwiseSqrt().cast<float>();
}

const ShapeFit::Estimate& ShapeFit::estimate() const {
    return state_->estimate;
}

const ShapeFit::Misfit& ShapeFit::misfit() const {
    return state_->misfit;
}

}  // namespace cheval::fitting

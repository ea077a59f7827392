#include "fitting/body/body_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "fitting/body/body_measures.h"
#include "fitting/body/sample_window.h"
#include "fitting/body/shape_fit.h"
#include "fitting/body/silhouette.h"

namespace cheval::fitting {

namespace {

// What is measured of a body and of the mannequin alike (D12, table 8.2), and then some that are only reported.
enum Proportion : std::size_t {
    kStature,
    kHipHeight,
    kTorsoHeight,
    kElbowToPalm,  // To the palm and not to the fingertips: fingers curl.
    kCrownAboveHead,
    kShoulderBreadth,
    kChestBreadth,
    kHipBreadth,
    kHeadBreadth,
    kProportionCount,
};
using Proportions = std::array<std::optional<float>, kProportionCount>;

// How much each counts (equations 8.6 and 8.7: every proportion's estimate of the scale is averaged). The ratios of
// table 8.2 are the mannequin's own, since that is what the garments were made on. Table 8.3's primary proportions of
// tops and trousers weigh most; the head least, since hair is not head.
struct Weighting {
    Proportion proportion;
    float weight;
};
constexpr std::array kHeightWeights = {Weighting{kStature, 3.0F}, Weighting{kHipHeight, 2.0F},
                                       Weighting{kTorsoHeight, 3.0F}, Weighting{kElbowToPalm, 1.0F},
                                       Weighting{kCrownAboveHead, 0.3F}};
constexpr std::array kBreadthWeights = {Weighting{kShoulderBreadth, 3.0F}, Weighting{kChestBreadth, 2.0F},
                                        Weighting{kHipBreadth, 2.0F}, Weighting{kHeadBreadth, 0.3F}};

// Heights along the trunk, from the neck's base (0) to the middle of the hips (1).
constexpr float kChestLevel = 0.42F;  // Just below the armpits, where arms held away leave the outline free.
constexpr float kHipLevel = 1.0F;

constexpr float kSeen = 0.5F;
constexpr float kFacing = 0.45F;           // Sine of how far the shoulders may be turned from the glass.
constexpr float kLeaning = 0.26F;          // Sine of how far the trunk may lean.
constexpr std::size_t kFirstSamples = 5;   // Enough for a first shape.
constexpr int kDwellFrames = 15;           // Between two shapes: garments are not fitted again for a passing twitch.
constexpr float kWorthFitting = 0.01F;     // One per cent.
constexpr float kWorthRefitting = 0.004F;  // Metres of a parameter of the fitted body …
constexpr float kLongestStep = 0.008F;     // … and the farthest that it moves at a time.
// From the palm's centre back to the wrist, as part of elbow to palm (half a palm of 0.06 statures over a forearm of
// 0.146: Drillis and Contini 1966).
constexpr float kPalmToWrist = 0.17F;
// Half a pixel of outline at each end.
constexpr float kOutlinePixels = 0.7F;

// Standard uncertainties in metres that stay however long one looks: hair and soles, where a joint is taken to be, and
// how far trousers hang below the crotch.
constexpr float kHairAndShoes = 0.006F;
constexpr float kJointPlace = 0.006F;
constexpr float kTrouserRise = 0.018F;

// What hair and soles add to a stature, and how far below the crotch the gap between the legs ends, at most shoppers.
constexpr float kHairAndShoesHeight = 0.0F;
constexpr float kCrotchBelow = -0.035F;
// What the covariance does not know of, in the order of Dimension, metres: sections, postures and joints that are not
// the model's. By simulated people whom the model does not describe.
constexpr std::array<float, kDimensionCount> kModelFault = {0.018F, 0.045F, 0.025F, 0.035F,
                                                            0.010F, 0.014F, 0.014F, 0.022F};
constexpr float kStraight = 0.96F;        // Of a leg's length, from hip to ankle.
constexpr float kBetweenJoints = 0.004F;  // Metres: lengths between joints are the tracker's to tell, not the trunk's.
constexpr int kSolveEvery = 5;            // Frames.
constexpr float kChildStature = 1.45F;
constexpr float kSeatedKnee = 0.75F;   // Of the hips' height above the ankles: knees of who stands are lower.
constexpr float kElbowRoom = 0.15F;    // Metres between two people's boxes.
constexpr float kAnkleHeight = 0.10F;  // Metres, in shoes …
constexpr float kFloorAstray = 0.12F;  // … and farther off than this, it is the floor that is elsewhere.
// Waist by chest from which it may be cloth that falls from the chest and hides the waist; hardly a body is that
// straight.
constexpr float kStraightDown = 0.915F;
// How far girths under such clothes may be off, and what lies low or high when it was out of the picture; as
// kModelFault.
constexpr std::array<float, kDimensionCount> kHiddenFault = {0.035F, 0.070F, 0.170F, 0.090F,
                                                             0.040F, 0.015F, 0.015F, 0.030F};
constexpr float kUnseenFault = 0.050F;
constexpr float kShareStep = 0.125F;  // The fitted body takes over in so many steps …
constexpr int kShareFrames = 3;       // … this many frames apart.

constexpr float kSmallestScale = 0.6F;
constexpr float kLargestScale = 1.5F;
constexpr float kNarrowest = 0.75F;  // Breadth scale over height scale.
constexpr float kBroadest = 1.4F;

using Joints = std::array<Eigen::Vector3f, kJointCount>;

Eigen::Vector3f alongTrunk(const Joints& joints, float level) {
    const Eigen::Vector3f hips = 0.5F * (joints[index(Joint::leftHip)] + joints[index(Joint::rightHip)]);
    const Eigen::Vector3f& neck = joints[index(Joint::neck)];
    return neck + level * (hips - neck);
}

float distance(const Joints& joints, Joint a, Joint b) {
    return (joints[index(a)] - joints[index(b)]).norm();
}

bool isTrunkOrLeg(const SkinningWeights& weights) {
    float arm = 0.0F;
    for (std::size_t k = 0; k < 4; ++k) {
        const auto joint = static_cast<Joint>(weights.joint[k]);
        if (joint >= Joint::leftShoulder && joint <= Joint::rightHand) arm += weights.weight[k];
    }
    return arm < 0.5F;
}

// Breadth of the mannequin, without its arms, at a height: where its edges cross that height.
std::optional<float> breadthOfMesh(const Body& body, float height) {
    float lowest = 0.0F;
    float highest = 0.0F;
    bool crossed = false;
    const auto cross = [&](std::uint32_t a, std::uint32_t b) {
        const Eigen::Vector3f& p = body.mesh.positions[a];
        const Eigen::Vector3f& q = body.mesh.positions[b];
        if ((p.y() <= height) == (q.y() <= height)) return;
        const float x = p.x() + (q.x() - p.x()) * (height - p.y()) / (q.y() - p.y());
        lowest = crossed ? std::min(lowest, x) : x;
        highest = crossed ? std::max(highest, x) : x;
        crossed = true;
    };
    for (const Triangle& t : body.mesh.triangles) {
        if (!isTrunkOrLeg(body.mesh.weights[t.a]) || !isTrunkOrLeg(body.mesh.weights[t.b]) ||
            !isTrunkOrLeg(body.mesh.weights[t.c])) {
            continue;
        }
        cross(t.a, t.b);
        cross(t.b, t.c);
        cross(t.c, t.a);
    }
    return crossed && highest > lowest ? std::optional(highest - lowest) : std::nullopt;
}

// What needs joints alone is measured alike on shopper and mannequin.
void addJointProportions(const Joints& joints, Proportions& proportions) {
    proportions[kTorsoHeight] = (alongTrunk(joints, 0.0F) - alongTrunk(joints, 1.0F)).norm();
    proportions[kShoulderBreadth] = distance(joints, Joint::leftShoulder, Joint::rightShoulder);
    proportions[kHipHeight] = alongTrunk(joints, 1.0F).y();
}

Proportions measureMannequin(const Body& body) {
    Proportions proportions;
    addJointProportions(body.joints, proportions);
    proportions[kElbowToPalm] = 0.5F * (distance(body.joints, Joint::leftElbow, Joint::leftHand) +
                                        distance(body.joints, Joint::rightElbow, Joint::rightHand));
    float crown = 0.0F;
    for (const Eigen::Vector3f& position : body.mesh.positions)
        crown = std::max(crown, position.y());
    const Eigen::Vector3f& head = body.joints[index(Joint::head)];
    proportions[kStature] = crown;
    proportions[kCrownAboveHead] = crown - head.y();
    proportions[kChestBreadth] = breadthOfMesh(body, alongTrunk(body.joints, kChestLevel).y());
    proportions[kHipBreadth] = breadthOfMesh(body, alongTrunk(body.joints, kHipLevel).y());
    proportions[kHeadBreadth] = breadthOfMesh(body, head.y());
    return proportions;
}

}  // namespace

struct BodyEstimator::State {
    const Body& body;
    BodyEstimatorOptions options;
    ShapeFit fit;
    std::optional<BodyMeasures> measures;  ///< Of a body that has shapes.
    MeasuredParameters mannequinMeasures = MeasuredParameters::Zero();
    ShapedBody fitted;  ///< The fitted body, to be measured.
    int fitFrames = 0;  ///< Frames that told something about the trunk.
    int sinceSolve = 0;
    float share = 0.0F;  ///< Of the fitted body in the shape.
    Proportions mannequin;
    std::array<SampleWindow, kProportionCount> windows;
    SampleWindow armLength;
    SampleWindow insideLeg;
    SampleWindow ankleHeight;  ///< Of who stands on straight legs: where the floor is, as far as the sensor knows.
    Measurements measurements;
    BodyShape shape;
    std::uint32_t user = 0;
    int frames = 0;
    int sinceShape = 0;
    float pixelMetres = 0.0F;  // What one pixel spans at the shopper.

    State(const Body& theBody, const BodyEstimatorOptions& theOptions)
        : body(theBody), options(theOptions), fit(theBody), mannequin(measureMannequin(theBody)) {
        if (theBody.shapes.mesh.cols() == 0) return;
        measures.emplace(theBody);
        mannequinMeasures = measures->measure(theBody.mesh.positions, theBody.joints);
        shapeBody(theBody, {.fitted = 1.0F}, fitted);
    }

    void forget() {
        fit.reset();
        fitFrames = 0;
        sinceSolve = 0;
        share = 0.0F;
        for (SampleWindow& window : windows)
            window.clear();
        armLength.clear();
        insideLeg.clear();
        ankleHeight.clear();
        measurements = {};
        frames = 0;
        sinceShape = 0;
        if (shape.measured) {
            shape.scale.setOnes();
            shape.parameters.setZero();
            shape.fitted = 0.0F;
            shape.measured = false;
            shape.converged = false;
            ++shape.revision;
        }
    }

    bool addEvidence(const hal::DepthFrame& frame, const Users& users, const User& active, const Skeleton& skeleton,
                     const SensorPlacement& placement);
    void addArms(const Skeleton& skeleton, Proportions& seen);
    bool addTrunk(const hal::DepthFrame& frame, const Users& users, const User& active, const Skeleton& skeleton,
                  const SensorPlacement& placement);
    void solve();
    /// Whether clothes may hide the trunk, as far as the fitted body tells.
    [[nodiscard]] bool hidden() const {
        const Measurement& chest = measurements[Dimension::chestGirth];
        const Measurement& waist = measurements[Dimension::waistGirth];
        return chest.valid && waist.valid && waist.value > kStraightDown * chest.value;
    }
    void doubt(const Users& users, const User& active, const Skeleton& skeleton);
    void report();
    void reshape();
    template <std::size_t N>
    [[nodiscard]] std::optional<float> scaleOf(const std::array<Weighting, N>& weights) const;
};

namespace {

bool all(const Skeleton& skeleton, std::initializer_list<Joint> joints) {
    return std::all_of(joints.begin(), joints.end(), [&](Joint joint) {
        return skeleton[joint].confidence >= kSeen && skeleton[joint].position.allFinite();
    });
}

bool upright(const Skeleton& skeleton) {
    if (!all(skeleton, {Joint::neck, Joint::torso})) return false;
    const Eigen::Vector3f up = skeleton[Joint::neck].position - skeleton[Joint::torso].position;
    return up.norm() > 0.1F && std::hypot(up.x(), up.z()) < kLeaning * up.norm();
}

bool onStraightLegs(const Skeleton& skeleton) {
    for (const auto& [hip, knee, foot] : {std::array{Joint::leftHip, Joint::leftKnee, Joint::leftFoot},
                                          std::array{Joint::rightHip, Joint::rightKnee, Joint::rightFoot}}) {
        if (!all(skeleton, {hip, knee, foot})) continue;
        const float leg = (skeleton[hip].position - skeleton[knee].position).norm() +
                          (skeleton[knee].position - skeleton[foot].position).norm();
        if (skeleton[hip].position.y() - skeleton[foot].position.y() > kStraight * leg) return true;
    }
    return false;
}

// Whether a shopper stands upright and faces the glass (or turns the back to it), as far as joints tell.
bool measurable(const Skeleton& skeleton) {
    if (!all(skeleton, {Joint::leftShoulder, Joint::rightShoulder, Joint::neck})) return false;
    const Eigen::Vector3f across = skeleton[Joint::leftShoulder].position - skeleton[Joint::rightShoulder].position;
    if (!(across.norm() > 0.15F) || std::abs(across.z()) > kFacing * across.norm()) return false;
    if (!all(skeleton, {Joint::leftHip, Joint::rightHip})) return true;
    const Eigen::Vector3f hips = 0.5F * (skeleton[Joint::leftHip].position + skeleton[Joint::rightHip].position);
    const Eigen::Vector3f up = skeleton[Joint::neck].position - hips;
    return up.norm() > 0.2F && std::abs(up.x()) < kLeaning * up.norm() && std::abs(up.z()) < kLeaning * up.norm();
}

}  // namespace

void BodyEstimator::State::addArms(const Skeleton& skeleton, Proportions& seen) {
    float forearms = 0.0F;
    float arms = 0.0F;
    int count = 0;
    for (const auto& [shoulder, elbow, hand] :
         {std::array{Joint::leftShoulder, Joint::leftElbow, Joint::leftHand},
          std::array{Joint::rightShoulder, Joint::rightElbow, Joint::rightHand}}) {
        if (!all(skeleton, {shoulder, elbow, hand})) continue;
        const float forearm = (skeleton[hand].position - skeleton[elbow].position).norm();
        forearms += forearm;
        arms += (skeleton[elbow].position - skeleton[shoulder].position).norm() + (1.0F - kPalmToWrist) * forearm;
        ++count;
    }
    if (count == 0) return;
    seen[kElbowToPalm] = forearms / static_cast<float>(count);
    armLength.add(arms / static_cast<float>(count));
}

// Also from the side and from behind, as long as the shopper is upright.
bool BodyEstimator::State::addTrunk(const hal::DepthFrame& frame, const Users& users, const User& active,
                                    const Skeleton& skeleton, const SensorPlacement& placement) {
    if (!upright(skeleton)) return false;
    const Silhouette silhouette(frame, users.map, active.label, skeleton, placement);
    const bool straight = onStraightLegs(skeleton);
    for (const Joint foot : {Joint::leftFoot, Joint::rightFoot}) {
        if (straight && all(skeleton, {foot})) ankleHeight.add(skeleton[foot].position.y());
    }
    const bool stands = straight && silhouette.standsInPicture();
    return fit.add({.frame = &frame,
                    .map = users.map,
                    .label = active.label,
                    .skeleton = &skeleton,
                    .placement = &placement,
                    .stands = stands});
}

// What is told apart from the trunk's surface: lengths between joints and heights above the floor.
void BodyEstimator::State::solve() {
    std::array<ParameterReading, 4> readings{};
    std::size_t count = 0;
    const float outline = kOutlinePixels * pixelMetres;
    const auto read = [&](ShapeParameter parameter, const SampleWindow& window, float systematic, float bias) {
        const SampleWindow::Average average = window.average();
        if (average.count < kFirstSamples) return;
        readings[count++] = {
            .parameter = parameter,
            .value = average.value - bias - mannequinMeasures[static_cast<Eigen::Index>(index(parameter))],
            .uncertainty = std::hypot(average.standardError, systematic)};
    };
    read(ShapeParameter::stature, windows[kStature], outline, kHairAndShoesHeight);
    read(ShapeParameter::shoulderBreadth, windows[kShoulderBreadth], kBetweenJoints, 0.0F);
    read(ShapeParameter::armLength, armLength, kBetweenJoints, 0.0F);
    read(ShapeParameter::insideLeg, insideLeg, outline + kTrouserRise, kCrotchBelow);
    fit.solve(std::span(readings.data(), count));
}

bool BodyEstimator::State::addEvidence(const hal::DepthFrame& frame, const Users& users, const User& active,
                                       const Skeleton& skeleton, const SensorPlacement& placement) {
    if (!measurable(skeleton)) return false;
    const Silhouette silhouette(frame, users.map, active.label, skeleton, placement);
    Joints joints{};
    for (std::size_t i = 0; i < kJointCount; ++i)
        joints[i] = skeleton.joints[i].position;
    const bool hips = all(skeleton, {Joint::leftHip, Joint::rightHip});
    const bool stands = silhouette.standsInPicture();
    pixelMetres = placement.toSensor(joints[index(Joint::neck)]).z() * 1e-3F / frame.intrinsics.fx;

    Proportions seen;
    addJointProportions(joints, seen);
    if (!hips) seen[kTorsoHeight].reset();
    if (!hips || !stands) seen[kHipHeight].reset();
    addArms(skeleton, seen);
    if (const auto crown = silhouette.crownHeight()) {
        if (stands) seen[kStature] = *crown;
        seen[kCrownAboveHead] = *crown - skeleton[Joint::head].position.y();
        seen[kHeadBreadth] = silhouette.breadthAt(skeleton[Joint::head].position);
    }
    if (hips) {
        seen[kChestBreadth] = silhouette.breadthAt(alongTrunk(joints, kChestLevel));
        seen[kHipBreadth] = silhouette.breadthAt(alongTrunk(joints, kHipLevel));
        const auto crotch = stands ? silhouette.crotchHeight() : std::nullopt;
        if (crotch && *crotch > 0.0F) insideLeg.add(*crotch);
    }
    for (std::size_t i = 0; i < kProportionCount; ++i) {
        // A length of less than half or more than twice the mannequin's is a mistake, not a shopper.
        const bool plausible =
            seen[i] && mannequin[i] && *seen[i] > 0.5F * *mannequin[i] && *seen[i] < 2.0F * *mannequin[i];
        if (plausible) windows[i].add(*seen[i]);
    }
    return true;
}

void BodyEstimator::State::report() {
    measurements.frames = std::min(frames, options.averagedFrames);
    measurements.converged = frames >= options.averagedFrames;
    if (measures && fitFrames >= static_cast<int>(kFirstSamples)) {
        measurements.converged = measurements.converged && fitFrames >= options.averagedFrames;
        shapeBody(body, {.parameters = fit.estimate().parameters, .fitted = 1.0F}, fitted);
        const MeasuredParameters values = measures->measure(fitted.positions, fitted.joints);
        for (std::size_t i = 0; i < kDimensionCount; ++i) {
            const auto k = static_cast<Eigen::Index>(i);
            measurements.dimensions[i] = {.value = values[k],
                                          .uncertainty = std::hypot(fit.estimate().uncertainty[k], kModelFault[i]),
                                          .valid = true};
        }
        const bool unseen = windows[kStature].count() < kFirstSamples;
        for (std::size_t i = 0; i < kDimensionCount; ++i) {
            float& uncertainty = measurements.dimensions[i].uncertainty;
            if (hidden()) uncertainty = std::hypot(uncertainty, kHiddenFault[i]);
            const auto dimension = static_cast<Dimension>(i);
            if (unseen && (dimension == Dimension::stature || dimension == Dimension::insideLeg)) {
                uncertainty = std::hypot(uncertainty, kUnseenFault);
            }
        }
        return;
    }
    const auto put = [this](Dimension dimension, const SampleWindow& window, float systematic) {
        const SampleWindow::Average average = window.average();
        measurements[dimension] = {.value = average.value,
                                   .uncertainty = std::hypot(average.standardError, systematic),
                                   .valid = average.count >= kFirstSamples};
    };
    // What no average takes away: the outline's pixel, and what each length is not told apart from.
    const float outline = kOutlinePixels * pixelMetres;
    put(Dimension::stature, windows[kStature], outline + kHairAndShoes);
    put(Dimension::shoulderBreadth, windows[kShoulderBreadth], outline + kJointPlace);
    put(Dimension::armLength, armLength, outline + kJointPlace);
    put(Dimension::insideLeg, insideLeg, outline + kTrouserRise);
}

// Why no size should be told, the plainest reason first.
void BodyEstimator::State::doubt(const Users& users, const User& active, const Skeleton& skeleton) {
    MeasurementDoubt& result = measurements.doubt;
    result = MeasurementDoubt::none;
    const auto hipsHeight = [&skeleton](Joint hip, Joint knee, Joint foot) {
        const float ankle = skeleton[foot].position.y();
        return all(skeleton, {hip, knee, foot}) &&
               skeleton[knee].position.y() - ankle > kSeatedKnee * (skeleton[hip].position.y() - ankle);
    };
    if (hipsHeight(Joint::leftHip, Joint::leftKnee, Joint::leftFoot) ||
        hipsHeight(Joint::rightHip, Joint::rightKnee, Joint::rightFoot)) {
        result = MeasurementDoubt::seated;
        return;
    }
    for (std::size_t i = 0; i < users.count; ++i) {
        const User& other = users.users[i];
        if (other.id == active.id) continue;
        const bool apart = ((other.lower - active.upper).array() > kElbowRoom).any() ||
                           ((active.lower - other.upper).array() > kElbowRoom).any();
        if (!apart) {
            result = MeasurementDoubt::crowded;
            return;
        }
    }
    const SampleWindow::Average ankles = ankleHeight.average();
    if (ankles.count >= kFirstSamples && std::abs(ankles.value - kAnkleHeight) > kFloorAstray) {
        result = MeasurementDoubt::tiltUnknown;
        return;
    }
    if (windows[kStature].count() < kFirstSamples && frames >= options.averagedFrames) {
        result = MeasurementDoubt::partlySeen;
        return;
    }
    if (!measurements.converged) {
        result = MeasurementDoubt::measuring;
        return;
    }
    if (measurements[Dimension::stature].value < kChildStature) {
        result = MeasurementDoubt::child;
        return;
    }
    if (hidden()) result = MeasurementDoubt::looseClothes;
}

template <std::size_t N>
std::optional<float> BodyEstimator::State::scaleOf(const std::array<Weighting, N>& weights) const {
    float sum = 0.0F;
    float total = 0.0F;
    for (const auto& [proportion, weight] : weights) {
        const SampleWindow::Average average = windows[proportion].average();
        if (average.count < kFirstSamples || !mannequin[proportion]) continue;
        sum += weight * average.value / *mannequin[proportion];
        total += weight;
    }
    return total > 0.0F ? std::optional(sum / total) : std::nullopt;
}

void BodyEstimator::State::reshape() {
    ++sinceShape;
    const auto height = scaleOf(kHeightWeights);
    const auto breadth = scaleOf(kBreadthWeights);
    if (!height && !breadth) return;
    // One stands in for the other only when it is not to be had.
    if ((!height || !breadth) && !measurements.converged) return;
    const float y = std::clamp(height ? *height : *breadth, kSmallestScale, kLargestScale);
    const float x = std::clamp(std::clamp(breadth ? *breadth : *height, kNarrowest * y, kBroadest * y), kSmallestScale,
                               kLargestScale);
    const Eigen::Vector3f scale(x, y, 0.5F * (x + y));
    const bool first = !shape.measured;
    const bool converges = measurements.converged && !shape.converged;
    // The fitted body takes over step by step once it is known, so that no garment jumps.
    const bool takesOver = measures && measurements.converged && sinceShape >= kShareFrames && shape.measured &&
                           shape.converged && share < 1.0F;
    if (takesOver) share = std::min(1.0F, share + kShareStep);
    if (shape.fitted > 0.0F || takesOver) {
        const ShapeParameters& wanted = fit.estimate().parameters;
        const bool grown = ((wanted - shape.parameters).array().abs() > kWorthRefitting).any();
        if (!takesOver && !(grown && sinceShape >= kDwellFrames)) return;
        shape.fitted = share;
        if (takesOver && shape.parameters.isZero()) {
            shape.parameters = wanted;
        } else {
            shape.parameters += (wanted - shape.parameters).cwiseMax(-kLongestStep).cwiseMin(kLongestStep);
        }
        ++shape.revision;
        sinceShape = 0;
        return;
    }
    const bool differs = ((scale - shape.scale).array().abs() > kWorthFitting * shape.scale.array()).any();
    if (!first && !converges && !(differs && sinceShape >= kDwellFrames)) return;
    shape.scale = scale;
    shape.measured = true;
    shape.converged = measurements.converged;
    ++shape.revision;
    sinceShape = 0;
}

BodyEstimator::BodyEstimator(const Body& body, const BodyEstimatorOptions& options)
    : state_(std::make_unique<State>(body, options)) {}

BodyEstimator::~BodyEstimator() = default;

void BodyEstimator::update(const hal::DepthFrame& frame, const Users& users, const Skeleton& skeleton,
                           const SensorPlacement& placement) {
    State& s = *state_;
    if (frame.restart) s.forget();
    const User* const active = users.active();
    if (active == nullptr) return;  // Gone for a moment, or for good: the next shopper tells.
    if (active->id != s.user) {
        s.forget();
        s.user = active->id;
    }
    const bool usable = skeleton.present() && skeleton.userId == active->id && !users.map.empty() &&
                        users.map.width == frame.depth.width && users.map.height == frame.depth.height &&
                        !frame.depth.empty();
    if (!usable) return;
    const bool trunk = s.measures && s.addTrunk(frame, users, *active, skeleton, placement);
    const bool lengths = s.addEvidence(frame, users, *active, skeleton, placement);
    if (trunk) ++s.fitFrames;
    if (lengths) s.frames = std::min(s.frames + 1, std::max(s.options.averagedFrames, 1));
    if (!trunk && !lengths) {
        s.doubt(users, *active, skeleton);
        return;
    }
    if (s.measures && ++s.sinceSolve >= kSolveEvery) {
        s.solve();
        s.sinceSolve = 0;
    }
    if (s.sinceSolve == 0) s.report();
    s.doubt(users, *active, skeleton);
    if (lengths || s.share > 0.0F) s.reshape();
}

void BodyEstimator::reset() {
    state_->forget();
    state_->user = 0;
}

const Measurements& BodyEstimator::measurements() const {
    return state_->measurements;
}

const BodyShape& BodyEstimator::shape() const {
    return state_->shape;
}

}  // namespace cheval::fitting

#include "fitting/body/body_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "fitting/body/sample_window.h"
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
constexpr float kFacing = 0.45F;          // Sine of how far the shoulders may be turned from the glass.
constexpr float kLeaning = 0.26F;         // Sine of how far the trunk may lean.
constexpr std::size_t kFirstSamples = 5;  // Enough for a first shape.
constexpr int kDwellFrames = 15;          // Between two shapes: garments are not fitted again for a passing twitch.
constexpr float kWorthFitting = 0.01F;    // One per cent.
// From the palm's centre back to the wrist, as part of elbow to palm (half a palm of 0.06 statures over a forearm of
// 0.146: Drillis and Contini 1966).
constexpr float kPalmToWrist = 0.17F;
// Half a pixel of outline at each end.
constexpr float kOutlinePixels = 0.7F;

// Standard uncertainties in metres that stay however long one looks: hair and soles, where a joint is taken to be, and
// how far trousers hang below the crotch.
constexpr float kHairAndShoes = 0.01F;
constexpr float kJointPlace = 0.01F;
constexpr float kTrouserRise = 0.03F;

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
    BodyEstimatorOptions options;
    Proportions mannequin;
    std::array<SampleWindow, kProportionCount> windows;
    SampleWindow armLength;
    SampleWindow insideLeg;
    Measurements measurements;
    BodyShape shape;
    std::uint32_t user = 0;
    int frames = 0;
    int sinceShape = 0;
    float pixelMetres = 0.0F;  // What one pixel spans at the shopper.

    void forget() {
        for (SampleWindow& window : windows)
            window.clear();
        armLength.clear();
        insideLeg.clear();
        measurements = {};
        frames = 0;
        sinceShape = 0;
        if (shape.measured) {
            shape.scale.setOnes();
            shape.measured = false;
            shape.converged = false;
            ++shape.revision;
        }
    }

    bool addEvidence(const hal::DepthFrame& frame, const Users& users, const User& active, const Skeleton& skeleton,
                     const SensorPlacement& placement);
    void addArms(const Skeleton& skeleton, Proportions& seen);
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
    const bool differs = ((scale - shape.scale).array().abs() > kWorthFitting * shape.scale.array()).any();
    if (!first && !converges && !(differs && sinceShape >= kDwellFrames)) return;
    shape.scale = scale;
    shape.measured = true;
    shape.converged = measurements.converged;
    ++shape.revision;
    sinceShape = 0;
}

BodyEstimator::BodyEstimator(const Body& body, const BodyEstimatorOptions& options)
    : state_(std::make_unique<State>()) {
    state_->options = options;
    state_->mannequin = measureMannequin(body);
}

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
    if (!usable || !s.addEvidence(frame, users, *active, skeleton, placement)) return;
    s.frames = std::min(s.frames + 1, std::max(s.options.averagedFrames, 1));
    s.report();
    s.reshape();
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

#include "fitting/tracking/lone_hand.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace cheval::fitting::tracking {
namespace {

/// From the nearest reading back: a hand and some of its arm.
constexpr float kDeepest = 0.25F;
/// Square metres: from a child's fist to a hand with a forearm.
constexpr float kLeastArea = 0.002F;
constexpr float kMostArea = 0.09F;
/// What is held out is at most this far behind the nearest surface.
constexpr float kHeldOut = 0.10F;
/// Metres: palms, as the largest circle inside the outline.
constexpr float kLeastPalm = 0.018F;
constexpr float kMostPalm = 0.06F;
/// The palm's radius in shares of the distance from head to neck, over hands of both kinds.
constexpr float kPalmShare = 0.285F;
constexpr float kForearm = 0.25F;
constexpr int kAllFingers = 5;
constexpr int kSurelyHand = 2;

}  // namespace

LoneHandReader::LoneHandReader()
    : mask_(kCloudCells), labels_(kCloudCells), scratch_(kCloudCells), components_(kMaximumComponents + 1) {}

bool LoneHandReader::findSurface(const hal::DepthFrame& frame) {
    CloudJob points{.depth = frame.depth, .intrinsics = frame.intrinsics, .placement = {}, .cloud = &cloud_};
    if (!points.isValid()) return false;
    points.run();
    ComponentsJob surfaces{
        .cloud = &cloud_, .mask = mask_, .scratch = scratch_, .labels = labels_, .components = components_};
    std::transform(cloud_.depth.begin(), cloud_.depth.end(), mask_.begin(),
                   [](float depth) { return depth > 0.0F ? std::uint8_t{1} : std::uint8_t{0}; });
    // The nearest surface of the size of an arm. One that is joined to a body is cut off behind the hand first.
    std::size_t best = 0;
    for (int attempt = 0; attempt < 2 && best == 0; ++attempt) {
        surfaces.run();
        std::size_t nearest = 0;
        for (std::size_t i = 1; i <= surfaces.count; ++i) {
            const Component& surface = components_[i];
            if (surface.area < kLeastArea) continue;
            const float depth = surface.lower.z();
            if (nearest == 0 || depth < components_[nearest].lower.z()) nearest = i;
            if (surface.area < kMostArea && (best == 0 || depth < components_[best].lower.z())) best = i;
        }
        if (nearest == 0) return false;
        // Something else before a whole body is not what is held out.
        const float first = components_[nearest].lower.z();
        if (best != 0 && components_[best].lower.z() > first + kHeldOut) best = 0;
        for (std::size_t i = 0; i < kCloudCells; ++i) {
            mask_[i] = mask_[i] != 0 && cloud_.depth[i] < first + kDeepest ? 1 : 0;
        }
    }
    if (best == 0) return false;
    SilhouetteJob outline{
        .cloud = &cloud_, .labels = labels_, .label = static_cast<std::uint8_t>(best), .silhouette = &silhouette_};
    if (!outline.isValid()) return false;
    outline.run();
    return true;
}

LoneHandReader::Palm LoneHandReader::findPalm(const Eigen::Vector2f& middle, const Eigen::Vector2f& axis) const {
    Palm palm;
    const Silhouette& s = silhouette_;
    for (int row = s.top; row <= s.bottom; ++row) {
        for (int column = s.left; column <= s.right; ++column) {
            const std::size_t i = cellIndex(column, row);
            if (s.inside[i] == 0 || cloud_.depth[i] <= 0.0F) continue;
            const Eigen::Vector2f at(static_cast<float>(column), static_cast<float>(row));
            if ((at - middle).dot(axis) < 0.0F) continue;
            const float reach = s.reach[i] * cloud_.cellSize(s.surface[i]);
            if (reach <= palm.radius || reach > kMostPalm) continue;
            palm = {cloud_.point(i), reach};
        }
    }
    return palm;
}

Eigen::Vector3f LoneHandReader::towardsArm(const Palm& palm) const {
    // Beyond the longest finger there is only arm.
    constexpr float kBeyondFingers = 3.0F;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    const Silhouette& s = silhouette_;
    for (int row = s.top; row <= s.bottom; ++row) {
        for (int column = s.left; column <= s.right; ++column) {
            const std::size_t i = cellIndex(column, row);
            if (s.inside[i] == 0 || cloud_.depth[i] <= 0.0F) continue;
            const Eigen::Vector3f offset = cloud_.point(i) - palm.point;
            if (offset.norm() > kBeyondFingers * palm.radius) sum += offset.normalized();
        }
    }
    // Where none is seen, it lies behind the hand.
    if (sum.squaredNorm() < 1.0F) return Eigen::Vector3f::UnitZ();
    return sum.normalized();
}

LoneHandReader::Reading LoneHandReader::read(const hal::DepthFrame& frame) {
    if (!findSurface(frame)) return {};
    // The hand is at one end of what is seen, the arm at the other.
    const Silhouette& s = silhouette_;
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    Eigen::Matrix2f squares = Eigen::Matrix2f::Zero();
    int cells = 0;
    for (int row = s.top; row <= s.bottom; ++row) {
        for (int column = s.left; column <= s.right; ++column) {
            if (s.inside[cellIndex(column, row)] == 0) continue;
            const Eigen::Vector2f at(static_cast<float>(column - s.left), static_cast<float>(row - s.top));
            sum += at;
            squares += at * at.transpose();
            ++cells;
        }
    }
    if (cells == 0) return {};
    const Eigen::Vector2f mean = sum / static_cast<float>(cells);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> solver;
    solver.computeDirect(squares / static_cast<float>(cells) - mean * mean.transpose());
    const Eigen::Vector2f axis = solver.eigenvectors().col(1);
    const Eigen::Vector2f middle = mean + Eigen::Vector2f(static_cast<float>(s.left), static_cast<float>(s.top));
    const Palm onePalm = findPalm(middle, axis);
    const Palm otherPalm = findPalm(middle, -axis);
    const auto readHand = [&](const Palm& palm) {
        const Reading reading = readAt(frame, palm);
        return reading.fingers > kAllFingers ? Reading{} : reading;  // Not the palm.
    };
    const Reading one = readHand(onePalm);
    const Reading other = readHand(otherPalm);
    // From the arm's end the whole hand may look like fingers, but the palm is wider than an arm.
    const bool both = std::min(one.fingers, other.fingers) >= kSurelyHand;
    if (one.found && other.found && both) return onePalm.radius > otherPalm.radius ? one : other;
    return other.fingers > one.fingers || !one.found ? other : one;
}

LoneHandReader::Reading LoneHandReader::readAt(const hal::DepthFrame& frame, const Palm& palm) {
    Reading reading;
    if (palm.radius < kLeastPalm) return reading;
    const SensorPlacement& placement = cloud_.placement;
    const Eigen::Vector3f at = placement.toSensor(palm.point);
    const Eigen::Vector3f arm = placement.toSensor(palm.point + kForearm * towardsArm(palm));
    HandOpennessJob measured{.depth = frame.depth,
                             .intrinsics = frame.intrinsics,
                             .palm = at,
                             .elbow = arm,
                             .headToNeck = palm.radius / kPalmShare,
                             .close = false,
                             .context = &context_};
    if (!measured.isValid()) return reading;
    measured.run();
    if (!measured.found) return reading;
    reading.found = true;
    reading.fingers = measured.fingers;
    const float value = measured.openness;
    if (value > 0.0F && reading.fingers >= kAllFingers) {
        reading.state = HandState::open;
    } else if (value < 0.0F && reading.fingers == 0) {
        reading.state = HandState::closed;
    }
    reading.confidence = reading.state == HandState::unknown ? 0.2F : std::clamp(0.3F + std::abs(value), 0.0F, 1.0F);
    return reading;
}

}  // namespace cheval::fitting::tracking

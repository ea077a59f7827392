#include "tests/fitting/body/measured_visit.h"

#include <algorithm>
#include <cmath>

#include "fitting/body/body_estimator.h"
#include "fitting/tracking/tracker.h"
#include "hal/sim/view.h"
#include "hal/sim/world.h"

namespace cheval::fitting::test {

namespace {

namespace sim = hal::sim;
using Eigen::Vector3f;

constexpr double kScriptSeconds = 23.0;
constexpr float kFacing = 0.30F;     ///< Radians off the glass that still count as facing it …
constexpr float kShowsSide = 1.40F;  ///< … and from which a side is shown.
constexpr float kStands = 0.10F;     ///< Metres a second.

float yawOf(const Skeleton& skeleton) {
    const Vector3f ahead = skeleton[Joint::torso].orientation * Vector3f::UnitZ();
    return std::atan2(-ahead.x(), -ahead.z());
}

/// Follows where the script is by the truth of one frame after another. Times are seconds; negative: not yet.
class Stage {
  public:
    explicit Stage(const sim::View& view) : view_(view) {}

    void follow(const sim::WorldTruth& truth, double time) {
        const Skeleton& now = truth.skeleton;
        if (!now.present()) return;
        const float yaw = yawOf(now);
        const Vector3f place = now[Joint::torso].position;
        const bool stands = (place - before_).norm() * kFramesPerSecond < kStands;
        before_ = place;
        const bool faces = std::abs(yaw) < kFacing;
        if (faced_ < 0.0 && stands && faces && trunkInView(now)) faced_ = time;
        left_ |= yaw > kShowsSide;
        right_ |= yaw < -kShowsSide;
        if (left_ && right_ && sides_ < 0.0 && faces) sides_ = time;
    }
    [[nodiscard]] double faced() const { return faced_; }
    [[nodiscard]] bool sidesShown() const { return sides_ >= 0.0; }

  private:
    [[nodiscard]] bool trunkInView(const Skeleton& skeleton) const {
        return std::all_of(kTrunk.begin(), kTrunk.end(), [&](Joint joint) {
            const auto at = view_.project(view_.toSensor(skeleton[joint].position));
            return at.x() >= 0.0F && at.y() >= 0.0F && at.x() < static_cast<float>(view_.intrinsics().width) &&
                   at.y() < static_cast<float>(view_.intrinsics().height);
        });
    }
    static constexpr auto kFramesPerSecond = static_cast<float>(kMeasuredFramesPerSecond);
    static constexpr std::array<Joint, 5> kTrunk = {Joint::head, Joint::leftShoulder, Joint::rightShoulder,
                                                    Joint::leftHip, Joint::rightHip};

    const sim::View& view_;
    Vector3f before_ = Vector3f::Constant(1e3F);
    double faced_ = -1.0, sides_ = -1.0;
    bool left_ = false, right_ = false;
};

}  // namespace

MeasuredVisit measureVisit(const Body& body, const MeasuredOptions& options) {
    const auto world = sim::makeWorld({.seed = options.seed,
                                       .framesPerSecond = kMeasuredFramesPerSecond,
                                       .colour = false,
                                       .script = sim::Script::measuring,
                                       .visitSeconds = kScriptSeconds,
                                       .noiseScale = options.noiseScale,
                                       .clothing = options.clothing,
                                       .everybody = options.everybody});
    const sim::View view(hal::Intrinsics{}, world->options().mount);
    MeasuredVisit visit{.options = options};
    Stage stage(view);
    Tracker tracker(TrackerOptions{.mount = world->options().mount});
    BodyEstimator estimator(body, {});
    hal::Image<std::uint16_t> depth;
    hal::Image<hal::Rgb8> none;
    const auto frameCount = static_cast<std::uint64_t>(kScriptSeconds * kMeasuredFramesPerSecond);
    for (std::uint64_t i = 0; i < frameCount; ++i) {
        const double time = world->timeOf(i);
        sim::renderFrame(*world, i, depth, none);
        const hal::DepthFrame frame{.sequence = i,
                                    .sourceIndex = i,
                                    .captureTime = hal::TimePoint(hal::fromSeconds(time)),
                                    .restart = i == 0,
                                    .lastOfStill = true,
                                    .intrinsics = view.intrinsics(),
                                    .depth = depth.view()};
        tracker.track(frame);
        tracker.readHands(frame);
        estimator.update(frame, tracker.users(), tracker.skeleton(), tracker.placement());

        const sim::WorldTruth truth = sim::truthAt(*world, time);
        visit.truth = truth.figures[0].measurements;
        visit.wheelchair = truth.figures[0].wheelchair;
        visit.child = visit.truth[static_cast<std::size_t>(Dimension::stature)] < 1.45F;
        const bool sidesShown = stage.sidesShown();
        stage.follow(truth, time);
        if (stage.faced() < 0.0) continue;
        const Measurements& measured = estimator.measurements();
        const double facing = time - stage.faced();
        visit.faced = true;
        visit.end = measured;
        ++visit.frames;
        visit.trackedFrames += tracker.skeleton().present() ? 1 : 0;
        if (measured.converged && !visit.converged) visit.converged = facing;
        if (visit.facingCount < kFacingReadings &&
            facing + 1e-6 >= kReadingSeconds * static_cast<double>(visit.facingCount + 1)) {
            visit.facing[visit.facingCount++] = measured;
        }
        if (!sidesShown && stage.sidesShown()) visit.sides = measured;
        if (options.facingSeconds > 0.0 && facing >= options.facingSeconds) break;
    }
    return visit;
}

const char* nameOf(sim::Clothing clothing) {
    constexpr std::array<const char*, 5> kNames = {"bare", "tight", "ordinary", "loose", "wide"};
    return kNames[static_cast<std::size_t>(clothing)];
}

const char* nameOf(MeasurementDoubt doubt) {
    switch (doubt) {
        case MeasurementDoubt::none:
            return "none";
        case MeasurementDoubt::measuring:
            return "measuring";
        case MeasurementDoubt::child:
            return "child";
        case MeasurementDoubt::seated:
            return "seated";
        case MeasurementDoubt::looseClothes:
            return "loose clothes";
        case MeasurementDoubt::partlySeen:
            return "partly seen";
        case MeasurementDoubt::crowded:
            return "crowded";
        case MeasurementDoubt::tiltUnknown:
            return "tilt unknown";
    }
    return "?";
}

}  // namespace cheval::fitting::test

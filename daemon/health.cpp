#include "daemon/health.h"

#include <algorithm>
#include <utility>

#include "daemon/degrade_ladder.h"

namespace cheval::daemon {

namespace {

/// Shares of the rate that is due: under the first it is slow, from the second on it is not any more.
constexpr double kSlowUnder = 0.8;
constexpr double kQuickFrom = 0.9;

}  // namespace

std::string_view name(HealthState state) {
    switch (state) {
        case HealthState::ok:
            return "ok";
        case HealthState::absent:
            return "absent by design";
        case HealthState::degraded:
            return "degraded";
        case HealthState::fault:
            return "at fault";
    }
    return "";
}

HealthState overall(const std::vector<PartHealth>& parts) {
    HealthState worst = HealthState::ok;
    for (const PartHealth& part : parts)
        worst = std::max(worst, part.state);
    return worst == HealthState::absent ? HealthState::ok : worst;
}

HealthBoard::HealthBoard(const hal::Clock& clock, WallClock wall) : clock_(clock), wall_(std::move(wall)) {}

void HealthBoard::tell(std::string_view part, Verdict verdict) {
    const auto known =
        std::find_if(parts_.begin(), parts_.end(), [&](const PartHealth& other) { return other.part == part; });
    PartHealth& row = known == parts_.end() ? parts_.emplace_back() : *known;
    const bool same = row.part == part && row.state == verdict.state && row.reason == verdict.reason;
    if (same) return;
    row = {.part = part,
           .state = verdict.state,
           .reason = std::move(verdict.reason),
           .since = clock_.now(),
           .sinceWall = wall_()};
}

bool HealthBoard::Pulse::standsStill(std::uint64_t now, hal::TimePoint time) {
    if (!moved || now != count) moved = time;
    count = now;
    return time - *moved >= kHangs;
}

bool HealthBoard::Slowness::update(bool judged, double share, hal::TimePoint time) {
    if (!judged || share >= (slow ? kQuickFrom : kSlowUnder)) {
        since.reset();
        slow = false;
        return false;
    }
    if (!since) since = time;
    slow = slow || time - *since >= kSlow;
    return slow;
}

HealthBoard::Verdict HealthBoard::judgeView(fitting::ViewFault fault) {
    switch (fault) {
        case fitting::ViewFault::none:
            break;
        case fitting::ViewFault::noReadings:
            return {HealthState::degraded,
                    "frames come, but hardly a pixel has a depth. Mend: keep the sun off the place, see whether the "
                    "sensor's projector glows, and clean its windows"};
        case fitting::ViewFault::covered:
            return {HealthState::degraded,
                    "something within 0.75 m fills the sensor's view. Mend: take away what hangs or stands before it"};
        case fitting::ViewFault::upsideDown:
            return {HealthState::degraded,
                    "the floor is where the ceiling should be: the sensor is upside down. Mend: turn it over"};
        case fitting::ViewFault::floorElsewhere:
            return {HealthState::degraded,
                    "the floor does not lie where sensor.height_mm and sensor.tilt_deg (or the mount in sensor.json) "
                    "say. Mend: measure both again, or set height_mm = 0 to have the floor found; if they are right, "
                    "the focal length (fx, fy) is not this sensor's. Why: shoppers are put in wrong places and sizes"};
    }
    return {};
}

HealthBoard::Verdict HealthBoard::judgeSensor(const HealthInput& input) {
    const MirrorStatus& mirror = input.mirror;
    const bool judged =
        mirror.camera == CameraState::streaming && mirror.sensorFramesPerSecond > 0.0 && input.sensorKeepsTime;
    const bool slow = sensorRate_.update(judged, mirror.sensorFramesPerSecond / input.framesPerSecond, clock_.now());
    Verdict verdict;
    switch (mirror.camera) {
        case CameraState::streaming:
            verdict = judgeView(mirror.viewFault);
            if (verdict.state == HealthState::ok && slow) {
                verdict = {
                    HealthState::degraded,
                    "the sensor takes far fewer pictures a second than loop.fps asks for. Mend: give it a port "
                    "of its own, without a hub or a long cable; where it can do no more, set loop.fps to what it "
                    "does. Why: the mirror works, but joints lag behind and quick hands are overlooked"};
            }
            break;
        case CameraState::closed:
        case CameraState::waiting:
            verdict = {HealthState::degraded, "waiting for its first frame"};
            break;
        case CameraState::lost:
            verdict = {HealthState::fault, "there are no frames"};
            break;
        case CameraState::ended:
            verdict = {HealthState::degraded, "the recording is over"};
            break;
    }
    if (mirror.camera != CameraState::streaming && mirror.fault.length > 0) {
        // A sensor that is opened again after a fault has not come back before its first frame has.
        if (mirror.camera != CameraState::ended) verdict.state = HealthState::fault;
        verdict.reason = mirror.fault.view();
    }
    return verdict;
}

HealthBoard::Verdict HealthBoard::judgeDisplay(const HealthInput& input) {
    const bool still = pictures_.standsStill(input.mirror.pictures, clock_.now());
    if (input.mirror.displayFault.length > 0)
        return {HealthState::fault, std::string(input.mirror.displayFault.view())};
    if (still) {
        return {HealthState::fault,
                "the picture stands still: the renderer or the display hangs. Mend: it is restarted; if it comes back, "
                "send the journal"};
    }
    if (!input.haveDisplay) return {HealthState::absent, "display.kind is \"headless\""};
    return {};
}

HealthBoard::Verdict HealthBoard::judgeLoop(const HealthInput& input) {
    const MirrorStatus& mirror = input.mirror;
    const hal::TimePoint now = clock_.now();
    if (turns_.standsStill(mirror.turns, now))
        return {HealthState::fault, "the frame loop hangs. Mend: it is restarted; if it comes back, send the journal"};

    // Without frames the last picture is shown four times a second, and that is as it should be.
    double due = input.framesPerSecond * DegradeLadder::rungs()[mirror.degradeLevel].rateShare;
    // No loop shows more than the sensor takes; that is told of the sensor.
    if (mirror.sensorFramesPerSecond > 0.0) due = std::min(due, mirror.sensorFramesPerSecond);
    const double share = due > 0.0 ? mirror.framesPerSecond / due : 1.0;
    const bool slow = pictureRate_.update(mirror.camera == CameraState::streaming && mirror.pictures > 0, share, now);
    if (mirror.degradeLevel > 0) {
        return {HealthState::degraded, "drawn more plainly: " + std::string(mirror.degradeName) +
                                           ". Mend: see which task overruns, and what else this machine is doing"};
    }
    if (slow) {
        return {HealthState::degraded,
                "fewer pictures a second than loop.fps asks for. Mend: see what else this machine is doing, or whether "
                "the display is slower than that"};
    }
    return {};
}

const std::vector<PartHealth>& HealthBoard::update(const HealthInput& input) {
    const MirrorStatus& mirror = input.mirror;

    tell("sensor", judgeSensor(input));

    tell("display", judgeDisplay(input));

    Verdict buttons;
    if (mirror.buttonsFault.length > 0) {
        buttons = {HealthState::fault, std::string(mirror.buttonsFault.view())};
    } else if (!input.haveButtons) {
        buttons = {HealthState::absent, "none are configured"};
    }
    tell("buttons", std::move(buttons));

    Verdict wardrobe;
    for (const std::string& refusal : input.refusals)
        wardrobe.reason += (wardrobe.reason.empty() ? "" : "  |  ") + refusal;
    if (!wardrobe.reason.empty()) wardrobe.state = HealthState::degraded;
    if (!input.haveBody || input.outfits == 0) {
        wardrobe.state = HealthState::fault;
        if (wardrobe.reason.empty()) {
            wardrobe.reason = input.haveBody ? "there is nothing to wear. Mend: name outfits in wardrobe.outfits"
                                             : "there is no mannequin, so nobody can be dressed";
        }
    }
    tell("wardrobe", std::move(wardrobe));

    Verdict settings;
    if (!input.settingsProblem.empty()) settings = {HealthState::degraded, input.settingsProblem};
    tell("settings", std::move(settings));

    tell("loop", judgeLoop(input));

    Verdict bus;
    if (!input.busWanted) {
        bus = {HealthState::absent, "bus.kind is \"none\""};
    } else if (!input.busProblem.empty()) {
        bus = {HealthState::degraded, input.busProblem};
    }
    tell("bus", std::move(bus));
    return parts_;
}

}  // namespace cheval::daemon

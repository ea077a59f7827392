#include "daemon/hands_run.h"

#include <chrono>
#include <memory>
#include <utility>

#include "fitting/tracking/lone_hand.h"
#include "hal/clock.h"
#include "hal/replay/replay_camera.h"

namespace cheval::daemon {

Expected<HandsReport> readHands(const std::string& folder) {
    hal::VirtualClock clock;
    Expected<std::unique_ptr<hal::ReplayCamera>> made =
        hal::makeReplayCamera({.folder = folder, .stillRepeats = 1}, clock);
    if (!made) return std::move(made).error();
    hal::ReplayCamera& camera = **made;
    Expected<void> opened = camera.open();
    if (!opened) return std::move(opened).error();
    fitting::tracking::LoneHandReader reader;
    HandsReport report;
    hal::DepthFrame frame;
    while (true) {
        const hal::FrameStatus status = camera.waitFrame(std::chrono::seconds(1), frame);
        // A folder has its next picture at once, or none.
        if (status != hal::FrameStatus::frame) break;
        const fitting::tracking::LoneHandReader::Reading reading = reader.read(frame);
        report.readings.push_back({.name = camera.pictureName(frame.sourceIndex),
                                   .state = reading.state,
                                   .confidence = reading.confidence,
                                   .fingers = reading.fingers});
    }
    report.warnings = camera.warnings();
    return report;
}

}  // namespace cheval::daemon

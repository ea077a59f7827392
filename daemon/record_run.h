// `chevalctl record`: what the configured sensor sees, into a folder that `chevalctl replay` reads. Nothing is written
// unless privacy.recording says so, and colour only where privacy.recording_colour says so too.
#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "config/settings.h"
#include "hal/clock.h"
#include "hal/depth_camera.h"
#include "hal/expected.h"
#include "hal/replay/recording_writer.h"

namespace cheval::daemon {

struct RecordOptions {
    std::string folder;          ///< Empty, or not there yet.
    double seconds = 0.0;        ///< End after this long; 0: no limit.
    std::uint64_t frames = 0;    ///< End after so many frames; 0: no limit.
    std::function<bool()> stop;  ///< Asked between frames, at least ten times a second; may be empty.
    std::function<void(const hal::CameraInfo&)> started;  ///< The sensor is open; may be empty.
};

struct RecordReport {
    hal::RecordingCounts frames;
    std::uint64_t missed = 0;    ///< Frames that the sensor lost on the way here.
    bool colour = false;         ///< Colour was written.
    std::optional<Error> fault;  ///< Why it ended early; what was written until then can be played.
};

/// Records until a limit is reached, stop() says so, or a recording that is the source ends; such a source is played
/// once, whatever sensor.loop says, and copied without loss. Errors: invalidInput with the key (the settings do not
/// allow it), the sensor does not open, the folder is refused.
Expected<RecordReport> recordSensor(const config::Settings& settings, const RecordOptions& options, hal::Clock& clock);

/// As recordSensor(), from a camera that is not open yet and is closed at the end.
Expected<RecordReport> recordCamera(hal::DepthCamera& camera, const config::Settings& settings,
                                    const RecordOptions& options, hal::Clock& clock);

/// SIGINT, SIGTERM and SIGHUP as a question instead of an end. Make it before any thread is started. Thread-bound.
class StopSignals {
  public:
    StopSignals();
    /// As it was before.
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;
    /// True once one has come. From then on a second one ends the process, should the disk hold it.
    bool requested();

  private:
    sigset_t signals_{};
    sigset_t before_{};
    bool requested_ = false;
};

}  // namespace cheval::daemon

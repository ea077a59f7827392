// `chevalctl replay`: a recording through the daemon's own pipeline, causal and deterministic: record i is written
// before frame i + 1 is read, every task runs on every frame, the degrade ladder stays at the top.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "config/settings.h"
#include "daemon/scheduler.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// What the pictures of a replay show.
enum class ReplayView : std::uint8_t {
    mirror,    ///< What the shopper would see …
    avatar,    ///< … in either of the mirror's views.
    tracking,  ///< What tracking makes of the depth picture (render/tracking_view.h), twice as large; needs no GL.
};

struct ReplayRunOptions {
    std::string source;  ///< A folder of depth pictures with sensor.json.
    std::string tracks;  ///< Tracks file; empty: none.
    std::string frames;  ///< Folder for frame-NNNNNN.png, numbered as the source; empty: none.
    std::string outfit;  ///< Garments by id, joined by , or +; empty: the settings' start outfit.
    ReplayView view = ReplayView::mirror;
    bool realTime = false;  ///< At the recording's own pace instead of as fast as it goes. The results are the same.
    int every = 1;          ///< Draw and write every n-th frame of a continuous recording.
};

struct ReplayReport {
    std::uint64_t frames = 0;    ///< Source frames (stills) that were played.
    std::uint64_t seen = 0;      ///< With a person in them.
    std::uint64_t dressed = 0;   ///< With that person dressed.
    std::uint64_t pictures = 0;  ///< Written.
    std::string renderer;        ///< The GL context in words; empty when nothing was drawn with one.
    std::vector<std::string> warnings;
    std::vector<TaskStatistics> tasks;
};

/// Refuses files and folders that are no recordings, unknown garments and a frame or file that cannot be written.
Expected<ReplayReport> replayRecording(const config::Settings& settings, const ReplayRunOptions& options);

}  // namespace cheval::daemon

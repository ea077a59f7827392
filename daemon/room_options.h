// From the settings to each room's own options. Only daemon/ sees the settings.
#pragma once

#include <string>

#include "config/settings.h"
#include "daemon/degrade_ladder.h"
#include "daemon/recovery.h"
#include "daemon/scheduler.h"
#include "daemon/session.h"
#include "daemon/wardrobe.h"
#include "fitting/tracking/tracker.h"
#include "hal/display.h"
#include "hal/frame.h"
#include "hal/gpiod/gpiod_buttons.h"
#include "hal/gpiod/power_line.h"
#include "hal/preview/preview_server.h"
#include "hal/replay/replay_camera.h"
#include "hal/sensor_process/process_camera.h"
#include "hal/sim/world.h"
#include "render/renderer.h"

namespace cheval::daemon {

/// How the sensor hangs: `declared` is what the camera says of its own mount; it counts where the settings leave the
/// height at 0.
hal::Mount sensorMount(const config::Settings& settings, const hal::Mount& declared);
fitting::GestureOptions gestureOptions(const config::Settings& settings);
/// `declared` as for sensorMount().
fitting::TrackerOptions trackerOptions(const config::Settings& settings, const hal::Mount& declared);
SessionOptions sessionOptions(const config::Settings& settings, const Wardrobe& wardrobe);
SchedulerOptions schedulerOptions(const config::Settings& settings);
LadderOptions ladderOptions(const config::Settings& settings);
/// `hardware` says which rungs can be taken; it is borrowed, and may be null.
RecoveryOptions recoveryOptions(const config::Settings& settings, const RecoveryHardware* hardware);
WardrobeOptions wardrobeOptions(const config::Settings& settings);
render::RendererOptions rendererOptions(const config::Settings& settings, const hal::DisplayMode& mode);
hal::DisplayMode displayMode(const config::Settings& settings);
hal::PreviewOptions previewOptions(const config::Settings& settings);
hal::sim::WorldOptions worldOptions(const config::Settings& settings);
hal::ReplayOptions replayOptions(const config::Settings& settings);
/// What cheval-sensor is to open: the settings' device, or, where `recording` is not empty, that .oni file. An opening
/// is waited for in parts short enough for the frame loop.
hal::ProcessCameraOptions sensorProcessOptions(const config::Settings& settings, const std::string& recording);
hal::GpiodButtonsOptions gpiodButtonsOptions(const config::Settings& settings);
hal::PowerLineOptions powerLineOptions(const config::Settings& settings);
/// A recording that OpenNI2 plays and hal/replay does not.
bool isOniFile(const std::string& path);

}  // namespace cheval::daemon

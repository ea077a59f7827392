#include "daemon/devices.h"

#include <utility>

#include "config/settings_table.h"
#include "daemon/log.h"
#include "daemon/room_options.h"
#include "hal/headless/headless_display.h"

namespace cheval::daemon {

Expected<std::unique_ptr<Screen>> Screen::open(const config::Settings& settings, hal::Clock& clock) {
    std::unique_ptr<Screen> screen(new Screen);
    if (settings.display.kind == config::DisplayKind::preview) {
        Expected<std::unique_ptr<hal::PreviewServer>> preview = hal::startPreview(previewOptions(settings), clock);
        if (!preview) return std::move(preview).error().within("while starting the preview");
        screen->preview_ = std::move(*preview);
        screen->display_ = &screen->preview_->display();
    } else {
        screen->headless_ = hal::makeHeadlessDisplay({.mode = displayMode(settings)});
        screen->display_ = screen->headless_.get();
    }
    Expected<hal::DisplayMode> mode = screen->display_->open();
    if (!mode) {
        screen->display_ = nullptr;
        return std::move(mode).error().within("while opening the display");
    }
    screen->mode_ = *mode;
    return screen;
}

Screen::~Screen() {
    if (display_ != nullptr) display_->close();
}

bool Screen::same(const config::Settings& a, const config::Settings& b) {
    for (const config::Setting& setting : config::settingsTable()) {
        if (setting.section != "display" && setting.section != "preview") continue;
        if (setting.get(a) != setting.get(b)) return false;
    }
    return true;
}

FrameSource makeFrameSource(const config::Settings& settings, hal::Clock& clock) {
    const bool replay = settings.sensor.source == config::SensorSource::replay;
    if (settings.sensor.source == config::SensorSource::openni || (replay && isOniFile(settings.sensor.folder))) {
        hal::ProcessCameraOptions options =
            sensorProcessOptions(settings, replay ? settings.sensor.folder : std::string());
        options.loop = replay && settings.sensor.loop;
        return {.camera = [options, &clock]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
            return std::unique_ptr<hal::DepthCamera>(hal::makeProcessCamera(options, clock));
        }};
    }
    if (replay) {
        const hal::ReplayOptions options = replayOptions(settings);
        return {.camera = [options, &clock]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
            Expected<std::unique_ptr<hal::ReplayCamera>> camera = hal::makeReplayCamera(options, clock);
            if (!camera) return std::move(camera).error();
            for (const std::string& warning : (*camera)->warnings())
                log(Severity::warning, warning);
            return std::unique_ptr<hal::DepthCamera>(std::move(*camera));
        }};
    }
    std::shared_ptr<hal::sim::World> world = hal::sim::makeWorld(worldOptions(settings));
    return {.camera = [world, &clock]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
                return hal::sim::makeSimulatedCamera(world, clock);
            },
            .buttons = hal::sim::makeSimulatedButtons(world, clock)};
}

std::unique_ptr<hal::Buttons> makeButtons(const config::Settings& settings, const hal::Clock& clock) {
    if (settings.buttons.source != config::ButtonSource::gpio) return nullptr;
    return hal::makeGpiodButtons(gpiodButtonsOptions(settings), hal::makeGpiodLines(), clock);
}

}  // namespace cheval::daemon

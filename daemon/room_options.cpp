#include "daemon/room_options.h"

#include <array>
#include <filesystem>
#include <optional>
#include <utility>

#include "config/shipped_files.h"

namespace cheval::daemon {

hal::Mount sensorMount(const config::Settings& settings, const hal::Mount& declared) {
    if (settings.sensor.heightMm <= 0.0) return declared;
    return {.heightMm = static_cast<float>(settings.sensor.heightMm),
            .tiltDeg = static_cast<float>(settings.sensor.tiltDeg),
            .rollDeg = static_cast<float>(settings.sensor.rollDeg),
            .known = true};
}

fitting::GestureOptions gestureOptions(const config::Settings& settings) {
    const auto& gestures = settings.gestures;
    return {.swipeStartSpeed = static_cast<float>(gestures.swipeStartSpeed),
            .swipeEndSpeed = static_cast<float>(gestures.swipeEndSpeed),
            .swipePeakSpeed = static_cast<float>(gestures.swipePeakSpeed),
            .swipeDistance = static_cast<float>(gestures.swipeDistance),
            .swipeSteepest = static_cast<float>(gestures.swipeSteepest),
            .swipeLongest = static_cast<float>(gestures.swipeLongestSeconds),
            .grabOpenBefore = static_cast<float>(gestures.grabOpenBeforeSeconds),
            .grabClosedLeast = static_cast<float>(gestures.grabClosedLeastSeconds),
            .grabClosedLongest = static_cast<float>(gestures.grabClosedLongestSeconds),
            .grabLowest = static_cast<float>(gestures.grabLowest),
            .raiseHold = static_cast<float>(gestures.raiseHoldSeconds),
            .raiseRest = static_cast<float>(gestures.raiseRestSeconds),
            .holdTime = static_cast<float>(gestures.holdSeconds),
            .holdMovement = static_cast<float>(gestures.holdMovement),
            .holdAway = static_cast<float>(gestures.holdAway),
            .holdRest = static_cast<float>(gestures.holdRestSeconds),
            .walkingSpeed = static_cast<float>(gestures.walkingSpeed)};
}

fitting::TrackerOptions trackerOptions(const config::Settings& settings, const hal::Mount& declared) {
    hal::Mount mount = sensorMount(settings, declared);
    // A sensor turned clockwise sees the world turned the other way.
    if (settings.sensor.rotation == config::Rotation::clockwise) mount.rollDeg += 90.0F;
    if (settings.sensor.rotation == config::Rotation::anticlockwise) mount.rollDeg -= 90.0F;
    return {.mount = mount,
            .zoneNearMetres = static_cast<float>(settings.zone.nearMetres),
            .zoneFarMetres = static_cast<float>(settings.zone.farMetres),
            .zoneHalfWidthMetres = static_cast<float>(settings.zone.halfWidthMetres),
            .gestures = gestureOptions(settings)};
}

SessionOptions sessionOptions(const config::Settings& settings, const Wardrobe& wardrobe) {
    return {.approach = hal::fromSeconds(settings.session.approachSeconds),
            .acquire = hal::fromSeconds(settings.session.acquireSeconds),
            .acquireLimit = hal::fromSeconds(settings.session.acquireLimitSeconds),
            .leave = hal::fromSeconds(settings.session.leaveSeconds),
            .gone = hal::fromSeconds(settings.session.goneSeconds),
            .swipeLeftIsNext = settings.session.swipe == config::SwipeMeaning::carousel,
            .holdChangesView = settings.session.hold == config::HoldMeaning::view,
            .outfitCount = wardrobe.outfits.size(),
            .startOutfit = wardrobe.startOutfit,
            .startInAvatarView = settings.render.view == config::StartView::avatar};
}

SchedulerOptions schedulerOptions(const config::Settings& settings) {
    return {.framePeriod = hal::fromSeconds(1.0 / settings.loop.fps), .budgetScale = settings.loop.budgetScale};
}

LadderOptions ladderOptions(const config::Settings& settings) {
    return {.enabled = settings.loop.degrade};
}

namespace {

/// The sensor program of the build that this program itself belongs to; elsewhere a name that is not found.
std::string builtSensor() {
    const std::filesystem::path built(CHEVAL_BUILT_SENSOR);
    std::error_code failed;
    const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", failed);
    const std::string folder = built.parent_path().parent_path().string() + "/";
    return !failed && own.string().starts_with(folder) ? built.string() : "cheval-sensor";
}

}  // namespace

RecoveryOptions recoveryOptions(const config::Settings& settings, const RecoveryHardware* hardware) {
    RecoveryOptions options{.silence = std::chrono::milliseconds(settings.sensor.lostAfterMs),
                            .longestPause = hal::fromSeconds(settings.recovery.longestPauseSeconds),
                            .restartAfter = hal::fromSeconds(60.0 * settings.recovery.restartAfterMinutes),
                            .highest = static_cast<RecoveryRung>(static_cast<int>(RecoveryRung::reopenDevice) +
                                                                 static_cast<int>(settings.recovery.highest))};
    if (hardware != nullptr) {
        options.available = [hardware](RecoveryRung rung) { return hardware->available(rung); };
        options.restartsBefore = hardware->restartsBefore();
    }
    // A recording may hold gaps of any length, and any number of pictures a second: neither is a lost camera.
    if (settings.sensor.source == config::SensorSource::replay) options.silence.reset();
    return options;
}

namespace {

std::optional<fitting::SizesFor> sizesFor(config::SizesFor people) {
    switch (people) {
        case config::SizesFor::women:
            return fitting::SizesFor::women;
        case config::SizesFor::men:
            return fitting::SizesFor::men;
        case config::SizesFor::none:
            break;
    }
    return std::nullopt;
}

}  // namespace

WardrobeOptions wardrobeOptions(const config::Settings& settings) {
    return {.folder = settings.wardrobe.folder.empty() ? shippedAssetsFolder() : settings.wardrobe.folder,
            .garments = settings.wardrobe.garments,
            .outfits = settings.wardrobe.outfits,
            .startOutfit = settings.wardrobe.startOutfit,
            .sizesFolder = settings.fitting.sizesFolder.empty() ? shippedSizesFolder() : settings.fitting.sizesFolder,
            .sizesFor = sizesFor(settings.fitting.sizes)};
}

render::RendererOptions rendererOptions(const config::Settings& settings, const hal::DisplayMode& mode) {
    render::ContextKind context = render::ContextKind::automatic;
    if (settings.render.context == config::RenderContext::egl) context = render::ContextKind::egl;
    if (settings.render.context == config::RenderContext::osmesa) context = render::ContextKind::osmesa;
    return {.width = mode.width,
            .height = mode.height,
            .context = context,
            .rotated = settings.sensor.rotation != config::Rotation::none};
}

hal::DisplayMode displayMode(const config::Settings& settings) {
    return {.width = static_cast<int>(settings.display.width),
            .height = static_cast<int>(settings.display.height),
            .refreshHz = settings.display.refreshHz};
}

hal::PreviewOptions previewOptions(const config::Settings& settings) {
    return {.mode = displayMode(settings),
            .port = static_cast<std::uint16_t>(settings.preview.port),
            .jpegQuality = static_cast<int>(settings.preview.jpegQuality),
            .streamWidth = static_cast<int>(settings.preview.streamWidth)};
}

hal::sim::WorldOptions worldOptions(const config::Settings& settings) {
    return {.seed = static_cast<std::uint32_t>(settings.simulation.seed),
            .framesPerSecond = settings.loop.fps,
            .colour = settings.simulation.colour,
            .sensorNoise = settings.simulation.noise,
            .visitSeconds = settings.simulation.visitSeconds,
            .pauseSeconds = settings.simulation.pauseSeconds};
}

hal::ReplayOptions replayOptions(const config::Settings& settings) {
    return {.folder = settings.sensor.folder, .loop = settings.sensor.loop};
}

hal::ProcessCameraOptions sensorProcessOptions(const config::Settings& settings, const std::string& recording) {
    hal::ProcessCameraOptions options{.program = config::shippedPath("bin/cheval-sensor"),
                                      .openWait = std::chrono::milliseconds(50)};
    if (options.program.empty()) options.program = builtSensor();
    if (!recording.empty()) {
        options.arguments = {"--recording", recording};
    } else if (!settings.sensor.device.empty()) {
        options.arguments = {"--device", settings.sensor.device};
    }
    return options;
}

hal::GpiodButtonsOptions gpiodButtonsOptions(const config::Settings& settings) {
    const auto& buttons = settings.buttons;
    hal::GpiodButtonsOptions options{.times = {.debounce = std::chrono::milliseconds(buttons.debounceMs),
                                               .longPress = std::chrono::milliseconds(buttons.longPressMs),
                                               .stuck = hal::fromSeconds(buttons.stuckSeconds)}};
    const std::array<std::pair<hal::Button, const std::string*>, 5> lines = {
        {{hal::Button::next, &buttons.next},
         {hal::Button::previous, &buttons.previous},
         {hal::Button::view, &buttons.view},
         {hal::Button::service, &buttons.service},
         {hal::Button::wake, &buttons.wake}}};
    for (const auto& [button, line] : lines) {
        if (line->empty()) continue;
        options.wirings.push_back({.button = button,
                                   .line = {.chip = buttons.chip,
                                            .line = *line,
                                            .activeLow = buttons.activeLow,
                                            .bias = static_cast<hal::LineBias>(buttons.bias)}});
    }
    return options;
}

hal::PowerLineOptions powerLineOptions(const config::Settings& settings) {
    return {.line = {.chip = settings.power.chip, .line = settings.power.line, .activeLow = settings.power.activeLow},
            .off = std::chrono::milliseconds(settings.power.offMs)};
}

bool isOniFile(const std::string& path) {
    return std::filesystem::path(path).extension() == ".oni";
}

}  // namespace cheval::daemon

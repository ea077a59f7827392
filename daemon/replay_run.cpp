#include "daemon/replay_run.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "daemon/devices.h"
#include "daemon/mirror.h"
#include "daemon/room_options.h"
#include "daemon/tracks_writer.h"
#include "fitting/tracking/hand_region.h"
#include "hal/png/png.h"
#include "hal/replay/replay_camera.h"
#include "render/tracking_view.h"

namespace cheval::daemon {

namespace {

namespace fs = std::filesystem;

/// What is played, with what it has to say about it afterwards.
struct Source {
    std::unique_ptr<hal::DepthCamera> camera;
    const hal::ReplayCamera* folder = nullptr;  ///< Null for an .oni file, which OpenNI2 plays.
};

Expected<Source> openSource(const config::Settings& settings, const std::string& source, hal::Clock& clock) {
    if (isOniFile(source)) {
        std::error_code failed;
        if (!std::filesystem::is_regular_file(source, failed)) {
            return Error{.code = ErrorCode::notFound,
                         .cause = "there is no such recording",
                         .mend = "name an .oni file, or a folder with a sensor.json",
                         .file = source};
        }
        hal::ProcessCameraOptions options = sensorProcessOptions(settings, source);
        options.openWait = std::chrono::seconds(15);
        auto camera = hal::makeProcessCamera(options, clock);
        // What hangs here would hang later on a clock that stands still meanwhile.
        Expected<void> opened = camera->open();
        if (!opened) return std::move(opened).error();
        camera->close();
        return Source{.camera = std::move(camera)};
    }
    Expected<std::unique_ptr<hal::ReplayCamera>> recording = hal::makeReplayCamera({.folder = source}, clock);
    if (!recording) return std::move(recording).error();
    const hal::ReplayCamera* folder = recording->get();
    return Source{.camera = std::move(*recording), .folder = folder};
}

Expected<void> makeFolder(const std::string& folder) {
    std::error_code failed;
    if (folder.empty() || fs::is_directory(folder, failed) || fs::create_directories(folder, failed)) return {};
    return Error{.code = ErrorCode::unavailable,
                 .cause = "the folder cannot be made: " + failed.message(),
                 .mend = "name one that may be written",
                 .file = folder};
}

/// Writes pictures under their source's number.
class PictureFiles {
  public:
    explicit PictureFiles(std::string folder) : folder_(std::move(folder)) {}

    void write(std::uint64_t sourceIndex, hal::ImageView<const hal::Rgba8> picture) {
        if (error_) return;
        const std::string path = (fs::path(folder_) / fmt::format("frame-{:06}.png", sourceIndex)).string();
        Expected<void> written = hal::writePng(path, picture, {.compression = 3});
        if (!written) {
            error_ = std::move(written).error();
            return;
        }
        ++count_;
    }
    [[nodiscard]] bool wanted() const { return !folder_.empty(); }
    [[nodiscard]] const std::optional<Error>& error() const { return error_; }
    [[nodiscard]] std::uint64_t count() const { return count_; }

  private:
    std::string folder_;
    std::optional<Error> error_;
    std::uint64_t count_ = 0;
};

/// What the tracking view shows of the frame that the chain has just taken in.
render::TrackingPicture trackingPicture(const hal::DepthFrame& frame, const FrameChain& chain) {
    const fitting::Tracker& tracker = chain.tracker();
    const fitting::Skeleton& skeleton = tracker.skeleton();
    render::TrackingPicture picture{.frame = &frame,
                                    .users = &tracker.users(),
                                    .skeleton = &skeleton,
                                    .hands = &chain.hands(),
                                    .placement = tracker.placement()};
    if (skeleton.present()) {
        picture.handRegion = fitting::tracking::HandRegionJob::kSideFactor *
                             (skeleton[fitting::Joint::head].position - skeleton[fitting::Joint::neck].position).norm();
        const fitting::Measurements* measurements = chain.measurements();
        if (measurements != nullptr) picture.stature = (*measurements)[fitting::Dimension::stature];
    }
    return picture;
}

/// Made with the first frame, whose size it takes.
Expected<void> writeTrackingView(std::optional<render::TrackingView>& view, const render::TrackingPicture& picture,
                                 bool draw, PictureFiles& files) {
    const hal::ImageView<const std::uint16_t> depth = picture.frame->depth;
    if (!view) {
        Expected<render::TrackingView> made = render::TrackingView::create(depth.width, depth.height);
        if (!made) return std::move(made).error();
        view = std::move(*made);
    }
    view->follow(picture);
    if (!draw) return {};
    const Expected<hal::ImageView<const hal::Rgba8>> drawn = view->draw(picture);
    if (!drawn) return drawn.error();
    files.write(picture.frame->sourceIndex, *drawn);
    return {};
}

}  // namespace

Expected<ReplayReport> replayRecording(const config::Settings& given, const ReplayRunOptions& options) {
    Expected<void> checked = makeFolder(options.frames);
    if (!checked) return std::move(checked).error();

    config::Settings settings = given;
    settings.sensor.source = config::SensorSource::replay;
    settings.display.kind = config::DisplayKind::headless;
    settings.render.view = options.view == ReplayView::avatar ? config::StartView::avatar : config::StartView::mirror;
    Wardrobe wardrobe = loadWardrobe(wardrobeOptions(settings));
    ReplayReport report;
    for (const Error& refusal : wardrobe.refusals)
        report.warnings.push_back(refusal.message());
    if (!options.outfit.empty()) {
        Expected<std::size_t> chosen = chooseOutfit(wardrobe, options.outfit);
        if (!chosen) return std::move(chosen).error();
        wardrobe.startOutfit = *chosen;
    }

    hal::VirtualClock virtualClock;
    hal::SteadyClock steadyClock;
    hal::Clock& clock = options.realTime ? static_cast<hal::Clock&>(steadyClock) : virtualClock;
    // Admission goes by a clock that stands still, so that no task is ever put off, whatever the pace.
    const hal::VirtualClock still;
    Expected<std::unique_ptr<Screen>> screen = Screen::open(settings, clock);
    if (!screen) return std::move(screen).error();

    Expected<Source> source = openSource(settings, options.source, clock);
    if (!source) return std::move(source).error();
    const hal::ReplayCamera* folder = source->folder;
    std::unique_ptr<hal::DepthCamera> camera = std::move(source->camera);
    std::unique_ptr<TracksWriter> tracks;
    if (!options.tracks.empty()) {
        Expected<std::unique_ptr<TracksWriter>> created = TracksWriter::create(options.tracks);
        if (!created) return std::move(created).error();
        tracks = std::move(*created);
    }

    PictureFiles files(options.frames);
    Expected<std::unique_ptr<Mirror>> made = Mirror::create(
        settings, {.camera = [&camera]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
                       if (camera != nullptr) return std::move(camera);
                       return Error{.code = ErrorCode::unavailable, .cause = "the recording is played once"};
                   },
                   .display = &(*screen)->display(),
                   .mode = (*screen)->mode(),
                   .clock = &clock,
                   .admission = &still,
                   .cost = &steadyClock,
                   .wardrobe = &wardrobe,
                   .observer =
                       [&files](const FramePacket& packet, hal::ImageView<const hal::Rgba8> picture) {
                           if (packet.hasPicture) files.write(packet.sourceIndex, picture);
                       },
                   .runToTheEnd = true});
    if (!made) return std::move(made).error();
    Mirror& mirror = **made;
    const bool tracking = options.view == ReplayView::tracking;
    const auto wanted = [&](const hal::DepthFrame& frame) {
        if (!files.wanted() || !frame.lastOfStill) return false;
        return mirror.camera().info().independent || frame.sourceIndex % static_cast<std::uint64_t>(options.every) == 0;
    };
    const auto draw = [&](const hal::DepthFrame& frame) { return !tracking && wanted(frame); };
    std::optional<render::TrackingView> trackingView;

    while (true) {
        const Expected<StepResult> step = mirror.step(draw);
        if (!step) return step.error();
        if (files.error()) return *files.error();
        if (*step == StepResult::ended || *step == StepResult::stopped) break;
        if (*step == StepResult::none) {
            if (mirror.camera().state() == CameraState::lost) return *mirror.camera().fault();
            continue;
        }
        const FrameChain& chain = mirror.chain();
        if (tracking && files.wanted()) {
            Expected<void> drawn =
                writeTrackingView(trackingView, trackingPicture(mirror.frame(), chain), wanted(mirror.frame()), files);
            if (!drawn) return std::move(drawn).error();
            if (files.error()) return *files.error();
        }
        if (tracks != nullptr) tracks->addGestures(chain.hands());
        if (!mirror.frame().lastOfStill) continue;
        ++report.frames;
        if (chain.tracker().skeleton().present()) ++report.seen;
        if (chain.session().dressed()) ++report.dressed;
        if (tracks == nullptr) continue;
        Expected<void> written =
            tracks->writeFrame(mirror.frame(), chain.tracker().skeleton(), chain.hands(), chain.tracker().placement());
        if (!written) return std::move(written).error();
    }
    if (tracks != nullptr) {
        Expected<void> finished = tracks->finish(mirror.chain().measurements());
        if (!finished) return std::move(finished).error();
    }
    if (folder != nullptr) {
        for (std::string& warning : folder->warnings())
            report.warnings.push_back(std::move(warning));
    }
    report.pictures = files.count();
    report.renderer = mirror.rendererDescription();
    report.tasks = mirror.statistics();
    return report;
}

}  // namespace cheval::daemon

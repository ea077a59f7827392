#include "daemon/record_run.h"

#include <ctime>
#include <memory>
#include <utility>

#include "daemon/devices.h"
#include "daemon/room_options.h"

namespace cheval::daemon {

namespace {

constexpr hal::Duration kOpenLimit = std::chrono::seconds(15);
constexpr hal::Duration kWait = std::chrono::milliseconds(100);
/// A recording that is the source waits for the disk, so that its copy has no holes.
constexpr hal::Duration kCopyPatience = std::chrono::seconds(30);

Expected<void> checkAllowed(const config::Settings& settings) {
    if (settings.privacy.recording) return {};
    return Error{
        .code = ErrorCode::invalidInput,
        .cause = "recording is off",
        .mend =
            "set privacy.recording = true, with the consent of everyone who will be seen, and take it away afterwards",
        .why = "no picture of a shopper is written anywhere unless the settings say so",
        .key = "privacy.recording"};
}

Error cannotOpen(Error error) {
    if (error.mend.empty()) error.mend = "look at the sensor's cable";
    error.mend +=
        "; if the mirror is running, stop it first (systemctl stop cheval), for one program alone can hold a sensor";
    return std::move(error).within("while opening the sensor");
}

/// Which number a frame gets; empty: it is not recorded.
std::optional<std::uint64_t> numberOf(const hal::DepthFrame& frame, const hal::CameraInfo& info) {
    if (!info.independent) return frame.sequence;
    // One of each still, however often it is shown.
    if (!frame.lastOfStill) return std::nullopt;
    return frame.sourceIndex;
}

/// One recording under way.
class Recorder {
  public:
    Recorder(hal::DepthCamera& camera, const config::Settings& settings, const RecordOptions& options,
             hal::Clock& clock)
        : camera_(camera), options_(options), clock_(clock), begin_(clock.now()), lastFrame_(begin_) {
        lostAfter_ = std::chrono::milliseconds(settings.sensor.lostAfterMs);
        if (settings.sensor.source == config::SensorSource::replay) patience_ = kCopyPatience;
    }

    RecordReport run(hal::RecordingWriter& writer) {
        while (!over() && step(writer)) {
        }
        Expected<void> finished = writer.finish();
        if (!finished) report_.fault = std::move(finished).error();
        report_.frames = writer.counts();
        return report_;
    }

  private:
    [[nodiscard]] bool over() const {
        if (options_.stop && options_.stop()) return true;
        if (options_.frames > 0 && added_ >= options_.frames) return true;
        return options_.seconds > 0.0 && hal::seconds(clock_.now() - begin_) >= options_.seconds;
    }

    /// False: nothing more is to come.
    bool step(hal::RecordingWriter& writer) {
        hal::DepthFrame frame;
        switch (camera_.waitFrame(kWait, frame)) {
            case hal::FrameStatus::frame:
                take(writer, frame);
                return !writer.fault();
            case hal::FrameStatus::timedOut:
                if (clock_.now() - lastFrame_ <= lostAfter_) return true;
                report_.fault = lost("no frame came for " + std::to_string(hal::seconds(lostAfter_)) + " s");
                return false;
            case hal::FrameStatus::lost:
                report_.fault = lost("the sensor is gone");
                return false;
            case hal::FrameStatus::ended:
            case hal::FrameStatus::closed:
                return false;
        }
        return false;
    }

    void take(hal::RecordingWriter& writer, const hal::DepthFrame& frame) {
        lastFrame_ = clock_.now();
        const std::optional<std::uint64_t> number = numberOf(frame, camera_.info());
        if (!number) return;
        if (last_ && *number > *last_ + 1) report_.missed += *number - *last_ - 1;
        last_ = number;
        if (writer.add(*number, frame, patience_)) ++added_;
    }

    static Error lost(std::string cause) {
        return {.code = ErrorCode::unavailable,
                .cause = std::move(cause),
                .mend = "look at the sensor's cable and record again into another folder",
                .why = "a recording goes no further than the sensor's first interruption"};
    }

    hal::DepthCamera& camera_;
    const RecordOptions& options_;
    hal::Clock& clock_;
    hal::TimePoint begin_;
    hal::TimePoint lastFrame_;
    hal::Duration lostAfter_{};
    hal::Duration patience_{};
    std::optional<std::uint64_t> last_;
    std::uint64_t added_ = 0;
    RecordReport report_;
};

/// A sensor's firmware may need some seconds, which open() tells by timedOut.
Expected<void> openPatiently(hal::DepthCamera& camera, const RecordOptions& options, hal::Clock& clock) {
    const hal::TimePoint limit = clock.now() + kOpenLimit;
    hal::Interrupt never;
    while (true) {
        Expected<void> opened = camera.open();
        if (opened || opened.error().code != ErrorCode::timedOut) return opened;
        if (clock.now() >= limit || (options.stop && options.stop())) return opened;
        clock.waitUntil(clock.now() + std::chrono::milliseconds(10), never);
    }
}

}  // namespace

Expected<RecordReport> recordCamera(hal::DepthCamera& camera, const config::Settings& settings,
                                    const RecordOptions& options, hal::Clock& clock) {
    if (auto allowed = checkAllowed(settings); !allowed) return std::move(allowed).error();
    if (auto opened = openPatiently(camera, options, clock); !opened) return cannotOpen(std::move(opened).error());
    const hal::CameraInfo info = camera.info();
    const bool colour = settings.privacy.recordingColour && info.colour;
    Expected<std::unique_ptr<hal::RecordingWriter>> writer =
        hal::RecordingWriter::create({.folder = options.folder,
                                      .sensor = {.intrinsics = info.intrinsics,
                                                 .framesPerSecond = info.framesPerSecond,
                                                 .mount = sensorMount(settings, info.mount),
                                                 .independent = info.independent},
                                      .colour = colour});
    if (!writer) {
        camera.close();
        return std::move(writer).error();
    }
    if (options.started) options.started(info);
    RecordReport report = Recorder(camera, settings, options, clock).run(**writer);
    camera.close();
    report.colour = colour;
    return report;
}

Expected<RecordReport> recordSensor(const config::Settings& given, const RecordOptions& options, hal::Clock& clock) {
    // Before anything is opened: a sensor's light tells people that they are seen.
    if (auto allowed = checkAllowed(given); !allowed) return std::move(allowed).error();
    config::Settings settings = given;
    settings.sensor.loop = false;
    const FrameSource source = makeFrameSource(settings, clock);
    Expected<std::unique_ptr<hal::DepthCamera>> camera = source.camera();
    if (!camera) return cannotOpen(std::move(camera).error());
    return recordCamera(**camera, settings, options, clock);
}

StopSignals::StopSignals() {
    sigemptyset(&signals_);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        sigaddset(&signals_, signal);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

StopSignals::~StopSignals() {
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool StopSignals::requested() {
    if (requested_) return true;
    const std::timespec none{};
    if (sigtimedwait(&signals_, nullptr, &none) < 0) return false;
    requested_ = true;
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    return true;
}

}  // namespace cheval::daemon

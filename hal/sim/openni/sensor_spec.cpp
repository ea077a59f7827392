#include "hal/sim/openni/sensor_spec.h"

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

#include "hal/replay/replay_camera.h"

namespace cheval::hal::sim {

namespace {

constexpr std::uint64_t kMaximumPreload = 600;  ///< 1.5 MB each.

Error badKey(std::string_view key, std::string_view value) {
    return {.code = ErrorCode::invalidInput,
            .cause = "\"" + std::string(value) + "\" will not do for the simulated sensor",
            .mend = "use seed, visit_s, pause_s, fps, noise, colour, start_ns and preload with numbers",
            .key = std::string(key)};
}

template <typename Number>
bool toNumber(std::string_view text, Number& value) {
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    return fault == std::errc() && end == text.data() + text.size() && value >= Number{};
}

bool toFlag(std::string_view text, bool& value) {
    value = text == "1";
    return text == "1" || text == "0";
}

bool apply(std::string_view key, std::string_view value, SensorSpec& spec) {
    if (key == "preload") return toNumber(value, spec.preload) && spec.preload <= kMaximumPreload;
    if (!spec.folder.empty()) return false;
    if (key == "seed") return toNumber(value, spec.world.seed);
    if (key == "visit_s") return toNumber(value, spec.world.visitSeconds) && spec.world.visitSeconds >= 5.0;
    if (key == "pause_s") return toNumber(value, spec.world.pauseSeconds);
    if (key == "fps") return toNumber(value, spec.world.framesPerSecond) && spec.world.framesPerSecond > 0.0;
    if (key == "noise") return toFlag(value, spec.world.sensorNoise);
    if (key == "colour") return toFlag(value, spec.world.colour);
    if (key == "start_ns") return toNumber(value, spec.startNs);
    return false;
}

/// Another camera's first frames, kept and played over and over at its rate.
class PreloadedCamera final : public DepthCamera {
  public:
    PreloadedCamera(const CameraInfo& info, TimePoint zero, Clock& clock) : info_(info), zero_(zero), clock_(clock) {}
    ~PreloadedCamera() override { close(); }
    PreloadedCamera(const PreloadedCamera&) = delete;
    PreloadedCamera& operator=(const PreloadedCamera&) = delete;

    void keep(const DepthFrame& frame) {
        copyInto(frame.depth, pictures_.emplace_back().depth);
        copyInto(frame.colour, pictures_.back().colour);
    }

  protected:
    Expected<CameraInfo> doOpen() override {
        if (pictures_.empty()) return Error{.code = ErrorCode::notFound, .cause = "there was nothing to preload"};
        const TimePoint now = clock_.now();
        start_ = zero_ == TimePoint{} ? now : zero_;
        next_ = static_cast<std::uint64_t>(std::max(0.0, seconds(now - start_)) * info_.framesPerSecond);
        return info_;
    }
    void doClose() override {}
    FrameStatus doWaitFrame(Duration timeout, DepthFrame& frame, Interrupt& interrupt) override {
        const TimePoint now = clock_.now();
        // As a live sensor: what nobody waited for is lost.
        while (dueTime(next_ + 1) <= now)
            ++next_;
        const TimePoint due = dueTime(next_);
        if (due > now + timeout)
            return clock_.waitUntil(now + timeout, interrupt) ? FrameStatus::timedOut : FrameStatus::closed;
        if (!clock_.waitUntil(due, interrupt)) return FrameStatus::closed;
        const Picture& picture = pictures_[next_ % pictures_.size()];
        frame = {.sequence = next_,
                 .sourceIndex = next_,
                 .captureTime = due,
                 .restart = next_ == 0,
                 .lastOfStill = true,
                 .intrinsics = info_.intrinsics,
                 .depth = picture.depth.view(),
                 .colour = picture.colour.view()};
        ++next_;
        return FrameStatus::frame;
    }

  private:
    struct Picture {
        Image<std::uint16_t> depth;
        Image<Rgb8> colour;
    };
    [[nodiscard]] TimePoint dueTime(std::uint64_t frame) const {
        return start_ + fromSeconds(static_cast<double>(frame) / info_.framesPerSecond);
    }

    CameraInfo info_;
    TimePoint zero_;  ///< Of frame 0; its own zero: when it is opened.
    Clock& clock_;
    std::vector<Picture> pictures_;
    TimePoint start_{};
    std::uint64_t next_ = 0;
};

Expected<std::unique_ptr<DepthCamera>> makePlain(const SensorSpec& spec, std::shared_ptr<World>& world, Clock& clock) {
    if (!spec.folder.empty()) {
        auto camera = makeReplayCamera({.folder = spec.folder, .loop = true}, clock);
        if (!camera) return std::move(camera).error();
        return std::unique_ptr<DepthCamera>(std::move(*camera));
    }
    if (world == nullptr) {
        world = makeWorld(spec.world);
        if (spec.startNs > 0) world->startAt(TimePoint(Duration(spec.startNs)));
    }
    return makeSimulatedCamera(world, clock);
}

}  // namespace

Expected<SensorSpec> parseSensorSpec(std::string_view text) {
    SensorSpec spec;
    constexpr std::string_view kWorld = "sim:";
    constexpr std::string_view kFolder = "folder:";
    if (text.starts_with(kFolder)) {
        text.remove_prefix(kFolder.size());
        const std::size_t comma = text.find(",preload=");
        spec.folder = std::string(text.substr(0, comma));
        text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
        if (spec.folder.empty()) return badKey("folder", "");
    } else if (text.starts_with(kWorld)) {
        text.remove_prefix(kWorld.size());
    } else {
        return badKey("", text);
    }
    while (!text.empty()) {
        const std::string_view part = text.substr(0, text.find(','));
        text.remove_prefix(std::min(text.size(), part.size() + 1));
        const std::size_t equals = std::min(part.find('='), part.size());
        const std::string_view key = part.substr(0, equals);
        const std::string_view value = part.substr(std::min(part.size(), equals + 1));
        if (!apply(key, value, spec)) return badKey(key, value);
    }
    return spec;
}

Expected<std::unique_ptr<DepthCamera>> makeSpecCamera(const SensorSpec& spec, std::shared_ptr<World>& world,
                                                      Clock& clock) {
    if (spec.preload == 0) return makePlain(spec, world, clock);
    VirtualClock virtualClock;
    std::shared_ptr<World> own;
    SensorSpec fromItsStart = spec;
    fromItsStart.startNs = 0;
    auto source = makePlain(fromItsStart, own, virtualClock);
    if (!source) return source;
    if (auto opened = (*source)->open(); !opened) return std::move(opened).error();
    auto preloaded = std::make_unique<PreloadedCamera>((*source)->info(), TimePoint(Duration(spec.startNs)), clock);
    DepthFrame frame;
    for (std::uint64_t i = 0;
         i < spec.preload && (*source)->waitFrame(std::chrono::hours(1), frame) == FrameStatus::frame; ++i)
        preloaded->keep(frame);
    return std::unique_ptr<DepthCamera>(std::move(preloaded));
}

}  // namespace cheval::hal::sim

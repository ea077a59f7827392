#include "hal/replay/replay_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "hal/png/png.h"
#include "hal/replay/recording.h"
#include "hal/replay/sensor_json.h"

namespace cheval::hal {

namespace {

constexpr std::size_t kMaxWarnings = 64;
constexpr double kStillFramesPerSecond = 30.0;
constexpr PngLimits kLimits{};
constexpr std::size_t kMaxSensorJson = std::size_t{1} << 16;

std::string pathOf(const std::string& folder, const std::string& name) {
    return (std::filesystem::path(folder) / name).string();
}

// Millimetres of every possible reading; empty when the unit is the millimetre. What lies beyond 16 bits saturates.
std::vector<std::uint16_t> millimetreTable(double unitMm) {
    if (unitMm == 1.0) return {};
    std::vector<std::uint16_t> table(std::size_t{1} << 16);
    for (std::size_t raw = 0; raw < table.size(); ++raw) {
        table[raw] = static_cast<std::uint16_t>(std::min(65535.0, std::round(static_cast<double>(raw) * unitMm)));
    }
    return table;
}

Expected<void> checkSize(int width, int height, const Intrinsics& intrinsics) {
    if (width == intrinsics.width && height == intrinsics.height) return {};
    return Error{.code = ErrorCode::invalidInput,
                 .cause = "the picture has " + std::to_string(width) + " by " + std::to_string(height) + " pixels",
                 .mend = "use pictures of " + std::to_string(intrinsics.width) + " by " +
                         std::to_string(intrinsics.height) + ", or correct width and height in sensor.json",
                 .why = "the intrinsics in sensor.json hold for one size only"};
}

class FolderCamera final : public ReplayCamera {
  public:
    FolderCamera(const ReplayOptions& options, Clock& clock, const SensorDescription& sensor, Recording recording)
        : options_(options),
          clock_(clock),
          sensor_(sensor),
          pictures_(std::move(recording.pictures)),
          framesPerSecond_(sensor.independent ? kStillFramesPerSecond : sensor.framesPerSecond),
          millimetres_(millimetreTable(sensor.depthUnitMm)) {
        for (std::string& warning : recording.warnings)
            warn(std::move(warning));
        for (const RecordedPicture& picture : pictures_) {
            longestPath_ = std::max({longestPath_, picture.depth.size(), picture.colour.size()});
        }
    }

    ~FolderCamera() override { close(); }
    FolderCamera(const FolderCamera&) = delete;
    FolderCamera& operator=(const FolderCamera&) = delete;

    [[nodiscard]] std::size_t pictureCount() const override { return pictures_.size(); }
    [[nodiscard]] const std::string& pictureName(std::size_t sourceIndex) const override {
        return pictures_.at(sourceIndex).depth;
    }
    [[nodiscard]] std::vector<std::string> warnings() const override {
        std::vector<std::string> all = warnings_;
        if (moreWarnings_ > 0) all.push_back(std::to_string(moreWarnings_) + " more warning(s)");
        return all;
    }

    /// Memory that the largest file will need, taken before the first frame.
    void reserve() {
        std::uintmax_t largest = 0;
        for (const RecordedPicture& picture : pictures_) {
            for (const std::string* name : {&picture.depth, &picture.colour}) {
                std::error_code code;
                const std::uintmax_t size = std::filesystem::file_size(pathOf(options_.folder, *name), code);
                if (!name->empty() && !code) largest = std::max(largest, size);
            }
        }
        file_.reserve(static_cast<std::size_t>(std::min<std::uintmax_t>(largest, kLimits.maxFileBytes)));
        path_.reserve(options_.folder.size() + 1 + longestPath_);
        depth_.resize(sensor_.intrinsics.width, sensor_.intrinsics.height);
        if (hasAnyColour()) colour_.resize(sensor_.intrinsics.width, sensor_.intrinsics.height);
    }

  protected:
    Expected<CameraInfo> doOpen() override {
        start_ = clock_.now();
        position_ = 0;
        repetition_ = 0;
        passTicks_ = 0;
        unusable_ = 0;
        vanished_ = false;
        fresh_ = true;
        return CameraInfo{.name = "replay of " + std::filesystem::path(options_.folder).lexically_normal().string(),
                          .intrinsics = sensor_.intrinsics,
                          .framesPerSecond = framesPerSecond_,
                          .mount = sensor_.mount,
                          .colour = hasAnyColour(),
                          .independent = sensor_.independent};
    }

    void doClose() override {}

    FrameStatus doWaitFrame(Duration timeout, DepthFrame& frame, Interrupt& interrupt) override {
        const TimePoint begin = clock_.now();
        while (true) {
            if (interrupt.raised()) return FrameStatus::closed;
            if (vanished_ || unusable_ >= pictures_.size()) return FrameStatus::lost;
            if (position_ == pictures_.size()) {
                if (!options_.loop) return FrameStatus::ended;
                beginNextPass();
            }
            const std::uint64_t tick = currentTick();
            const TimePoint due = start_ + sinceStart(tick);
            if (due - begin > std::max(timeout, Duration::zero())) {
                const bool reached = clock_.waitUntil(begin + std::max(timeout, Duration::zero()), interrupt);
                return reached ? FrameStatus::timedOut : FrameStatus::closed;
            }
            if (!clock_.waitUntil(due, interrupt)) return FrameStatus::closed;
            if (repetition_ == 0 && !load()) {
                ++unusable_;
                ++position_;
                continue;
            }
            deliver(frame, tick, due);
            advance();
            return FrameStatus::frame;
        }
    }

  private:
    [[nodiscard]] std::uint64_t repeats() const {
        return sensor_.independent ? static_cast<std::uint64_t>(std::max(1, options_.stillRepeats)) : 1;
    }
    [[nodiscard]] bool hasAnyColour() const {
        return std::any_of(pictures_.begin(), pictures_.end(),
                           [](const RecordedPicture& picture) { return !picture.colour.empty(); });
    }
    // Place in time of the frame that comes next, from open() on.
    [[nodiscard]] std::uint64_t currentTick() const {
        return passTicks_ + pictures_[position_].tick * repeats() + repetition_;
    }
    // From the count and not from the frame before, so that rounding does not add up over hours.
    [[nodiscard]] Duration sinceStart(std::uint64_t tick) const {
        return fromSeconds(static_cast<double>(tick) / framesPerSecond_);
    }

    void beginNextPass() {
        passTicks_ += (pictures_.back().tick + 1) * repeats();
        position_ = 0;
        fresh_ = true;
    }

    void advance() {
        fresh_ = false;
        unusable_ = 0;
        if (++repetition_ < repeats()) return;
        repetition_ = 0;
        ++position_;
    }

    void deliver(DepthFrame& frame, std::uint64_t tick, TimePoint due) {
        frame.sequence = tick;
        frame.sourceIndex = position_;
        frame.captureTime = due;
        frame.restart = fresh_ || (sensor_.independent && repetition_ == 0);
        frame.lastOfStill = repetition_ + 1 == repeats();
        frame.intrinsics = sensor_.intrinsics;
        frame.depth = std::as_const(depth_).view();
        frame.colour = hasColour_ ? std::as_const(colour_).view() : ImageView<const Rgb8>{};
    }

    // Decodes the current picture. False: it cannot be used, and a warning says why.
    bool load() {
        const RecordedPicture& picture = pictures_[position_];
        if (auto done = loadDepth(picture.depth); !done) {
            // It was there when the camera was made, so the recording itself is going.
            vanished_ = done.error().code == ErrorCode::notFound;
            warn(done.error().message() + (vanished_ ? "" : ". The frame is left out"));
            return false;
        }
        hasColour_ = false;
        if (picture.colour.empty()) return true;
        if (auto done = loadInto(picture.colour, colour_); !done) {
            warn(done.error().message() + ". The frame is played without colour");
            return true;
        }
        hasColour_ = true;
        return true;
    }

    Expected<void> loadDepth(const std::string& name) {
        if (auto done = loadInto(name, depth_); !done) return done;
        if (millimetres_.empty()) return {};
        for (std::uint16_t& reading : depth_.pixels)
            reading = millimetres_[reading];
        return {};
    }

    template <typename Pixel>
    Expected<void> loadInto(const std::string& name, Image<Pixel>& image) {
        path_.assign(options_.folder).append("/").append(name);
        if (auto done = readBytes(path_, kLimits.maxFileBytes, file_); !done) return done;
        auto done = decodeInto(image);
        if (!done) done.error().file = path_;
        return done;
    }

    // The size is checked by the header, so that a picture of another size never takes memory.
    template <typename Pixel>
    Expected<void> decodeInto(Image<Pixel>& image) {
        const auto info = inspectPng(file_, kLimits);
        if (!info) return info.error();
        if (auto done = checkSize(info->width, info->height, sensor_.intrinsics); !done) return done;
        return decodePng(file_, image, kLimits);
    }

    void warn(std::string warning) {
        // A recording that loops meets the same fault again and again.
        if (std::find(warnings_.begin(), warnings_.end(), warning) != warnings_.end()) return;
        if (warnings_.size() < kMaxWarnings) {
            warnings_.push_back(std::move(warning));
        } else {
            ++moreWarnings_;
        }
    }

    ReplayOptions options_;
    Clock& clock_;
    SensorDescription sensor_;
    std::vector<RecordedPicture> pictures_;
    double framesPerSecond_;
    std::vector<std::uint16_t> millimetres_;
    std::vector<std::string> warnings_;
    std::uint64_t moreWarnings_ = 0;
    std::size_t longestPath_ = 0;

    TimePoint start_{};
    std::size_t position_ = 0;      // Of the next picture.
    std::uint64_t repetition_ = 0;  // Of the next frame, within its still.
    std::uint64_t passTicks_ = 0;   // Ticks of the passes that are over, when it loops.
    std::size_t unusable_ = 0;      // Pictures in a row that could not be used.
    bool vanished_ = false;         // A file that was listed is not there any more.
    bool fresh_ = true;             // The next frame follows none.

    std::vector<std::byte> file_;
    std::string path_;
    Image<std::uint16_t> depth_;
    Image<Rgb8> colour_;
    bool hasColour_ = false;
};

Expected<SensorDescription> readSensorJson(const std::string& folder) {
    const std::string path = pathOf(folder, "sensor.json");
    std::vector<std::byte> bytes;
    if (auto done = readBytes(path, kMaxSensorJson, bytes); !done) {
        if (done.error().code == ErrorCode::notFound) {
            return Error{.code = ErrorCode::notFound,
                         .cause = "the recording has no sensor.json",
                         .mend = "add one with width, height, fx, fy, cx, cy, depth_unit_mm and fps",
                         .why = "depth means nothing without the camera's intrinsics and unit",
                         .file = path};
        }
        return std::move(done).error();
    }
    return parseSensorJson({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path);
}

Expected<void> checkFirst(const std::string& path, const Intrinsics& intrinsics) {
    const auto info = inspectPngFile(path);
    if (!info) return info.error();
    auto done = checkSize(info->width, info->height, intrinsics);
    if (done && !info->isGrey16()) {
        done = Error{.code = ErrorCode::invalidInput,
                     .cause = "the picture has " + std::to_string(info->bitDepth) +
                              " bits a channel, PNG colour type " + std::to_string(info->colourType),
                     .mend = "write depth as 16-bit grey PNG",
                     .why = "fewer bits cannot hold millimetres, and colours are not depth"};
    }
    if (!done) done.error().file = path;
    return done;
}

}  // namespace

Expected<std::unique_ptr<ReplayCamera>> makeReplayCamera(const ReplayOptions& options, Clock& clock) {
    const auto names = listFolder(options.folder);
    if (!names) return names.error();
    const auto sensor = readSensorJson(options.folder);
    if (!sensor) return sensor.error();
    Recording recording = arrangeRecording(*names, sensor->independent);
    if (recording.pictures.empty()) {
        return Error{.code = ErrorCode::notFound,
                     .cause = "the folder holds no depth pictures",
                     .mend = "put 16-bit grey PNGs named depth-0000.png … into it",
                     .why = "mask-*, color-* and colour-* are not depth",
                     .file = options.folder};
    }
    const std::string first = pathOf(options.folder, recording.pictures.front().depth);
    if (auto done = checkFirst(first, sensor->intrinsics); !done) return std::move(done).error();
    auto camera = std::make_unique<FolderCamera>(options, clock, *sensor, std::move(recording));
    camera->reserve();
    return std::unique_ptr<ReplayCamera>(std::move(camera));
}

}  // namespace cheval::hal

#include "hal/openni/openni_camera.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <OpenNI.h>

#include "hal/openni/device_clock.h"
#include "hal/openni/profile.h"

namespace cheval::hal {

namespace {

using std::chrono::milliseconds;

constexpr int kSliceMs = 20;  ///< One wait for the runtime; between two, close() and a lost device are looked for.
/// How much older than its depth a colour picture may be and still be shown with it.
constexpr Duration kOldestColour = milliseconds(100);
/// Waited for the colour picture of a depth picture; both are on their way at once.
constexpr Duration kColourGrace = milliseconds(12);
constexpr int kDepthStream = 0;
constexpr int kColourStream = 1;

constexpr const char* kCheckCable = "check the sensor's cable and its power; it is reopened by itself";

Error openNiError(std::string attempt, const char* mend = kCheckCable) {
    // Several lines, indented: one line of it all.
    std::string said;
    for (const char letter : std::string_view(openni::OpenNI::getExtendedError())) {
        const bool blank = letter == '\n' || letter == '\t' || letter == ' ';
        if (!blank) said += letter;
        if (blank && !said.empty() && said.back() != ' ') said += ' ';
    }
    if (said.ends_with(' ')) said.pop_back();
    return {
        .code = ErrorCode::unavailable, .cause = std::move(attempt) + (said.empty() ? "" : ": " + said), .mend = mend};
}

/// Devices that come and go, told by the runtime's own threads. Thread-safe.
class DeviceListener final : public openni::OpenNI::DeviceConnectedListener,
                             public openni::OpenNI::DeviceDisconnectedListener {
  public:
    void onDeviceConnected(const openni::DeviceInfo* /*info*/) override { arrived_ = true; }
    void onDeviceDisconnected(const openni::DeviceInfo* info) override {
        const std::lock_guard lock(mutex_);
        if (uri_ == info->getUri()) left_ = true;
    }
    /// Whose leaving counts.
    void watch(const char* uri) {
        const std::lock_guard lock(mutex_);
        uri_ = uri;
        left_ = false;
    }
    bool takeArrival() { return arrived_.exchange(false); }
    bool takeDeparture() { return left_.exchange(false); }

  private:
    std::atomic<bool> arrived_{false};
    std::atomic<bool> left_{false};
    std::mutex mutex_;
    std::string uri_;
};

Duration stampOf(const openni::VideoFrameRef& frame) {
    return std::chrono::microseconds(frame.getTimestamp());
}

/// Copies rows out of a frame, each pixel `enlarge` times both ways.
template <typename Pixel, typename Convert>
void copyPixels(const openni::VideoFrameRef& frame, int enlarge, Image<Pixel>& to, Convert convert) {
    to.width = frame.getWidth() * enlarge;
    to.height = frame.getHeight() * enlarge;
    to.pixels.resize(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height));
    const auto* rows = static_cast<const std::byte*>(frame.getData());
    for (int y = 0; y < to.height; ++y) {
        const auto* row = reinterpret_cast<const Pixel*>(rows + std::ptrdiff_t{y / enlarge} * frame.getStrideInBytes());
        Pixel* out = to.pixels.data() + std::ptrdiff_t{y} * to.width;
        for (int x = 0; x < to.width; ++x)
            out[x] = convert(row[x / enlarge]);
    }
}

/// The size that the frame says, against what it holds: a device may send anything.
template <typename Pixel>
bool holdsItsPixels(const openni::VideoFrameRef& frame) {
    const int width = frame.getWidth();
    const int height = frame.getHeight();
    const int stride = frame.getStrideInBytes();
    if (width <= 0 || height <= 0 || frame.getData() == nullptr || stride % int{alignof(Pixel)} != 0) return false;
    const std::int64_t rowBytes = std::int64_t{width} * std::int64_t{sizeof(Pixel)};
    return stride >= rowBytes && frame.getDataSize() >= std::int64_t{stride} * (height - 1) + rowBytes;
}

class OpenNiCameraImplementation final : public OpenNiCamera {
  public:
    explicit OpenNiCameraImplementation(const OpenNiOptions& options) : options_(options) {
        openni::OpenNI::addDeviceConnectedListener(&listener_);
        openni::OpenNI::addDeviceDisconnectedListener(&listener_);
    }
    ~OpenNiCameraImplementation() override {
        close();
        openni::OpenNI::removeDeviceConnectedListener(&listener_);
        openni::OpenNI::removeDeviceDisconnectedListener(&listener_);
        openni::OpenNI::shutdown();
    }
    OpenNiCameraImplementation(const OpenNiCameraImplementation&) = delete;
    OpenNiCameraImplementation& operator=(const OpenNiCameraImplementation&) = delete;

    [[nodiscard]] const std::string& compromises() const override { return compromises_; }
    [[nodiscard]] std::optional<Error> lossReason() const override { return loss_; }

  protected:
    bool doTakeArrival() override { return listener_.takeArrival(); }

    Expected<CameraInfo> doOpen() override {
        loss_.reset();
        compromises_.clear();
        const std::string& uri = recorded() ? options_.recording : options_.device;
        if (device_.open(uri.empty() ? openni::ANY_DEVICE : uri.c_str()) != openni::STATUS_OK) {
            Error error =
                recorded()
                    ? openNiError("the recording cannot be opened", "name an .oni file of OpenNI 2")
                    : openNiError("no depth sensor could be opened",
                                  "check the sensor's cable and its power, and that OpenNI2 has a driver for it; it is "
                                  "opened again by itself");
            if (recorded()) error.file = uri;
            return error;
        }
        listener_.watch(device_.getDeviceInfo().getUri());
        Expected<CameraInfo> info = startStreams();
        if (!info) doClose();
        return info;
    }

    void doClose() override {
        // In this order: a stream that outlives its device is what hangs.
        for (openni::VideoFrameRef* frame : {&depthFrame_, &colourFrame_})
            frame->release();
        for (openni::VideoStream* stream : {&colour_, &depth_}) {
            if (!stream->isValid()) continue;
            stream->stop();
            stream->destroy();
        }
        device_.close();
    }

    Expected<void> doRestartStream() override {
        depth_.stop();
        if (colour_.isValid()) colour_.stop();
        // What was on its way belongs to before.
        depthWaits_ = false;
        depthFrame_.release();
        colourFrame_.release();
        clock_.reset();
        fresh_ = true;
        return start();
    }

    FrameStatus doWaitFrame(Duration timeout, DepthFrame& frame, Interrupt& interrupt) override {
        if (recorded() && delivered_ >= recordedFrames_) return FrameStatus::ended;
        const TimePoint limit = steady_.now() + std::max(timeout, Duration::zero());
        while (true) {
            if (interrupt.raised()) return FrameStatus::closed;
            if (!recorded() && listener_.takeDeparture()) {
                loss_ = Error{.code = ErrorCode::unavailable, .cause = "the sensor was unplugged", .mend = kCheckCable};
                return FrameStatus::lost;
            }
            const TimePoint now = steady_.now();
            if (depthWaits_ && (colourFits() || now >= colourLimit_)) {
                // The header may promise more frames than there are; then the player begins again.
                if (recorded() && delivered_ > 0 && stampOf(depthFrame_) <= lastStamp_) {
                    recordedFrames_ = delivered_;
                    return FrameStatus::ended;
                }
                return deliver(frame);
            }
            if (now >= limit) return FrameStatus::timedOut;
            const Duration left = (depthWaits_ ? std::min(limit, colourLimit_) : limit) - now;
            std::array<openni::VideoStream*, 2> streams = {&depth_, &colour_};
            int ready = -1;
            const auto wait = std::clamp<std::int64_t>(std::chrono::ceil<milliseconds>(left).count(), 0, kSliceMs);
            const openni::Status status = openni::OpenNI::waitForAnyStream(streams.data(), colour_.isValid() ? 2 : 1,
                                                                           &ready, static_cast<int>(wait));
            if (status == openni::STATUS_TIME_OUT) continue;
            if (status != openni::STATUS_OK) return lose("waiting for the sensor's pictures failed");
            if (!read(ready)) return FrameStatus::lost;
        }
    }

  private:
    [[nodiscard]] bool recorded() const { return !options_.recording.empty(); }

    FrameStatus lose(const char* attempt) {
        loss_ = openNiError(attempt);
        return FrameStatus::lost;
    }

    Expected<CameraInfo> startStreams() {
        if (depth_.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK)
            return openNiError("the sensor has no depth stream");
        Expected<void> chosen = chooseMode();
        if (!chosen) return std::move(chosen).error();
        depth_.setMirroringEnabled(false);
        startColour();
        if (recorded()) {
            openni::PlaybackControl* playback = device_.getPlaybackControl();
            if (playback == nullptr) return openNiError("the recording cannot be played", "name an .oni file");
            // Without repeat, and at speeds other than "as it is read", the player spins or crashes at the end.
            playback->setRepeatEnabled(true);
            playback->setSpeed(-1.0F);
            recordedFrames_ = static_cast<std::uint64_t>(std::max(0, playback->getNumberOfFrames(depth_)));
        }
        delivered_ = 0;
        anySequence_ = false;
        sequenceOffset_ = 0;
        depthWaits_ = false;
        fresh_ = true;
        clock_.reset();
        Expected<void> started = start();
        if (!started) return std::move(started).error();
        return describe();
    }

    Expected<void> start() {
        if (depth_.start() != openni::STATUS_OK) return openNiError("the sensor's depth stream does not start");
        if (colour_.isValid() && colour_.start() != openni::STATUS_OK) giveUpColour("colour does not start");
        return {};
    }

    /// Live, the ladder's choice; a recording is as it is.
    Expected<void> chooseMode() {
        openni::VideoMode mode = depth_.getVideoMode();
        if (!recorded()) {
            const openni::Array<openni::VideoMode>& offered = depth_.getSensorInfo().getSupportedVideoModes();
            std::vector<DepthMode> modes(static_cast<std::size_t>(offered.getSize()));
            for (int i = 0; i < offered.getSize(); ++i) {
                const openni::PixelFormat format = offered[i].getPixelFormat();
                if (format != openni::PIXEL_FORMAT_DEPTH_1_MM && format != openni::PIXEL_FORMAT_DEPTH_100_UM) continue;
                modes[static_cast<std::size_t>(i)] = {.width = offered[i].getResolutionX(),
                                                      .height = offered[i].getResolutionY(),
                                                      .framesPerSecond = offered[i].getFps(),
                                                      .tenths = format == openni::PIXEL_FORMAT_DEPTH_100_UM};
            }
            const std::optional<DepthProfile> profile = chooseProfile(modes);
            if (!profile) {
                return Error{.code = ErrorCode::unavailable,
                             .cause = "the sensor offers none of the " + std::to_string(modes.size()) +
                                      " modes that can be used",
                             .mend =
                                 "use a sensor that offers depth of 640×480 or 320×240 pixels, 15 times a second "
                                 "or more"};
            }
            mode = offered[static_cast<int>(profile->mode)];
            enlarge_ = profile->enlarge;
            if (depth_.setVideoMode(mode) != openni::STATUS_OK)
                return openNiError("the sensor refuses the mode that it offers");
            if (enlarge_ > 1) compromise("depth of 320×240, doubled");
        } else {
            enlarge_ = mode.getResolutionX() == 320 && mode.getResolutionY() == 240 ? 2 : 1;
        }
        tenths_ = mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM;
        if (!tenths_ && mode.getPixelFormat() != openni::PIXEL_FORMAT_DEPTH_1_MM) {
            return Error{.code = ErrorCode::invalidInput,
                         .cause = "the depth is neither in millimetres nor in tenths of them",
                         .mend = "record depth as DEPTH_1_MM or DEPTH_100_UM"};
        }
        mode_ = mode;
        return {};
    }

    void compromise(std::string_view what) {
        if (!compromises_.empty()) compromises_ += ", ";
        compromises_ += what;
    }

    void giveUpColour(std::string_view why) {
        if (colour_.isValid()) colour_.destroy();
        compromise(why);
    }

    /// Colour that is registered to depth, of depth's size; without it the mirror shows shaded depth.
    void startColour() {
        if (!options_.colour) return;
        if (!device_.hasSensor(openni::SENSOR_COLOR) ||
            colour_.create(device_, openni::SENSOR_COLOR) != openni::STATUS_OK)
            return compromise("no colour");
        if (recorded()) {
            // Registered or not is how it was recorded, which the file does not say.
            const openni::VideoMode has = colour_.getVideoMode();
            if (has.getResolutionX() != mode_.getResolutionX() || has.getResolutionY() != mode_.getResolutionY() ||
                has.getPixelFormat() != openni::PIXEL_FORMAT_RGB888)
                giveUpColour("colour of another size or format than depth");
            return;
        }
        const openni::Array<openni::VideoMode>& offered = colour_.getSensorInfo().getSupportedVideoModes();
        bool set = false;
        for (int i = 0; i < offered.getSize() && !set; ++i) {
            const openni::VideoMode& candidate = offered[i];
            set = candidate.getResolutionX() == mode_.getResolutionX() &&
                  candidate.getResolutionY() == mode_.getResolutionY() &&
                  candidate.getPixelFormat() == openni::PIXEL_FORMAT_RGB888 && candidate.getFps() == mode_.getFps() &&
                  colour_.setVideoMode(candidate) == openni::STATUS_OK;
        }
        if (!set) return giveUpColour("no colour of depth's size");
        if (!device_.isImageRegistrationModeSupported(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR) ||
            device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR) != openni::STATUS_OK)
            return giveUpColour("no registration of depth and colour");
        colour_.setMirroringEnabled(false);
        // Pictures that belong together are found by their times: the runtime's own pairing (setDepthColorSyncEnabled)
        // may stay one frame apart for good, and swaps frames while they are in use.
    }

    CameraInfo describe() {
        const int width = mode_.getResolutionX() * enlarge_;
        const int height = mode_.getResolutionY() * enlarge_;
        intrinsics_ = {.width = width,
                       .height = height,
                       .fx = static_cast<float>(width / (2.0 * std::tan(depth_.getHorizontalFieldOfView() / 2.0))),
                       .fy = static_cast<float>(height / (2.0 * std::tan(depth_.getVerticalFieldOfView() / 2.0))),
                       .cx = static_cast<float>(width - 1) / 2.0F,
                       .cy = static_cast<float>(height - 1) / 2.0F};
        std::string name = options_.recording;
        if (!recorded()) {
            const openni::DeviceInfo& device = device_.getDeviceInfo();
            name = std::string(device.getVendor()) + " " + device.getName();
        }
        if (!compromises_.empty()) name += " (" + compromises_ + ")";
        return {.name = std::move(name),
                .intrinsics = intrinsics_,
                .framesPerSecond = mode_.getFps() > 0 ? mode_.getFps() : 30.0,
                .colour = colour_.isValid()};
    }

    /// Takes in what is ready. False: the device is lost.
    bool read(int stream) {
        openni::VideoStream& from = stream == kColourStream ? colour_ : depth_;
        openni::VideoFrameRef& to = stream == kColourStream ? colourFrame_ : depthFrame_;
        // A stream that waitForAnyStream names has a frame: this call does not wait.
        if (from.readFrame(&to) != openni::STATUS_OK) {
            lose("the sensor's picture could not be read");
            return false;
        }
        if (stream == kColourStream) {
            const bool sound = holdsItsPixels<openni::RGB888Pixel>(to) && to.getWidth() == mode_.getResolutionX() &&
                               to.getHeight() == mode_.getResolutionY();
            if (!sound) to.release();
            return true;
        }
        if (!holdsItsPixels<openni::DepthPixel>(to) || to.getWidth() != mode_.getResolutionX() ||
            to.getHeight() != mode_.getResolutionY()) {
            to.release();  // Not a picture of this mode: passed over, as one that was lost on the way.
            return true;
        }
        depthWaits_ = true;
        arrival_ = steady_.now();
        colourLimit_ = arrival_ + (colour_.isValid() ? kColourGrace : Duration::zero());
        return true;
    }

    /// The colour that is there belongs to the depth that waits.
    [[nodiscard]] bool colourFits() const {
        if (!colour_.isValid()) return true;
        if (!colourFrame_.isValid()) return false;
        const Duration half = hal::fromSeconds(0.5 / std::max(1, mode_.getFps()));
        return stampOf(colourFrame_) + half > stampOf(depthFrame_);
    }

    /// The device's own count, which goes on where a restarted stream counts from the beginning.
    std::uint64_t nextSequence() {
        const auto index = static_cast<std::uint64_t>(std::max(0, depthFrame_.getFrameIndex()));
        if (anySequence_ && index + sequenceOffset_ <= lastSequence_) sequenceOffset_ = lastSequence_ + 1 - index;
        anySequence_ = true;
        lastSequence_ = index + sequenceOffset_;
        return lastSequence_;
    }

    FrameStatus deliver(DepthFrame& frame) {
        depthWaits_ = false;
        const Duration stamp = stampOf(depthFrame_);
        if (recorded() && delivered_ == 0) firstStamp_ = stamp;
        lastStamp_ = stamp;
        frame =
            DepthFrame{.sequence = recorded() ? delivered_ : nextSequence(),
                       .captureTime = recorded() ? TimePoint(stamp - firstStamp_) : clock_.captureTime(stamp, arrival_),
                       .restart = std::exchange(fresh_, false),
                       .lastOfStill = true,
                       .intrinsics = intrinsics_};
        frame.sourceIndex = frame.sequence;
        const int width = depthFrame_.getWidth();
        const int height = depthFrame_.getHeight();
        if (enlarge_ == 1 && !tenths_ && depthFrame_.getStrideInBytes() % 2 == 0) {
            frame.depth = {static_cast<const std::uint16_t*>(depthFrame_.getData()), width, height,
                           depthFrame_.getStrideInBytes() / 2};
        } else {
            const std::uint16_t unit = tenths_ ? 10 : 1;
            copyPixels(depthFrame_, enlarge_, depthImage_, [unit](std::uint16_t reading) {
                return static_cast<std::uint16_t>((reading + unit / 2) / unit);
            });
            frame.depth = std::as_const(depthImage_).view();
        }
        const bool current = colourFrame_.isValid() && stampOf(colourFrame_) + kOldestColour > stamp;
        if (colour_.isValid() && current) deliverColour(frame);
        ++delivered_;
        return FrameStatus::frame;
    }

    void deliverColour(DepthFrame& frame) {
        static_assert(sizeof(Rgb8) == sizeof(openni::RGB888Pixel));
        if (enlarge_ == 1 && colourFrame_.getStrideInBytes() % static_cast<int>(sizeof(Rgb8)) == 0) {
            frame.colour = {static_cast<const Rgb8*>(colourFrame_.getData()), colourFrame_.getWidth(),
                            colourFrame_.getHeight(),
                            colourFrame_.getStrideInBytes() / static_cast<std::ptrdiff_t>(sizeof(Rgb8))};
            return;
        }
        copyPixels(colourFrame_, enlarge_, colourImage_, [](Rgb8 pixel) { return pixel; });
        frame.colour = std::as_const(colourImage_).view();
    }

    OpenNiOptions options_;
    SteadyClock steady_;
    DeviceListener listener_;
    openni::Device device_;
    openni::VideoStream depth_;
    openni::VideoStream colour_;
    openni::VideoMode mode_;
    int enlarge_ = 1;
    bool tenths_ = false;
    Intrinsics intrinsics_;
    std::string compromises_;
    std::optional<Error> loss_;

    openni::VideoFrameRef depthFrame_;
    openni::VideoFrameRef colourFrame_;
    bool depthWaits_ = false;  ///< depthFrame_ is not delivered yet; its colour may still come.
    TimePoint arrival_{};
    TimePoint colourLimit_{};
    DeviceClock clock_;
    bool fresh_ = true;
    std::uint64_t delivered_ = 0;
    std::uint64_t lastSequence_ = 0;
    std::uint64_t sequenceOffset_ = 0;
    bool anySequence_ = false;
    std::uint64_t recordedFrames_ = 0;
    Duration firstStamp_{};
    Duration lastStamp_{};
    Image<std::uint16_t> depthImage_;
    Image<Rgb8> colourImage_;
};

}  // namespace

Expected<std::unique_ptr<OpenNiCamera>> makeOpenNiCamera(const OpenNiOptions& options) {
    if (openni::OpenNI::initialize() != openni::STATUS_OK)
        return openNiError("OpenNI2 does not start", "install libopenni2-0; see OpenNI.ini for its drivers");
    return std::unique_ptr<OpenNiCamera>(std::make_unique<OpenNiCameraImplementation>(options));
}

}  // namespace cheval::hal

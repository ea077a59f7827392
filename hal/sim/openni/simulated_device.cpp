#include "hal/sim/openni/simulated_device.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "hal/sim/hash.h"

namespace cheval::hal::sim {

namespace {

using std::chrono::milliseconds;

constexpr Duration kWait = milliseconds(50);
constexpr int kMaxValueMm = 10'000;
constexpr std::uint32_t kNoiseKey = 0x5eed;

template <typename Value>
OniStatus give(void* data, int* size, const Value& value) {
    if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(data, &value, sizeof value);
    *size = static_cast<int>(sizeof value);
    return ONI_STATUS_OK;
}

template <typename Value>
bool take(const void* data, int size, Value& value) {
    if (size != static_cast<int>(sizeof value)) return false;
    std::memcpy(&value, data, sizeof value);
    return true;
}

float fieldOfView(int pixels, float focalLength) {
    return 2.0F * std::atan(static_cast<float>(pixels) / (2.0F * focalLength));
}

/// Every `shrink`-th pixel, from the right where it is mirrored.
template <typename Pixel>
void copyPixels(ImageView<const Pixel> from, int shrink, bool mirrored, void* to) {
    const int width = from.width / shrink;
    const int height = from.height / shrink;
    auto* out = static_cast<Pixel*>(to);
    for (int y = 0; y < height; ++y, out += width) {
        const Pixel* row = from.row(y * shrink);
        if (shrink == 1 && !mirrored) {
            std::copy_n(row, width, out);
            continue;
        }
        for (int x = 0; x < width; ++x)
            out[x] = row[(mirrored ? width - 1 - x : x) * shrink];
    }
}

}  // namespace

SimulatedStream::SimulatedStream(SimulatedDevice& device, OniSensorType sensor) : device_(device), sensor_(sensor) {}

OniStatus SimulatedStream::start() {
    running_ = true;
    device_.feed();
    return ONI_STATUS_OK;
}

void SimulatedStream::stop() {
    const std::lock_guard lock(mutex_);
    running_ = false;
}

OniStatus SimulatedStream::getProperty(int property, void* data, int* size) {
    const Intrinsics& intrinsics = device_.info().intrinsics;
    const OniVideoMode mode = device_.mode(sensor_);
    const int pixelBytes = sensor_ == ONI_SENSOR_DEPTH ? 2 : 3;
    switch (property) {
        case ONI_STREAM_PROPERTY_VIDEO_MODE:
            return give(data, size, mode);
        case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
            return give(data, size, fieldOfView(intrinsics.width, intrinsics.fx));
        case ONI_STREAM_PROPERTY_VERTICAL_FOV:
            return give(data, size, fieldOfView(intrinsics.height, intrinsics.fy));
        case ONI_STREAM_PROPERTY_CROPPING:
            return give(data, size, OniCropping{});
        case ONI_STREAM_PROPERTY_MIRRORING:
            return give(data, size, OniBool{mirrored_ ? TRUE : FALSE});
        case ONI_STREAM_PROPERTY_STRIDE:
            return give(data, size, mode.resolutionX * pixelBytes);
        case ONI_STREAM_PROPERTY_MIN_VALUE:
            return give(data, size, 0);
        case ONI_STREAM_PROPERTY_MAX_VALUE:
            return give(data, size, sensor_ == ONI_SENSOR_DEPTH ? kMaxValueMm : 255);
        default:
            return ONI_STATUS_NOT_SUPPORTED;
    }
}

OniStatus SimulatedStream::setProperty(int property, const void* data, int size) {
    if (property == ONI_STREAM_PROPERTY_MIRRORING) {
        OniBool mirrored = FALSE;
        if (!take(data, size, mirrored)) return ONI_STATUS_BAD_PARAMETER;
        mirrored_ = mirrored == TRUE;
        return ONI_STATUS_OK;
    }
    if (property == ONI_STREAM_PROPERTY_VIDEO_MODE) {
        OniVideoMode wanted{};
        const OniVideoMode offered = device_.mode(sensor_);
        const bool same = take(data, size, wanted) && wanted.pixelFormat == offered.pixelFormat &&
                          wanted.resolutionX == offered.resolutionX && wanted.resolutionY == offered.resolutionY &&
                          wanted.fps == offered.fps;
        return same ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    if (property == ONI_STREAM_PROPERTY_CROPPING) {
        OniCropping cropping{};
        return take(data, size, cropping) && cropping.enabled == FALSE ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    return ONI_STATUS_NOT_SUPPORTED;
}

OniBool SimulatedStream::isPropertySupported(int property) {
    switch (property) {
        case ONI_STREAM_PROPERTY_VIDEO_MODE:
        case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        case ONI_STREAM_PROPERTY_CROPPING:
        case ONI_STREAM_PROPERTY_MIRRORING:
        case ONI_STREAM_PROPERTY_STRIDE:
        case ONI_STREAM_PROPERTY_MIN_VALUE:
        case ONI_STREAM_PROPERTY_MAX_VALUE:
            return TRUE;
        default:
            return FALSE;
    }
}

void SimulatedStream::deliver(const DepthFrame& frame, int shrink, bool lie) {
    const std::lock_guard lock(mutex_);
    if (!running_) return;
    const OniVideoMode mode = device_.mode(sensor_);
    // The memory is as large as the mode needs it, as the runtime allotted it; a mode that changed meanwhile fits not.
    OniFrame* out = getServices().acquireFrame();
    if (out == nullptr) return;
    const int width = frame.depth.width / shrink;
    const int height = frame.depth.height / shrink;
    const int pixelBytes = sensor_ == ONI_SENSOR_DEPTH ? 2 : 3;
    if (out->dataSize >= width * height * pixelBytes && width == mode.resolutionX) {
        if (sensor_ == ONI_SENSOR_DEPTH) {
            copyPixels(frame.depth, shrink, mirrored_, out->data);
        } else {
            copyPixels(frame.colour, shrink, mirrored_, out->data);
        }
        out->sensorType = sensor_;
        out->timestamp = static_cast<std::uint64_t>(
            std::chrono::duration_cast<std::chrono::microseconds>(frame.captureTime.time_since_epoch()).count());
        out->frameIndex = static_cast<int>(frame.sequence);
        out->width = lie ? width * 64 : width;
        out->height = lie ? height * 64 : height;
        out->videoMode = mode;
        out->croppingEnabled = FALSE;
        out->cropOriginX = 0;
        out->cropOriginY = 0;
        out->stride = width * pixelBytes * (lie ? 64 : 1);
        raiseNewFrame(out);
    }
    getServices().releaseFrame(out);
}

SimulatedDevice::SimulatedDevice(std::unique_ptr<DepthCamera> camera, const CameraInfo& info, Faults& faults)
    : camera_(std::move(camera)), info_(info), faults_(faults) {}

SimulatedDevice::~SimulatedDevice() {
    stopping_ = true;
    camera_->close();
    const std::lock_guard lock(threadMutex_);
    if (thread_.joinable()) thread_.join();
}

OniVideoMode SimulatedDevice::mode(OniSensorType sensor) const {
    const int shrink = faults_.shrink;
    return {.pixelFormat = sensor == ONI_SENSOR_DEPTH ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888,
            .resolutionX = info_.intrinsics.width / shrink,
            .resolutionY = info_.intrinsics.height / shrink,
            .fps = std::max(1, static_cast<int>(std::lround(info_.framesPerSecond)))};
}

OniStatus SimulatedDevice::getSensorInfoList(OniSensorInfo** sensors, int* count) {
    constexpr std::array kKinds = {ONI_SENSOR_DEPTH, ONI_SENSOR_COLOR};
    for (std::size_t i = 0; i < kKinds.size(); ++i) {
        modes_[i] = mode(kKinds[i]);
        sensors_[i] = {.sensorType = kKinds[i], .numSupportedVideoModes = 1, .pSupportedVideoModes = &modes_[i]};
    }
    *sensors = sensors_.data();
    *count = info_.colour ? 2 : 1;
    return ONI_STATUS_OK;
}

oni::driver::StreamBase* SimulatedDevice::createStream(OniSensorType sensor) {
    const bool known = sensor == ONI_SENSOR_DEPTH || (sensor == ONI_SENSOR_COLOR && info_.colour);
    if (!known) return nullptr;
    const std::lock_guard lock(streamsMutex_);
    return streams_.emplace_back(std::make_unique<SimulatedStream>(*this, sensor)).get();
}

void SimulatedDevice::destroyStream(oni::driver::StreamBase* stream) {
    const std::lock_guard lock(streamsMutex_);
    std::erase_if(streams_, [&](const auto& own) { return own.get() == stream; });
}

OniStatus SimulatedDevice::getProperty(int property, void* data, int* size) {
    if (property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return give(data, size, registration_.load());
    if (property == ONI_DEVICE_PROPERTY_DRIVER_VERSION) return give(data, size, OniVersion{.major = 1});
    return ONI_STATUS_NOT_SUPPORTED;
}

OniStatus SimulatedDevice::setProperty(int property, const void* data, int size) {
    int mode = 0;
    if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    if (!take(data, size, mode)) return ONI_STATUS_BAD_PARAMETER;
    // The simulated camera's colour is registered as it is.
    registration_ = mode;
    return ONI_STATUS_OK;
}

OniBool SimulatedDevice::isPropertySupported(int property) {
    return property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || property == ONI_DEVICE_PROPERTY_DRIVER_VERSION ? TRUE
                                                                                                                : FALSE;
}

OniBool SimulatedDevice::isImageRegistrationModeSupported(OniImageRegistrationMode mode) {
    return mode == ONI_IMAGE_REGISTRATION_OFF || mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR ? TRUE : FALSE;
}

void SimulatedDevice::feed() {
    const std::lock_guard lock(threadMutex_);
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
}

void SimulatedDevice::spoil(DepthFrame& frame) {
    copyInto(frame.depth, noise_);
    const std::uint32_t key = scramble(kNoiseKey, static_cast<std::uint32_t>(frame.sequence));
    std::uint32_t counter = 0;
    for (std::uint16_t& reading : noise_.pixels)
        reading = static_cast<std::uint16_t>(scramble(key, counter++) & 0xffffU);
    frame.depth = std::as_const(noise_).view();
}

void SimulatedDevice::run() {
    if (!camera_->open()) return;
    Interrupt never;
    while (!stopping_) {
        DepthFrame frame;
        const FrameStatus status = camera_->waitFrame(kWait, frame);
        if (status == FrameStatus::timedOut) continue;
        if (status != FrameStatus::frame) break;
        faults_.passThrough(HangingCall::read);
        if (!faults_.plugged || faults_.stalled) continue;
        if (const int slow = faults_.slowMs; slow > 0) clock_.waitUntil(clock_.now() + milliseconds(slow), never);
        if (faults_.garbage) spoil(frame);
        const std::lock_guard lock(streamsMutex_);
        for (const auto& stream : streams_)
            stream->deliver(frame, faults_.shrink, faults_.lying);
    }
    camera_->close();
}

}  // namespace cheval::hal::sim

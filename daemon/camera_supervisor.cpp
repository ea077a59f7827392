#include "daemon/camera_supervisor.h"

#include <algorithm>
#include <string>
#include <utility>

namespace cheval::daemon {

CameraSupervisor::CameraSupervisor(CameraFactory factory, const CameraSupervisorOptions& options, hal::Clock& clock)
    : factory_(std::move(factory)), options_(options), clock_(clock), pauseNow_(options.firstPause) {}

CameraSupervisor::~CameraSupervisor() {
    if (camera_ != nullptr) camera_->close();
}

void CameraSupervisor::stop() {
    stopping_.raise();
    const std::lock_guard lock(pointer_);
    if (camera_ != nullptr) camera_->close();
}

Expected<void> CameraSupervisor::checkSize(const hal::CameraInfo& info) const {
    const auto size = [](int width, int height) { return std::to_string(width) + "×" + std::to_string(height); };
    const hal::Intrinsics& has = info.intrinsics;
    if (has.width == options_.width && has.height == options_.height) return {};
    return Error{.code = ErrorCode::invalidInput,
                 .cause = "the pictures of \"" + info.name + "\" are " + size(has.width, has.height) + " pixels",
                 .mend = "resize the recording, or set the sensor, to " + size(options_.width, options_.height),
                 .why = "tracking reads pictures of " + size(options_.width, options_.height)};
}

bool CameraSupervisor::open() {
    if (camera_ == nullptr) {
        Expected<std::unique_ptr<hal::DepthCamera>> made = factory_();
        if (!made) {
            lose(std::move(made).error());
            return false;
        }
        const std::lock_guard lock(pointer_);
        camera_ = std::move(*made);
    }
    Expected<void> opened = camera_->open();
    if (!opened) {
        lose(std::move(opened).error());
        return false;
    }
    Expected<void> fits = checkSize(camera_->info());
    if (!fits) {
        lose(std::move(fits).error());
        return false;
    }
    info_ = camera_->info();
    state_ = CameraState::waiting;
    lastFrame_ = clock_.now();
    fresh_ = true;
    ++openings_;
    return true;
}

void CameraSupervisor::lose(Error why) {
    if (camera_ != nullptr) {
        camera_->close();
        const std::lock_guard lock(pointer_);
        camera_.reset();
    }
    state_ = CameraState::lost;
    fault_ = std::move(why);
    retryAt_ = clock_.now() + pauseNow_;
    pauseNow_ = std::min(pauseNow_ * 2, options_.longestPause);
}

CameraNext CameraSupervisor::pause(hal::TimePoint until) {
    const hal::TimePoint limit = std::min(until, clock_.now() + options_.longestWait);
    return clock_.waitUntil(limit, stopping_) ? CameraNext::none : CameraNext::stopped;
}

CameraNext CameraSupervisor::next(hal::DepthFrame& frame) {
    if (stopping_.raised()) return CameraNext::stopped;
    switch (state_) {
        case CameraState::ended:
            return pause(hal::TimePoint::max());
        case CameraState::lost:
            if (clock_.now() < retryAt_) return pause(retryAt_);
            if (!open()) return CameraNext::none;
            break;
        case CameraState::closed:
            if (!open()) return CameraNext::none;
            break;
        case CameraState::waiting:
        case CameraState::streaming:
            break;
    }
    switch (camera_->waitFrame(options_.longestWait, frame)) {
        case hal::FrameStatus::frame:
            lastFrame_ = clock_.now();
            frame.restart = frame.restart || fresh_;
            fresh_ = false;
            state_ = CameraState::streaming;
            if (fault_) fault_.reset();
            pauseNow_ = options_.firstPause;
            return CameraNext::frame;
        case hal::FrameStatus::timedOut:
            if (options_.lostAfter && clock_.now() - lastFrame_ >= *options_.lostAfter) {
                lose(Error{.code = ErrorCode::timedOut,
                           .cause = "the camera \"" + info_.name + "\" is open but sends no frames",
                           .mend = "check its cable and its power; it is reopened by itself",
                           .why = "connected means that frames are flowing"});
            }
            return CameraNext::none;
        case hal::FrameStatus::ended:
            state_ = CameraState::ended;
            fault_ = Error{.code = ErrorCode::unavailable,
                           .cause = "the recording \"" + info_.name + "\" is over",
                           .mend = "set sensor.loop = true to play it again and again"};
            return CameraNext::none;
        case hal::FrameStatus::lost:
            lose(Error{.code = ErrorCode::unavailable,
                       .cause = "the camera \"" + info_.name + "\" is gone",
                       .mend = "check its cable and its power; it is reopened by itself"});
            return CameraNext::none;
        case hal::FrameStatus::closed:
            if (stopping_.raised()) return CameraNext::stopped;
            lose(Error{.code = ErrorCode::unavailable,
                       .cause = "the camera \"" + info_.name + "\" was closed",
                       .mend = "it is reopened by itself"});
            return CameraNext::none;
    }
    return CameraNext::none;
}

}  // namespace cheval::daemon

#include "daemon/camera_supervisor.h"

#include <algorithm>
#include <string>
#include <utility>

namespace cheval::daemon {

namespace {

/// Between two looks at something that is being done.
constexpr hal::Duration kBetweenTries = std::chrono::milliseconds(5);

constexpr const char* kByItself = "check its cable and its power; it is reopened by itself";

}  // namespace

CameraSupervisor::CameraSupervisor(CameraFactory factory, const CameraSupervisorOptions& options, hal::Clock& clock)
    : factory_(std::move(factory)), options_(options), clock_(clock), machine_(options.recovery) {}

CameraSupervisor::~CameraSupervisor() {
    if (camera_ != nullptr) camera_->close();
}

void CameraSupervisor::stop() {
    stopping_.raise();
    const std::lock_guard lock(pointer_);
    if (camera_ != nullptr) camera_->close();
}

CameraState CameraSupervisor::state() const {
    switch (machine_.state()) {
        case RecoveryState::closed:
            return CameraState::closed;
        case RecoveryState::opening:
        case RecoveryState::resting:
            return fault_ ? CameraState::lost : CameraState::waiting;
        case RecoveryState::unproven:
            return CameraState::waiting;
        case RecoveryState::streaming:
        case RecoveryState::doubtful:
            return CameraState::streaming;
        case RecoveryState::ended:
            return CameraState::ended;
    }
    return CameraState::closed;
}

hal::Duration CameraSupervisor::silence() const {
    return anyFrame_ ? clock_.now() - lastFrame_ : hal::Duration::zero();
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

void CameraSupervisor::tell(RecoveryEvent event) {
    const RecoveryAction action = machine_.on(event, clock_.now());
    // While something is being done, nothing else is begun; the machine says so by RecoveryAction::none.
    if (action != RecoveryAction::none) {
        doing_ = action;
        begun_ = false;
        inHardware_ = false;
    } else if (machine_.state() != RecoveryState::opening) {
        doing_ = RecoveryAction::none;
    }
}

void CameraSupervisor::release() {
    if (camera_ == nullptr) return;
    camera_->close();
    const std::lock_guard lock(pointer_);
    camera_.reset();
}

void CameraSupervisor::refuse(Error why) {
    fault_ = std::move(why);
    tell(RecoveryEvent::refused);
}

void CameraSupervisor::open() {
    if (camera_ == nullptr) {
        Expected<std::unique_ptr<hal::DepthCamera>> made = factory_();
        if (!made) return refuse(std::move(made).error());
        const std::lock_guard lock(pointer_);
        camera_ = std::move(*made);
    }
    Expected<void> opened = camera_->open();
    if (!opened) {
        // Still at it: asked again at the next turn, until the machine's patience ends.
        if (opened.error().code != ErrorCode::timedOut) refuse(std::move(opened).error());
        return;
    }
    Expected<void> fits = checkSize(camera_->info());
    if (!fits) {
        camera_->close();
        return refuse(std::move(fits).error());
    }
    info_ = camera_->info();
    fresh_ = true;
    restarted_ = true;
    ++openings_;
    tell(RecoveryEvent::opened);
}

void CameraSupervisor::performHardware(RecoveryRung rung) {
    if (!begun_) {
        // A handle on a device that enumerates anew is a stale one.
        release();
        inHardware_ = true;
        Expected<void> done = options_.hardware->perform(rung);
        if (!done) {
            if (done.error().code != ErrorCode::timedOut) refuse(std::move(done).error());
            return;
        }
        begun_ = true;
        inHardware_ = false;
        tell(RecoveryEvent::prepared);
    }
    open();
}

void CameraSupervisor::perform(RecoveryRung rung) {
    switch (rung) {
        case RecoveryRung::retryRead:
            return tell(RecoveryEvent::opened);
        case RecoveryRung::restartStream: {
            Expected<void> restarted = camera_ != nullptr ? camera_->restartStream() : Expected<void>();
            if (camera_ == nullptr || !restarted) return tell(RecoveryEvent::refused);
            restarted_ = true;
            return tell(RecoveryEvent::opened);
        }
        case RecoveryRung::reopenDevice:
            if (camera_ != nullptr && camera_->isOpen()) camera_->close();
            return open();
        case RecoveryRung::recycle:
            // Only at its beginning: an opening that is waited for must not be begun anew at every turn.
            if (!std::exchange(begun_, true)) release();
            return open();
        case RecoveryRung::resetUsb:
        case RecoveryRung::powerCycle:
        case RecoveryRung::restartDaemon:
        case RecoveryRung::reboot:
            return performHardware(rung);
    }
}

void CameraSupervisor::checkArrivals() {
    const bool atCamera = camera_ != nullptr && camera_->takeArrival();
    const bool atBus = options_.hardware != nullptr && options_.hardware->takeArrival();
    if (atCamera || atBus) tell(RecoveryEvent::arrived);
}

CameraNext CameraSupervisor::pause(hal::Duration longest) {
    const hal::TimePoint limit = std::min(machine_.deadline(), clock_.now() + longest);
    return clock_.waitUntil(limit, stopping_) ? CameraNext::none : CameraNext::stopped;
}

CameraNext CameraSupervisor::next(hal::DepthFrame& frame) {
    resumed_ = false;
    if (stopping_.raised()) return CameraNext::stopped;
    if (machine_.state() == RecoveryState::ended) return pause(options_.longestWait);
    if (machine_.state() == RecoveryState::closed) tell(RecoveryEvent::begin);
    checkArrivals();
    if (clock_.now() >= machine_.deadline()) {
        if (machine_.state() == RecoveryState::opening) {
            fault_ = Error{.code = ErrorCode::timedOut,
                           .cause = "the camera does not open in time",
                           .mend = kByItself,
                           .why = "an opening that takes so long hangs"};
        }
        tell(RecoveryEvent::timer);
    }
    if (doing_ == RecoveryAction::open) open();
    if (doing_ == RecoveryAction::perform) perform(machine_.rung());
    if (stopping_.raised()) return CameraNext::stopped;
    // A camera that is being opened has waited in open(); what comes next is not to be kept waiting.
    if (doing_ != RecoveryAction::none) return pause(inHardware_ ? options_.longestWait : kBetweenTries);
    if (camera_ != nullptr && camera_->isOpen()) return wait(frame);
    return pause(options_.longestWait);
}

CameraNext CameraSupervisor::wait(hal::DepthFrame& frame) {
    const hal::Duration left = std::max(hal::Duration::zero(), machine_.deadline() - clock_.now());
    return take(camera_->waitFrame(std::min(options_.longestWait, left), frame), frame);
}

CameraNext CameraSupervisor::take(hal::FrameStatus status, hal::DepthFrame& frame) {
    switch (status) {
        case hal::FrameStatus::frame:
            outage_ = silence();
            lastFrame_ = clock_.now();
            resumed_ = anyFrame_ && restarted_;
            frame.restart = frame.restart || fresh_ || restarted_;
            fresh_ = false;
            restarted_ = false;
            anyFrame_ = true;
            if (fault_) fault_.reset();
            tell(RecoveryEvent::frame);
            if (options_.hardware != nullptr && machine_.healthy()) options_.hardware->healthy();
            return CameraNext::frame;
        case hal::FrameStatus::timedOut:
            if ((machine_.state() == RecoveryState::doubtful || machine_.state() == RecoveryState::unproven) &&
                clock_.now() >= machine_.deadline()) {
                fault_ = Error{.code = ErrorCode::timedOut,
                               .cause = "the camera \"" + info_.name + "\" is open but sends no frames",
                               .mend = kByItself,
                               .why = "connected means that frames are flowing"};
            }
            return CameraNext::none;
        case hal::FrameStatus::ended:
            fault_ = Error{.code = ErrorCode::unavailable,
                           .cause = "the recording \"" + info_.name + "\" is over",
                           .mend = "set sensor.loop = true to play it again and again"};
            tell(RecoveryEvent::ended);
            return CameraNext::none;
        case hal::FrameStatus::lost:
            fault_ = camera_->lossReason().value_or(Error{.code = ErrorCode::unavailable,
                                                          .cause = "the camera \"" + info_.name + "\" is gone",
                                                          .mend = kByItself});
            camera_->close();
            tell(RecoveryEvent::lost);
            return CameraNext::none;
        case hal::FrameStatus::closed:
            if (stopping_.raised()) return CameraNext::stopped;
            fault_ = Error{.code = ErrorCode::unavailable,
                           .cause = "the camera \"" + info_.name + "\" was closed",
                           .mend = "it is reopened by itself"};
            tell(RecoveryEvent::lost);
            return CameraNext::none;
    }
    return CameraNext::none;
}

}  // namespace cheval::daemon

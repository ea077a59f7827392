#include "hal/depth_camera.h"

#include <utility>

#include "hal/intrinsics_check.h"

namespace cheval::hal {

Expected<void> DepthCamera::open() {
    const std::lock_guard lock(device_);
    if (open_) {
        return Error{.code = ErrorCode::invalidInput, .cause = "the camera is open already", .mend = "close it first"};
    }
    interrupt_.clear();
    Expected<CameraInfo> opened = doOpen();
    if (!opened) return std::move(opened).error();
    Expected<void> plausible = checkIntrinsics(opened->intrinsics);
    if (!plausible) {
        doClose();
        return std::move(plausible).error().within("what \"" + opened->name + "\" says of its lens cannot be");
    }
    info_ = std::move(*opened);
    open_ = true;
    return {};
}

Expected<void> DepthCamera::restartStream() {
    const std::lock_guard lock(device_);
    if (open_) return doRestartStream();
    return Error{.code = ErrorCode::invalidInput, .cause = "the camera is not open", .mend = "open it first"};
}

bool DepthCamera::takeArrival() {
    const std::lock_guard lock(device_);
    return doTakeArrival();
}

Expected<void> DepthCamera::doRestartStream() {
    return Error{.code = ErrorCode::unavailable,
                 .cause = "this camera's stream cannot be restarted",
                 .mend = "reopen the camera"};
}

void DepthCamera::close() {
    interrupt_.raise();
    const std::lock_guard lock(device_);
    release();
}

void DepthCamera::release() {
    if (!open_) return;
    open_ = false;
    doClose();
}

FrameStatus DepthCamera::waitFrame(Duration timeout, DepthFrame& frame) {
    const std::lock_guard lock(device_);
    if (!open_ || interrupt_.raised()) return FrameStatus::closed;
    return doWaitFrame(timeout, frame, interrupt_);
}

}  // namespace cheval::hal

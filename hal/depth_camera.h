// The one way to a depth sensor, real, replayed or simulated. Public calls are not virtual: checks, state and the
// interrupt live here once, a back end fills in the do… calls.
#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "hal/clock.h"
#include "hal/expected.h"
#include "hal/frame.h"

namespace cheval::hal {

/// What a camera says of itself once it is open.
struct CameraInfo {
    std::string name;  ///< For people, e.g. "replay of seq01".
    Intrinsics intrinsics;
    double framesPerSecond = 30.0;
    Mount mount;
    bool colour = false;
    bool independent = false;  ///< A set of stills that do not follow each other in time.
};

enum class FrameStatus {
    frame,     ///< A new frame was delivered.
    timedOut,  ///< None came in time; the next call may deliver one.
    ended,     ///< A recording is over; no frame will come until it is reopened.
    lost,      ///< The device is gone or broken; close and reopen.
    closed,    ///< close() was called, perhaps by another thread during the wait.
};

/// A depth camera. Thread-bound, but for close(), which any thread may call at any time.
class DepthCamera {
  public:
    virtual ~DepthCamera() = default;
    DepthCamera(const DepthCamera&) = delete;
    DepthCamera& operator=(const DepthCamera&) = delete;

    /// Starts the stream. Errors: those of the back end; invalidInput where the camera's intrinsics cannot be those of
    /// a depth sensor (intrinsics_check.h). Opening an open camera is an error; after close() it may be opened again,
    /// any number of times. A slow device may answer ErrorCode::timedOut: it is still being opened, and the next call
    /// waits on.
    Expected<void> open();
    /// Stops and starts the stream of an open camera, for a device that is there and sends nothing. Errors: unavailable
    /// where it has no such thing.
    Expected<void> restartStream();
    /// True once for each device that was plugged in since the last call, where the back end can tell: opening is
    /// worth trying at once.
    bool takeArrival();
    /// Why the last wait said `lost`, where the back end knows.
    [[nodiscard]] virtual std::optional<Error> lossReason() const { return std::nullopt; }
    /// Ends a wait in progress; the device is released by the thread that waits, or at once when none does.
    void close();
    [[nodiscard]] bool isOpen() const { return open_; }
    /// Waits for the next frame, at most `timeout` of the back end's clock. On FrameStatus::frame, `frame` is a view
    /// that stays valid until the next call of any kind. Each frame has a sequence number greater than the one before.
    /// When the caller is too slow, a live source skips frames and never queues them without bound; a recording never
    /// skips: the next frame comes late instead.
    FrameStatus waitFrame(Duration timeout, DepthFrame& frame);
    /// Valid while open.
    [[nodiscard]] const CameraInfo& info() const { return info_; }

  protected:
    DepthCamera() = default;
    virtual Expected<CameraInfo> doOpen() = 0;
    virtual void doClose() = 0;
    virtual Expected<void> doRestartStream();
    virtual bool doTakeArrival() { return false; }
    /// For an opening that takes long: close() was called meanwhile.
    [[nodiscard]] bool closing() const { return interrupt_.raised(); }
    /// Must return FrameStatus::closed as soon as `interrupt` is raised.
    virtual FrameStatus doWaitFrame(Duration timeout, DepthFrame& frame, Interrupt& interrupt) = 0;

  private:
    void release();

    CameraInfo info_;
    Interrupt interrupt_;
    std::mutex device_;  ///< Held while the device is used: open, wait, release.
    std::atomic<bool> open_{false};
};

}  // namespace cheval::hal

// Keeps frames coming: opens the camera, notices when it is lost, and opens it again with a growing pause.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "hal/clock.h"
#include "hal/depth_camera.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// Makes the camera; called again after each failure, so a folder or a device may turn up later.
using CameraFactory = std::function<Expected<std::unique_ptr<hal::DepthCamera>>()>;

struct CameraSupervisorOptions {
    /// Without a frame for this long the camera is lost; std::nullopt: never (a recording's gap is no fault).
    std::optional<hal::Duration> lostAfter = std::chrono::seconds(1);
    hal::Duration longestWait = std::chrono::milliseconds(100);  ///< Of one call of next().
    hal::Duration firstPause = std::chrono::milliseconds(500);   ///< Before the first reopening; doubles …
    hal::Duration longestPause = std::chrono::seconds(30);       ///< … up to this; reset by a frame.
    int width = 640;  ///< Of the pictures that can be used; a camera with others is refused when it opens.
    int height = 480;
};

enum class CameraState : std::uint8_t {
    closed,     ///< Not opened yet.
    waiting,    ///< Open, no frame yet.
    streaming,  ///< "Connected" means that frames are flowing.
    lost,       ///< Out of order; it will be reopened.
    ended,      ///< A recording is over; that is no fault, and nothing is reopened.
};

enum class CameraNext : std::uint8_t { frame, none, stopped };

/// Thread-bound but for stop(). A healthy stream takes no heap memory.
class CameraSupervisor {
  public:
    CameraSupervisor(CameraFactory factory, const CameraSupervisorOptions& options, hal::Clock& clock);
    ~CameraSupervisor();
    CameraSupervisor(const CameraSupervisor&) = delete;
    CameraSupervisor& operator=(const CameraSupervisor&) = delete;

    /// The next frame, or none within longestWait. The first frame after every opening has `restart` set.
    CameraNext next(hal::DepthFrame& frame);
    /// Ends a wait in progress and every later one. Any thread.
    void stop();

    [[nodiscard]] CameraState state() const { return state_; }
    /// Why there are no frames; empty while all is well.
    [[nodiscard]] const std::optional<Error>& fault() const { return fault_; }
    /// Valid once open; rises in `openings` with every opening.
    [[nodiscard]] const hal::CameraInfo& info() const { return info_; }
    [[nodiscard]] std::uint64_t openings() const { return openings_; }

  private:
    bool open();
    [[nodiscard]] Expected<void> checkSize(const hal::CameraInfo& info) const;
    void lose(Error why);
    CameraNext pause(hal::TimePoint until);

    CameraFactory factory_;
    CameraSupervisorOptions options_;
    hal::Clock& clock_;
    std::mutex pointer_;  ///< Held while camera_ changes, so that stop() never sees it half changed.
    std::unique_ptr<hal::DepthCamera> camera_;
    hal::Interrupt stopping_;
    CameraState state_ = CameraState::closed;
    std::optional<Error> fault_;
    hal::CameraInfo info_;
    std::uint64_t openings_ = 0;
    hal::TimePoint lastFrame_{};
    hal::TimePoint retryAt_{};
    hal::Duration pauseNow_{};
    bool fresh_ = false;  ///< No frame since the opening.
};

}  // namespace cheval::daemon

// Keeps frames coming: opens the camera, notices when it is lost, and does what the recovery machine says.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "daemon/recovery.h"
#include "hal/clock.h"
#include "hal/depth_camera.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// Makes the camera; called again after each failure, so a folder or a device may turn up later.
using CameraFactory = std::function<Expected<std::unique_ptr<hal::DepthCamera>>()>;

struct CameraSupervisorOptions {
    RecoveryOptions recovery;
    hal::Duration longestWait = std::chrono::milliseconds(100);  ///< Of one call of next().
    int width = 640;  ///< Of the pictures that can be used; a camera with others is refused when it opens.
    int height = 480;
    RecoveryHardware* hardware = nullptr;  ///< For the rungs above recycle; null: there are none.
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

    /// The next frame, or none within longestWait (and what the camera's own open() may wait). The first frame after
    /// every opening has `restart` set.
    CameraNext next(hal::DepthFrame& frame);
    /// Ends a wait in progress and every later one. Any thread.
    void stop();

    [[nodiscard]] CameraState state() const;
    /// Why there are no frames; empty while all is well.
    [[nodiscard]] const std::optional<Error>& fault() const { return fault_; }
    [[nodiscard]] bool anyFrame() const { return anyFrame_; }
    /// For how long there has been none; zero before the first.
    [[nodiscard]] hal::Duration silence() const;
    /// The frame that next() delivered last is the first one after an outage.
    [[nodiscard]] bool resumed() const { return resumed_; }
    /// How long it was until that frame.
    [[nodiscard]] hal::Duration outage() const { return outage_; }
    [[nodiscard]] const RecoveryMachine& recovery() const { return machine_; }
    /// Valid once open; rises in `openings` with every opening.
    [[nodiscard]] const hal::CameraInfo& info() const { return info_; }
    [[nodiscard]] std::uint64_t openings() const { return openings_; }

  private:
    void tell(RecoveryEvent event);
    void open();
    void perform(RecoveryRung rung);
    void performHardware(RecoveryRung rung);
    void release();
    void refuse(Error why);
    void checkArrivals();
    [[nodiscard]] Expected<void> checkSize(const hal::CameraInfo& info) const;
    CameraNext wait(hal::DepthFrame& frame);
    CameraNext take(hal::FrameStatus status, hal::DepthFrame& frame);
    CameraNext pause(hal::Duration longest);

    CameraFactory factory_;
    CameraSupervisorOptions options_;
    hal::Clock& clock_;
    RecoveryMachine machine_;
    std::mutex pointer_;  ///< Held while camera_ changes, so that stop() never sees it half changed.
    std::unique_ptr<hal::DepthCamera> camera_;
    hal::Interrupt stopping_;
    RecoveryAction doing_ = RecoveryAction::none;  ///< Begun, and to be gone on with.
    bool inHardware_ = false;                      ///< A rung above recycle is at work.
    bool begun_ = false;                           ///< The rung's own part is done; opening the camera follows.
    std::optional<Error> fault_;
    hal::CameraInfo info_;
    std::uint64_t openings_ = 0;
    hal::TimePoint lastFrame_{};
    hal::Duration outage_{};
    bool fresh_ = false;      ///< No frame since the opening.
    bool anyFrame_ = false;   ///< There has been one.
    bool restarted_ = false;  ///< The stream was restarted, or the device opened, since the last frame.
    bool resumed_ = false;
};

}  // namespace cheval::daemon

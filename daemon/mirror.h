// The mirror: camera, frame chain, renderer and display, tied together. Either one turn after another in the caller's
// thread (replay, simulation, tests: deterministic), or as two threads in a pipeline one frame deep (the product).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "config/settings.h"
#include "daemon/camera_supervisor.h"
#include "daemon/degrade_ladder.h"
#include "daemon/frame_chain.h"
#include "daemon/frame_packet.h"
#include "daemon/frame_rate.h"
#include "daemon/picture_maker.h"
#include "daemon/triple_buffer.h"
#include "daemon/wardrobe.h"
#include "fitting/users.h"
#include "hal/buttons.h"
#include "hal/display.h"

namespace cheval::daemon {

/// What the mirror works with. Everything borrowed outlives it.
struct MirrorParts {
    CameraFactory camera;
    std::vector<hal::Buttons*> buttons;
    RemoteCommands* commands = nullptr;    ///< What other programs ask for; null: none can.
    RecoveryHardware* hardware = nullptr;  ///< For a sensor that nothing else brings back; may be null.
    hal::Display* display = nullptr;       ///< Open.
    hal::DisplayMode mode;                 ///< As the display said when it was opened.
    hal::Clock* clock = nullptr;           ///< Drives frames and dwell times.
    /// Decides what still fits into a frame; null: `clock`. One that stands still sheds nothing.
    const hal::Clock* admission = nullptr;
    const hal::Clock* cost = nullptr;    ///< Measures what tasks take.
    const Wardrobe* wardrobe = nullptr;  ///< Its materials are read by start(), or the first step() that draws.
    PictureObserver observer;            ///< May be empty.
    bool runToTheEnd = false;            ///< Replay: the degrade ladder stays at the top and no frame is left out.
};

/// For a status line; plain values of fixed size.
struct MirrorStatus {
    SessionState state = SessionState::idle;
    render::FixedText<96> outfit;
    std::size_t outfitIndex = 0;  ///< Among the wardrobe's outfits.
    CameraState camera = CameraState::closed;
    render::FixedText<512> fault;
    fitting::ViewFault viewFault = fitting::ViewFault::none;  ///< What keeps people from being seen.
    double sensorFramesPerSecond = 0.0;   ///< What the sensor takes, not what is shown; 0: not known yet.
    render::FixedText<256> buttonsFault;  ///< Why the buttons cannot be read; empty while they can.
    render::FixedText<512> displayFault;  ///< Why the last picture was not shown; empty where it was.
    bool avatarView = false;
    double framesPerSecond = 0.0;
    hal::Duration loopTime{};    ///< Of the last frame.
    hal::Duration renderTime{};  ///< Of the last picture.
    std::size_t degradeLevel = 0;
    std::string_view degradeName;
    std::uint64_t turns = 0;  ///< Of the loop, with or without a frame: stands still only where the loop hangs.
    std::uint64_t frames = 0;
    std::uint64_t pictures = 0;
    std::uint64_t visits = 0;
    std::uint64_t drawTurns = 0;  ///< Pictures, and those that only an absent screen kept from being shown.
    std::uint64_t openings = 0;   ///< Of the camera.
    /// How often each rung of the sensor's recovery was taken, by RecoveryRung.
    std::array<std::uint64_t, kRecoveryRungCount> recovery{};
};

enum class StepResult : std::uint8_t {
    frame,    ///< A frame went through the chain.
    none,     ///< None came in time; session and screen moved on all the same.
    ended,    ///< The recording is over.
    stopped,  ///< stop() was called.
};

/// Thread-bound, but for stop(), status() and setNotice(), which any thread may call.
class Mirror {
  public:
    static Expected<std::unique_ptr<Mirror>> create(const config::Settings& settings, MirrorParts parts);
    ~Mirror();
    Mirror(const Mirror&) = delete;
    Mirror& operator=(const Mirror&) = delete;

    /// One turn in the caller's thread. `draw` decides, frame by frame, whether a picture is made of it (empty:
    /// always); a turn without a frame is drawn always. The first call makes the renderer.
    Expected<StepResult> step(const std::function<bool(const hal::DepthFrame&)>& draw = {});
    /// The frame that the last step() took in; its views are valid until the next step.
    [[nodiscard]] const hal::DepthFrame& frame() const { return frame_; }
    [[nodiscard]] const FrameChain& chain() const { return *chain_; }
    [[nodiscard]] FrameChain& chain() { return *chain_; }
    [[nodiscard]] const CameraSupervisor& camera() const { return supervisor_; }

    /// Starts both threads; returns when the renderer stands, or why it cannot.
    Expected<void> start();
    /// Ends both threads within about a quarter of a second; safe at any time, also from another thread's signal wait.
    void stop();
    /// A message for technicians on the service screen: refused settings, refused garments. Each opens that screen
    /// for eight seconds, as soon as no shopper is being dressed. Empty takes it away.
    void setNotice(std::string_view notice);

    [[nodiscard]] MirrorStatus status() const;
    /// Rows of both threads, loop first, then the renderer; each with its whole frame as the last row.
    [[nodiscard]] std::vector<TaskStatistics> statistics() const;
    /// The GL context in words; empty before it stands.
    [[nodiscard]] std::string rendererDescription() const;

  private:
    Mirror(const config::Settings& settings, MirrorParts parts);

    Expected<void> makePictures();
    CameraNext takeFrame();
    /// Frames have stopped, and not for so long that people must be told why.
    [[nodiscard]] bool patience() const;
    void turn(bool haveFrame, FramePacket& packet);
    void afterLoop(hal::Duration taken, bool haveFrame);
    void afterPicture(const Expected<hal::Duration>& shown);
    void runLoop();
    void runRenderer(std::promise<Expected<void>> standing);
    [[nodiscard]] bool tooSoon(const hal::DepthFrame& frame);

    config::Settings settings_;
    MirrorParts parts_;
    CameraSupervisor supervisor_;
    std::unique_ptr<FrameChain> chain_;
    std::unique_ptr<PictureMaker> pictures_;
    DegradeLadder ladder_;
    hal::DepthFrame frame_;
    std::uint64_t openingsSeen_ = 0;
    hal::CameraInfo lastCamera_;
    FrameRate sensorRate_;
    bool otherCamera_ = true;  ///< No frame yet of a sensor that was not there before.
    hal::TimePoint nextDue_{};
    hal::Duration basePeriod_{};

    TripleBuffer<FramePacket> packets_;
    hal::Interrupt packetReady_;
    std::atomic<bool> stopping_{false};
    std::thread loopThread_;
    std::thread renderThread_;

    std::atomic<hal::Duration::rep> renderTime_{0};
    std::atomic<std::uint64_t> picturesShown_{0};
    std::string faultText_;  ///< Loop thread's; rebuilt only when the fault changes.
    std::string faultCause_;
    std::array<std::uint64_t, kRecoveryRungCount> rungsTold_{};
    bool faulty_ = false;
    bool noticeWaits_ = false;      ///< A new notice has not been shown yet.
    hal::TimePoint noticeUntil_{};  ///< Until when the service screen is open for it.
    double rate_ = 0.0;
    hal::TimePoint lastRate_{};

    mutable std::mutex shared_;  ///< Guards the members below; held for a copy of plain values only.
    MirrorStatus status_;
    std::array<TaskStatistics, kMaximumTasks + 1> loopRows_{};
    std::array<TaskStatistics, kMaximumTasks + 1> renderRows_{};
    std::size_t loopRowCount_ = 0;
    std::size_t renderRowCount_ = 0;
    render::FixedText<512> notice_;
    bool noticeNew_ = false;
    std::string description_;
};

}  // namespace cheval::daemon

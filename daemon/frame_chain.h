// The tasks of a frame, in order: track, hands, body, session, layering on change, animate, hand over. It
// owns the fitting rooms and ties them together; it computes nothing itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "daemon/frame_packet.h"
#include "daemon/remote_commands.h"
#include "daemon/scheduler.h"
#include "daemon/session.h"
#include "daemon/wardrobe.h"
#include "fitting/animation/animator.h"
#include "fitting/body/body_estimator.h"
#include "fitting/body/size_advice.h"
#include "fitting/layering/outfit_fitter.h"
#include "fitting/tracking/tracker.h"
#include "hal/buttons.h"
#include "hal/depth_camera.h"
#include "render/mirror_mapping.h"

namespace cheval::daemon {

struct FrameChainOptions {
    fitting::TrackerOptions tracker;
    fitting::BodyEstimatorOptions estimator;
    fitting::AnimatorOptions animator;
    SessionOptions session;
    SchedulerOptions scheduler;
    int displayWidth = 1080;  ///< Where hand cursors go.
    int displayHeight = 1920;
    bool rotated = false;  ///< As render::RendererOptions::rotated.
};

/// What one turn of the loop works on. All borrowed for the time of process().
struct ChainInput {
    const hal::DepthFrame* frame = nullptr;  ///< Null: none came in time.
    hal::TimePoint time{};                   ///< The frame's capture time, or now.
    hal::TimePoint started{};                ///< Admission clock: when the frame's time began to run.
    std::span<hal::Buttons* const> buttons;
    RemoteCommands* commands = nullptr;  ///< Null: nobody can send any.
    std::string_view fault;              ///< Why there are no frames, if people are to be told.
    bool away = false;                   ///< There were frames, and for a moment there are none.
    std::string_view notice;             ///< For the service screen …
    bool showNotice = false;             ///< … which opens for it, unless a shopper is being dressed.
    float renderScale = 1.0F;
};

/// Thread-bound. After construction and reserve() process() takes no heap memory. Borrows the wardrobe and the clocks.
class FrameChain {
  public:
    static Expected<std::unique_ptr<FrameChain>> create(const Wardrobe& wardrobe, const FrameChainOptions& options,
                                                        const hal::Clock& admission, const hal::Clock& cost);
    ~FrameChain();
    FrameChain(const FrameChain&) = delete;
    FrameChain& operator=(const FrameChain&) = delete;

    /// Gives a packet the memory that any frame of this size will need, and the carousel's names.
    void reserve(FramePacket& packet, int width, int height, bool colour) const;
    /// A camera was opened: starts tracking anew with its mount. Takes memory.
    void cameraOpened(const fitting::TrackerOptions& options);
    /// Nothing was seen for so long that another person may stand there: measures anew.
    void personMayHaveChanged();
    /// Runs the tasks and fills `packet`. Returns what it took, by the cost clock.
    hal::Duration process(const ChainInput& input, FramePacket& packet);
    void setFramePeriod(hal::Duration period) { scheduler_.setFramePeriod(period); }

    /// Results of the last process().
    [[nodiscard]] const Session& session() const { return session_; }
    [[nodiscard]] const fitting::Tracker& tracker() const { return *tracker_; }
    /// Gestures of the last frame are in it only if the hands were read in that frame.
    [[nodiscard]] const fitting::Hands& hands() const { return hands_; }
    /// Null without a mannequin.
    [[nodiscard]] const fitting::Measurements* measurements() const;
    /// On the size of the outermost garment that has one.
    [[nodiscard]] const fitting::SizeAdvice& advice() const { return adviser_.advice(); }
    /// Why the buttons cannot be read; empty while they can.
    [[nodiscard]] std::string_view buttonsFault() const { return buttonsFault_.view(); }
    [[nodiscard]] const Scheduler& scheduler() const { return scheduler_; }

    /// The task table, for documents and tests.
    static std::span<const Task> tasks();

  private:
    struct Tasks;
    FrameChain(const Wardrobe& wardrobe, const FrameChainOptions& options, Scheduler scheduler);

    void pollButtons();
    void updateSession();
    void fitOutfit();
    void adviseSize();
    void handOver();
    [[nodiscard]] fitting::Outfit chosen() const;
    [[nodiscard]] bool outfitChanged() const;
    [[nodiscard]] bool somebody() const;

    const Wardrobe& wardrobe_;
    Scheduler scheduler_;
    Session session_;
    std::unique_ptr<fitting::Tracker> tracker_;
    std::unique_ptr<fitting::BodyEstimator> estimator_;
    std::unique_ptr<fitting::OutfitFitter> fitter_;
    std::unique_ptr<fitting::Animator> animator_;
    fitting::ShapedBody shaped_;
    fitting::BodyShape fittedShape_;
    fitting::Outfit fittedOutfit_;
    fitting::Hands hands_;
    fitting::SizeAdviser adviser_;
    std::uint32_t advisedUser_ = 0;  ///< Whose size it is; 0: nobody's yet.
    /// The same crop as the renderer's, so that a cursor lies on its hand.
    render::CropFollower crop_;
    render::MirrorMapping mapping_;
    int displayWidth_;
    int displayHeight_;
    bool rotated_;

    static constexpr std::size_t kMaximumEvents = 64;
    std::array<hal::ButtonEvent, kMaximumEvents> events_{};
    std::size_t eventCount_ = 0;
    render::FixedText<256> buttonsFault_;
    std::array<RemoteCommand, RemoteCommands::kMaximumWaiting> commands_{};
    std::size_t commandCount_ = 0;
    // The frame in work.
    const ChainInput* input_ = nullptr;
    FramePacket* packet_ = nullptr;
};

}  // namespace cheval::daemon

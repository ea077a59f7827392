// The renderer's side: draws a packet into the buffer that the display lends, and shows it.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "daemon/frame_packet.h"
#include "daemon/scheduler.h"
#include "fitting/material.h"
#include "hal/display.h"
#include "render/renderer.h"

namespace cheval::daemon {

/// Sees every finished picture before it is shown; for reports and files. Runs on the renderer's thread.
using PictureObserver = std::function<void(const FramePacket&, hal::ImageView<const hal::Rgba8>)>;

struct PictureMakerOptions {
    render::RendererOptions renderer;
    SchedulerOptions scheduler;
    PictureObserver observer;
};

/// A clock that can be stopped, so that what an observer takes is nobody's cost. Thread-bound.
class PausableClock final : public hal::Clock {
  public:
    explicit PausableClock(const hal::Clock& clock) : clock_(clock) {}
    [[nodiscard]] hal::TimePoint now() const override { return (paused_ ? pausedAt_ : clock_.now()) - excluded_; }
    /// Waits are for the clock behind it; this one returns at once.
    bool waitUntil(hal::TimePoint, hal::Interrupt&) override { return true; }
    void pause() {
        pausedAt_ = clock_.now();
        paused_ = true;
    }
    void resume() {
        excluded_ += clock_.now() - pausedAt_;
        paused_ = false;
    }

  private:
    const hal::Clock& clock_;
    hal::Duration excluded_{};
    hal::TimePoint pausedAt_{};
    bool paused_ = false;
};

/// Thread-bound to the thread that calls create(). Borrows the display and the clock.
class PictureMaker {
  public:
    static Expected<std::unique_ptr<PictureMaker>> create(const PictureMakerOptions& options,
                                                          std::span<const fitting::Material> materials,
                                                          hal::Display& display, const hal::Clock& cost);
    ~PictureMaker();
    PictureMaker(const PictureMaker&) = delete;
    PictureMaker& operator=(const PictureMaker&) = delete;

    /// Draws and shows one frame. Returns what drawing and showing took, without the wait for a free buffer.
    Expected<hal::Duration> show(const FramePacket& packet);

    [[nodiscard]] const Scheduler& scheduler() const { return scheduler_; }
    /// The GL context in words.
    [[nodiscard]] const std::string& description() const { return renderer_->description(); }

    static std::span<const Task> tasks();

  private:
    struct Tasks;
    PictureMaker(const PictureMakerOptions& options, std::unique_ptr<render::Renderer> renderer, hal::Display& display,
                 std::unique_ptr<PausableClock> cost, Scheduler scheduler);

    PictureMakerOptions options_;
    std::unique_ptr<render::Renderer> renderer_;
    hal::Display& display_;
    std::unique_ptr<PausableClock> cost_;
    Scheduler scheduler_;
    // The frame in work.
    const FramePacket* packet_ = nullptr;
    hal::DisplayBuffer buffer_;
    Expected<void> outcome_;
};

}  // namespace cheval::daemon

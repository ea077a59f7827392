#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "hal/sim/hash.h"
#include "hal/sim/scene.h"
#include "hal/sim/world.h"
#include "hal/sim/world_parts.h"

namespace cheval::hal::sim {

namespace {

/// How long a caller with a fault in force waits before it looks again whether that is over.
constexpr Duration kFaultPoll = std::chrono::milliseconds(5);

class SimulatedCamera final : public DepthCamera {
  public:
    SimulatedCamera(std::shared_ptr<World> world, Clock& clock)
        : world_(std::move(world)),
          clock_(clock),
          // Time that moves only when somebody waits for it cannot leave a caller behind.
          skips_(dynamic_cast<VirtualClock*>(&clock) == nullptr),
          scene_(world_->parts().options, world_->parts().view, world_->parts().room) {
        const Intrinsics& lens = world_->parts().view.intrinsics();
        depth_.resize(lens.width, lens.height);
        if (world_->options().colour) colour_.resize(lens.width, lens.height);
    }

  protected:
    Expected<CameraInfo> doOpen() override {
        if (world_->fault() == CameraFault::lost) {
            return Error{.code = ErrorCode::unavailable,
                         .cause = "the simulated camera is lost",
                         .mend = "end the fault with World::setFault",
                         .why = "a test or a technician asked the simulated world to lose it"};
        }
        const TimePoint now = clock_.now();
        zero_ = world_->startAt(now);
        next_ = std::max(next_, firstFrameNotBefore(now));
        restart_ = true;
        const WorldOptions& options = world_->options();
        return CameraInfo{.name = "simulated shopper",
                          .intrinsics = world_->parts().view.intrinsics(),
                          .framesPerSecond = options.framesPerSecond,
                          .mount = options.mount,
                          .colour = options.colour};
    }

    void doClose() override {}

    FrameStatus doWaitFrame(Duration timeout, DepthFrame& frame, Interrupt& interrupt) override {
        const TimePoint called = clock_.now();
        const TimePoint limit = called + std::max(timeout, Duration::zero());
        for (;;) {
            const CameraFault fault = world_->fault();
            if (fault == CameraFault::lost) return FrameStatus::lost;
            const TimePoint now = clock_.now();
            if (fault == CameraFault::stalled) {
                // What the sensor did not send is lost.
                next_ = std::max(next_, firstFrameNotBefore(now));
                if (now >= limit) return FrameStatus::timedOut;
                if (!clock_.waitUntil(std::min(limit, now + kFaultPoll), interrupt)) return FrameStatus::closed;
                next_ = std::max(next_, firstFrameNotBefore(clock_.now()));
                continue;
            }
            const Duration delay = fault == CameraFault::late ? world_->lateness() : Duration::zero();
            if (skips_) next_ = std::max(next_, lastFrameBefore(now - delay));
            const TimePoint due = dueTime(next_) + delay;
            if (due <= now) {
                deliver(fault == CameraFault::garbage, frame);
                return FrameStatus::frame;
            }
            if (now >= limit) return FrameStatus::timedOut;
            if (!clock_.waitUntil(std::min(due, limit), interrupt)) return FrameStatus::closed;
        }
    }

  private:
    [[nodiscard]] TimePoint dueTime(std::uint64_t frame) const { return zero_ + fromSeconds(world_->timeOf(frame)); }
    [[nodiscard]] std::uint64_t lastFrameBefore(TimePoint now) const {
        if (now <= zero_) return 0;
        auto frame = static_cast<std::uint64_t>(seconds(now - zero_) * world_->options().framesPerSecond + 1.0);
        while (frame > 0 && dueTime(frame) > now)
            --frame;
        return frame;
    }
    [[nodiscard]] std::uint64_t firstFrameNotBefore(TimePoint now) const {
        const std::uint64_t last = lastFrameBefore(now);
        return dueTime(last) < now ? last + 1 : last;
    }

    void deliver(bool garbage, DepthFrame& frame) {
        scene_.render(next_, world_->timeOf(next_), depth_.view(), colour_.view());
        if (garbage) {
            const std::uint32_t key = scramble(world_->options().seed, static_cast<std::uint32_t>(next_));
            std::uint32_t counter = 0;
            for (std::uint16_t& reading : depth_.pixels) {
                reading = static_cast<std::uint16_t>(scramble(key, counter++) & 0xffffU);
            }
        }
        frame = DepthFrame{.sequence = next_,
                           .sourceIndex = next_,
                           .captureTime = dueTime(next_),
                           .restart = std::exchange(restart_, false),
                           .lastOfStill = true,
                           .intrinsics = world_->parts().view.intrinsics(),
                           .depth = depth_.view(),
                           .colour = colour_.view()};
        ++next_;
    }

    std::shared_ptr<World> world_;
    Clock& clock_;
    bool skips_;
    Scene scene_;
    Image<std::uint16_t> depth_;
    Image<Rgb8> colour_;
    TimePoint zero_{};
    std::uint64_t next_ = 0;  ///< The frame to deliver next.
    bool restart_ = true;
};

}  // namespace

std::unique_ptr<DepthCamera> makeSimulatedCamera(std::shared_ptr<World> world, Clock& clock) {
    return std::make_unique<SimulatedCamera>(std::move(world), clock);
}

}  // namespace cheval::hal::sim

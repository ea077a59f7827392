#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "hal/sim/motion.h"
#include "hal/sim/world.h"
#include "hal/sim/world_parts.h"

namespace cheval::hal::sim {

namespace {

constexpr std::uint64_t kWaitingEvents = 64;  ///< The bound that hal/buttons.h names.
constexpr std::uint64_t kEventsPerVisit = 2 * kNextPresses.size();

/// The script's events are numbered from the world's zero, so that what waits is two numbers and needs no queue.
class SimulatedButtons final : public Buttons {
  public:
    SimulatedButtons(std::shared_ptr<World> world, Clock& clock) : world_(std::move(world)), clock_(clock) {}

    [[nodiscard]] std::uint64_t dropped() const override { return dropped_; }

  protected:
    Expected<std::size_t> doPoll(std::span<ButtonEvent> events) override {
        const TimePoint now = clock_.now();
        zero_ = world_->startAt(now);
        if (world_->options().script != Script::visit) return std::size_t{0};
        const std::uint64_t happened = eventsUntil(now);
        if (happened - delivered_ > kWaitingEvents) {
            const std::uint64_t lost = happened - delivered_ - kWaitingEvents;
            dropped_ += lost;
            delivered_ += lost;
        }
        std::size_t count = 0;
        while (count < events.size() && delivered_ < happened)
            events[count++] = event(delivered_++);
        return count;
    }

  private:
    [[nodiscard]] ButtonEvent event(std::uint64_t number) const {
        const WorldOptions& options = world_->options();
        const std::uint64_t visit = number / kEventsPerVisit;
        const std::uint64_t within = number % kEventsPerVisit;
        const bool release = within % 2 == 1;
        const double script = kNextPresses[within / 2] + (release ? kPressSeconds : 0.0);
        const double time = static_cast<double>(visit) * (options.visitSeconds + options.pauseSeconds) +
                            script * options.visitSeconds / kScriptSeconds;
        return {.button = Button::next,
                .action = release ? ButtonAction::released : ButtonAction::pressed,
                .time = zero_ + fromSeconds(time)};
    }
    [[nodiscard]] std::uint64_t eventsUntil(TimePoint now) const {
        const WorldOptions& options = world_->options();
        const double elapsed = std::max(0.0, seconds(now - zero_));
        const auto visits = static_cast<std::uint64_t>(elapsed / (options.visitSeconds + options.pauseSeconds));
        std::uint64_t number = (visits > 0 ? visits - 1 : 0) * kEventsPerVisit;
        while (event(number).time <= now)
            ++number;
        return number;
    }

    std::shared_ptr<World> world_;
    Clock& clock_;
    TimePoint zero_{};
    std::uint64_t delivered_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace

std::unique_ptr<Buttons> makeSimulatedButtons(std::shared_ptr<World> world, Clock& clock) {
    return std::make_unique<SimulatedButtons>(std::move(world), clock);
}

}  // namespace cheval::hal::sim

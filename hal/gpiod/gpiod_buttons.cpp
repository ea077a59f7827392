#include "hal/gpiod/gpiod_buttons.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace cheval::hal {

namespace {

constexpr std::size_t kWaitingEvents = 64;  ///< The bound that hal/buttons.h names.
/// Of one line in one poll: bounce is a few dozen edges, and what a broken line sends beyond is read by the next poll.
constexpr std::size_t kEdges = 16;
constexpr int kReads = 64;

std::string_view nameOf(Button button) {
    constexpr std::array<std::string_view, 5> kNames = {"next", "previous", "view", "service", "wake"};
    return kNames.at(static_cast<std::size_t>(button));
}

class GpiodButtonsImplementation final : public GpiodButtons {
  public:
    GpiodButtonsImplementation(const GpiodButtonsOptions& options, std::unique_ptr<LineProvider> provider,
                               const Clock& clock)
        : options_(options), provider_(std::move(provider)), clock_(clock), pause_(options.firstPause) {
        wires_.reserve(options.wirings.size());
        for (const ButtonWiring& wiring : options.wirings)
            wires_.push_back({.wiring = wiring, .line = nullptr, .filter = ButtonFilter(options.times)});
        waiting_.reserve(kWaitingEvents + 1);
    }

    [[nodiscard]] std::uint64_t dropped() const override { return dropped_; }
    [[nodiscard]] bool stuck(Button button) const override {
        return std::any_of(wires_.begin(), wires_.end(),
                           [button](const Wire& wire) { return wire.wiring.button == button && wire.filter.stuck(); });
    }

  protected:
    Expected<std::size_t> doPoll(std::span<ButtonEvent> events) override {
        const TimePoint now = clock_.now();
        if (!requested_ && now >= retryAt_) request(now);
        if (requested_) gather(now);
        const std::size_t count = std::min(events.size(), waiting_.size());
        std::copy_n(waiting_.begin(), count, events.begin());
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
        // What was pressed is told before what is wrong.
        if (count == 0 && fault_) return *fault_;
        return count;
    }

  private:
    struct Wire {
        ButtonWiring wiring;
        std::unique_ptr<InputLine> line;
        ButtonFilter filter;
    };

    void fail(Error error, TimePoint now) {
        for (Wire& wire : wires_)
            wire.line.reset();
        requested_ = false;
        stuckTold_ = false;
        fault_ = std::move(error);
        retryAt_ = now + pause_;
        pause_ = std::min(pause_ * 2, options_.longestPause);
    }

    void request(TimePoint now) {
        for (Wire& wire : wires_) {
            Expected<std::unique_ptr<InputLine>> line = provider_->input(wire.wiring.line);
            if (!line)
                return fail(std::move(line).error().within("button " + std::string(nameOf(wire.wiring.button))), now);
            wire.line = std::move(*line);
            const Expected<bool> active = wire.line->active();
            if (!active) return fail(active.error(), now);
            wire.filter.begin(*active, now);
        }
        requested_ = true;
        fault_.reset();
    }

    void gather(TimePoint now) {
        const std::size_t before = waiting_.size();
        for (Wire& wire : wires_) {
            std::array<LineEdge, kEdges> edges;
            std::size_t got = kEdges;
            for (int reads = 0; reads < kReads && got == kEdges; ++reads) {
                const Expected<std::size_t> count = wire.line->read(edges);
                if (!count) return fail(count.error(), now);
                got = std::min(*count, edges.size());
                for (std::size_t i = 0; i < got; ++i) {
                    take(wire, edges.at(i).time);
                    wire.filter.edge(edges.at(i).active, edges.at(i).time);
                }
            }
            take(wire, now);
        }
        pause_ = options_.firstPause;
        // Lines are read one after another; what happened is told in its own order.
        // By insertion, which takes no memory.
        for (std::size_t i = before + 1; i < waiting_.size(); ++i) {
            for (std::size_t j = i; j > before && waiting_[j].time < waiting_[j - 1].time; --j)
                std::swap(waiting_[j], waiting_[j - 1]);
        }
        tellStuck();
    }

    void take(Wire& wire, TimePoint time) {
        while (std::optional<ButtonEvent> event = wire.filter.advance(time)) {
            event->button = wire.wiring.button;
            waiting_.push_back(*event);
            if (waiting_.size() <= kWaitingEvents) continue;
            waiting_.erase(waiting_.begin());
            ++dropped_;
        }
    }

    void tellStuck() {
        const auto wire =
            std::find_if(wires_.begin(), wires_.end(), [](const Wire& any) { return any.filter.stuck(); });
        const bool any = wire != wires_.end();
        if (any == stuckTold_) return;
        stuckTold_ = any;
        fault_.reset();
        if (!any) return;
        fault_ = Error{.code = ErrorCode::unavailable,
                       .cause = "the button " + std::string(nameOf(wire->wiring.button)) + " is stuck",
                       .mend = "free it, and look at its cable: a short looks the same"};
    }

    GpiodButtonsOptions options_;
    std::unique_ptr<LineProvider> provider_;
    const Clock& clock_;
    std::vector<Wire> wires_;
    std::vector<ButtonEvent> waiting_;
    std::uint64_t dropped_ = 0;
    bool requested_ = false;
    bool stuckTold_ = false;
    std::optional<Error> fault_;
    TimePoint retryAt_{};
    Duration pause_;
};

}  // namespace

std::unique_ptr<GpiodButtons> makeGpiodButtons(const GpiodButtonsOptions& options,
                                               std::unique_ptr<LineProvider> provider, const Clock& clock) {
    return std::make_unique<GpiodButtonsImplementation>(options, std::move(provider), clock);
}

}  // namespace cheval::hal

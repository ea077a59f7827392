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
/// So many edges of a line the kernel keeps; it loses what comes beyond.
constexpr std::size_t kEdges = 16;
/// Of one line in one poll; what a broken line sends beyond is read by the next.
constexpr int kReads = 64;

std::string_view nameOf(Button button) {
    constexpr std::array<std::string_view, 5> kNames = {"next", "previous", "view", "service", "wake"};
    return kNames.at(static_cast<std::size_t>(button));
}

class GpiodButtonsImplementation final : public GpiodButtons {
  public:
    GpiodButtonsImplementation(const GpiodButtonsOptions& options, std::unique_ptr<LineProvider> provider,
                               const Clock& clock)
        : options_(options), provider_(std::move(provider)), clock_(clock) {
        wires_.reserve(options.wirings.size());
        for (const ButtonWiring& wiring : options.wirings)
            wires_.push_back({.wiring = wiring,
                              .line = nullptr,
                              .filter = ButtonFilter(options.times),
                              .fault = std::nullopt,
                              .pause = options.firstPause});
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
        for (Wire& wire : wires_) {
            if (wire.line == nullptr && now >= wire.retryAt) request(wire, now);
            if (wire.line != nullptr) gather(wire, now);
        }
        const std::size_t count = std::min(events.size(), waiting_.size());
        std::copy_n(waiting_.begin(), count, events.begin());
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
        if (count > 0) {
            told_ = events[count - 1].time;
            return count;
        }
        // What was pressed is told before what is wrong.
        const auto wrong =
            std::find_if(wires_.begin(), wires_.end(), [](const Wire& wire) { return wire.fault.has_value(); });
        if (wrong != wires_.end()) return *wrong->fault;
        return count;
    }

  private:
    struct Wire {
        ButtonWiring wiring;
        std::unique_ptr<InputLine> line;
        ButtonFilter filter;
        std::optional<Error> fault;
        TimePoint retryAt{};
        Duration pause{};
        bool stuckTold = false;
    };

    void fail(Wire& wire, Error error, TimePoint now) {
        if (const std::optional<ButtonEvent> event = wire.filter.end(now)) add(wire, *event);
        wire.line.reset();
        wire.stuckTold = false;
        wire.fault = std::move(error).within("button " + std::string(nameOf(wire.wiring.button)));
        wire.retryAt = now + wire.pause;
        wire.pause = std::min(wire.pause * 2, options_.longestPause);
    }

    void request(Wire& wire, TimePoint now) {
        Expected<std::unique_ptr<InputLine>> line = provider_->input(wire.wiring.line);
        if (!line) return fail(wire, std::move(line).error(), now);
        wire.line = std::move(*line);
        const Expected<bool> active = wire.line->active();
        if (!active) return fail(wire, active.error(), now);
        wire.filter.begin(*active, now);
        wire.fault.reset();
    }

    void gather(Wire& wire, TimePoint now) {
        std::array<LineEdge, kEdges> edges;
        std::size_t got = kEdges;
        std::size_t seen = 0;
        for (int reads = 0; reads < kReads && got == kEdges; ++reads) {
            const Expected<std::size_t> count = wire.line->read(edges);
            if (!count) return fail(wire, count.error(), now);
            got = std::min(*count, edges.size());
            seen += got;
            for (std::size_t i = 0; i < got; ++i) {
                take(wire, edges.at(i).time);
                wire.filter.edge(edges.at(i).active, edges.at(i).time);
            }
        }
        take(wire, now);
        // The kernel's queue was full: edges after these may be lost, and with them what the level is.
        if (seen >= kEdges && got < kEdges) {
            const Expected<bool> active = wire.line->active();
            if (!active) return fail(wire, active.error(), now);
            wire.filter.edge(*active, now);
        }
        wire.pause = options_.firstPause;
        tellStuck(wire);
    }

    void take(Wire& wire, TimePoint time) {
        while (const std::optional<ButtonEvent> event = wire.filter.advance(time))
            add(wire, *event);
    }

    void add(const Wire& wire, ButtonEvent event) {
        event.button = wire.wiring.button;
        // One line waits out its bounce while another's news is told: what is told later is not older.
        event.time = std::max(event.time, told_);
        waiting_.push_back(event);
        // Lines are read one after another; what happened is told in its own order. By insertion, which takes no
        // memory.
        for (std::size_t i = waiting_.size() - 1; i > 0 && waiting_[i].time < waiting_[i - 1].time; --i)
            std::swap(waiting_[i], waiting_[i - 1]);
        if (waiting_.size() <= kWaitingEvents) return;
        waiting_.erase(waiting_.begin());
        ++dropped_;
    }

    static void tellStuck(Wire& wire) {
        if (wire.filter.stuck() == wire.stuckTold) return;
        wire.stuckTold = wire.filter.stuck();
        wire.fault.reset();
        if (!wire.stuckTold) return;
        wire.fault = Error{.code = ErrorCode::unavailable,
                           .cause = "the button " + std::string(nameOf(wire.wiring.button)) + " is stuck",
                           .mend = "free it, and look at its cable: a short looks the same"};
    }

    GpiodButtonsOptions options_;
    std::unique_ptr<LineProvider> provider_;
    const Clock& clock_;
    std::vector<Wire> wires_;
    std::vector<ButtonEvent> waiting_;
    std::uint64_t dropped_ = 0;
    TimePoint told_{};  ///< Of the last event that was given away.
};

}  // namespace

std::unique_ptr<GpiodButtons> makeGpiodButtons(const GpiodButtonsOptions& options,
                                               std::unique_ptr<LineProvider> provider, const Clock& clock) {
    return std::make_unique<GpiodButtonsImplementation>(options, std::move(provider), clock);
}

}  // namespace cheval::hal

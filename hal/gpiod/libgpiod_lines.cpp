// The one file that knows libgpiod, which is 1.6 here; 2.x has other names for the same things.
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <utility>

#include <gpiod.h>

#include "hal/gpiod/line_provider.h"

namespace cheval::hal {

namespace {

constexpr const char* kConsumer = "cheval";

struct ChipCloser {
    void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using Chip = std::unique_ptr<gpiod_chip, ChipCloser>;

/// A line with the chip that it lives on.
struct Found {
    Chip chip;
    gpiod_line* line = nullptr;
};

std::string nameOf(const LineWiring& wiring) {
    return wiring.chip.empty() ? "\"" + wiring.line + "\"" : "\"" + wiring.line + "\" of \"" + wiring.chip + "\"";
}

Error missing(const LineWiring& wiring, const std::string& what) {
    return {.code = ErrorCode::notFound,
            .cause = "the GPIO line " + nameOf(wiring) + " is not there: " + what,
            .mend = "compare the settings with what gpioinfo shows"};
}

std::optional<unsigned> offsetOf(const std::string& text) {
    unsigned offset = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), offset);
    if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return offset;
}

Expected<Found> findOnChip(const LineWiring& wiring) {
    Found found{.chip = Chip(gpiod_chip_open_lookup(wiring.chip.c_str()))};
    if (found.chip == nullptr) {
        if (errno == EACCES || errno == EPERM) {
            return Error{.code = ErrorCode::unavailable,
                         .cause = "the GPIO chip \"" + wiring.chip + "\" may not be opened",
                         .mend = "let the mirror's user into the group gpio"};
        }
        return missing(wiring, "there is no such chip");
    }
    if (const auto offset = offsetOf(wiring.line)) found.line = gpiod_chip_get_line(found.chip.get(), *offset);
    if (found.line == nullptr) found.line = gpiod_chip_find_line(found.chip.get(), wiring.line.c_str());
    if (found.line == nullptr) return missing(wiring, "the chip has no such line");
    return found;
}

Expected<Found> find(const LineWiring& wiring) {
    if (!wiring.chip.empty()) return findOnChip(wiring);
    gpiod_line* line = gpiod_line_find(wiring.line.c_str());
    if (line == nullptr) return missing(wiring, "no chip has a line of that name");
    return Found{.chip = Chip(gpiod_line_get_chip(line)), .line = line};
}

Error refused(const LineWiring& wiring, gpiod_line* line, int fault) {
    const char* consumer = gpiod_line_consumer(line);
    if (fault == EBUSY) {
        return {.code = ErrorCode::unavailable,
                .cause = "the GPIO line " + nameOf(wiring) + " is held by " +
                         (consumer != nullptr ? "\"" + std::string(consumer) + "\"" : std::string("another program")),
                .mend = "end that program, or name another line"};
    }
    return {.code = ErrorCode::unavailable,
            .cause = "the GPIO line " + nameOf(wiring) + " cannot be used: " + std::strerror(fault),
            .mend = "see whether the chip can do what the settings ask (bias, edges)"};
}

int flagsOf(const LineWiring& wiring) {
    int flags = wiring.activeLow ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
    switch (wiring.bias) {
        case LineBias::asIs:
            break;
        case LineBias::disabled:
            flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
            break;
        case LineBias::pullUp:
            flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
            break;
        case LineBias::pullDown:
            flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
            break;
    }
    return flags;
}

Error gone() {
    return {.code = ErrorCode::unavailable,
            .cause = std::string("a GPIO line cannot be read any more: ") + std::strerror(errno),
            .mend = "see whether its chip is still there; it is asked for again by itself"};
}

class GpiodInput final : public InputLine {
  public:
    explicit GpiodInput(Found found) : found_(std::move(found)) {}
    ~GpiodInput() override { gpiod_line_release(found_.line); }
    GpiodInput(const GpiodInput&) = delete;
    GpiodInput& operator=(const GpiodInput&) = delete;

    Expected<std::size_t> read(std::span<LineEdge> edges) override {
        const timespec now{};
        const int waiting = edges.empty() ? 0 : gpiod_line_event_wait(found_.line, &now);
        if (waiting < 0) return gone();
        if (waiting == 0) return std::size_t{0};
        std::array<gpiod_line_event, 16> events{};
        const auto room = static_cast<unsigned>(std::min(edges.size(), events.size()));
        const int count = gpiod_line_event_read_multiple(found_.line, events.data(), room);
        if (count < 0) return gone();
        for (int i = 0; i < count; ++i) {
            const gpiod_line_event& event = events.at(static_cast<std::size_t>(i));
            edges[static_cast<std::size_t>(i)] = {
                .active = event.event_type == GPIOD_LINE_EVENT_RISING_EDGE,
                .time = TimePoint(std::chrono::seconds(event.ts.tv_sec) + std::chrono::nanoseconds(event.ts.tv_nsec))};
        }
        return static_cast<std::size_t>(count);
    }
    Expected<bool> active() override {
        const int value = gpiod_line_get_value(found_.line);
        if (value < 0) return gone();
        return value == 1;
    }

  private:
    Found found_;
};

class GpiodOutput final : public OutputLine {
  public:
    explicit GpiodOutput(Found found) : found_(std::move(found)) {}
    ~GpiodOutput() override { gpiod_line_release(found_.line); }
    GpiodOutput(const GpiodOutput&) = delete;
    GpiodOutput& operator=(const GpiodOutput&) = delete;

    Expected<void> set(bool active) override {
        if (gpiod_line_set_value(found_.line, active ? 1 : 0) != 0) return gone();
        return {};
    }

  private:
    Found found_;
};

class GpiodLines final : public LineProvider {
  public:
    Expected<std::unique_ptr<InputLine>> input(const LineWiring& wiring) override {
        Expected<Found> found = find(wiring);
        if (!found) return std::move(found).error();
        if (gpiod_line_request_both_edges_events_flags(found->line, kConsumer, flagsOf(wiring)) != 0)
            return refused(wiring, found->line, errno);
        return std::unique_ptr<InputLine>(std::make_unique<GpiodInput>(std::move(*found)));
    }
    Expected<std::unique_ptr<OutputLine>> output(const LineWiring& wiring, bool active) override {
        Expected<Found> found = find(wiring);
        if (!found) return std::move(found).error();
        if (gpiod_line_request_output_flags(found->line, kConsumer, flagsOf(wiring), active ? 1 : 0) != 0)
            return refused(wiring, found->line, errno);
        return std::unique_ptr<OutputLine>(std::make_unique<GpiodOutput>(std::move(*found)));
    }
};

}  // namespace

std::unique_ptr<LineProvider> makeGpiodLines() {
    return std::make_unique<GpiodLines>();
}

}  // namespace cheval::hal

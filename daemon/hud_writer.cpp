#include "daemon/hud_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <string>

#include "fitting/body/size_words.h"

namespace cheval::daemon {

namespace {

/// Joins two texts with a blank line's worth of space into fixed memory.
template <std::size_t Capacity>
void join(std::string_view first, std::string_view second, render::FixedText<Capacity>& text) {
    static constexpr std::string_view kBetween = "  |  ";
    std::array<char, Capacity> bytes{};
    std::size_t length = 0;
    const auto append = [&bytes, &length](std::string_view part) {
        const std::size_t count = std::min(part.size(), Capacity - length);
        std::copy_n(part.begin(), count, bytes.begin() + static_cast<std::ptrdiff_t>(length));
        length += count;
    };
    append(first);
    if (!first.empty() && !second.empty()) append(kBetween);
    append(second);
    text.assign({bytes.data(), length});
}

render::HandCursor cursorOf(const fitting::Hand& hand, const HudSources& sources) {
    render::HandCursor cursor{.state = hand.state};
    const Eigen::Vector3f sensor = sources.placement->toSensor(hand.position);
    if (!hand.raised || !(sensor.z() > 0.0F)) return cursor;
    const Eigen::Vector2f pixel = fitting::project(sources.intrinsics, sensor);
    const Eigen::Vector3f display = sources.mapping->displayFromSensor() * Eigen::Vector3f(pixel.x(), pixel.y(), 1.0F);
    cursor.position = {display.x() / static_cast<float>(sources.displayWidth),
                       display.y() / static_cast<float>(sources.displayHeight)};
    cursor.visible = (cursor.position.array() >= 0.0F).all() && (cursor.position.array() <= 1.0F).all();
    return cursor;
}

render::Screen screenOf(const HudSources& sources) {
    if (sources.session->serviceScreen() || !sources.fault.empty()) return render::Screen::service;
    if (sources.away) return render::Screen::attract;
    switch (sources.session->state()) {
        case SessionState::idle:
            return sources.showNotice ? render::Screen::service : render::Screen::attract;
        case SessionState::approaching:
            return sources.showNotice ? render::Screen::service : render::Screen::acquiring;
        case SessionState::acquiring:
        case SessionState::leaving:
            return render::Screen::acquiring;
        case SessionState::wearing:
            return render::Screen::wearing;
    }
    return render::Screen::attract;
}

std::string_view promptOf(SessionState state) {
    switch (state) {
        case SessionState::idle:
            return "Step up and try something on";
        case SessionState::approaching:
            return "Welcome! Come a little closer";
        case SessionState::acquiring:
            return "Face the mirror, arms a little away from your body";
        case SessionState::wearing:
            return "Swipe with a hand to change";
        case SessionState::leaving:
            return "Step back into the picture to go on";
    }
    return "";
}

/// Text on its way into fixed memory; what is too long is cut.
class Line {
  public:
    void add(std::string_view part) { length_ += part.copy(bytes_.data() + length_, bytes_.size() - length_); }
    void addCentimetres(float metres) {
        std::array<char, 16> digits{};
        const auto written =
            std::to_chars(digits.data(), digits.data() + digits.size(), 100.0F * metres, std::chars_format::fixed, 1);
        add(written.ec == std::errc() ? std::string_view(digits.data(), written.ptr) : std::string_view("?"));
    }
    [[nodiscard]] std::string_view view() const { return {bytes_.data(), length_}; }

  private:
    std::array<char, 512> bytes_{};
    std::size_t length_ = 0;
};

/// A new line of "stature 172.4 ± 0.6 cm, chest girth …", for a technician who asks; nothing where nothing is measured.
void addMeasurements(const fitting::Measurements& measurements, Line& line) {
    bool any = false;
    for (std::size_t i = 0; i < fitting::kDimensionCount; ++i) {
        const fitting::Measurement& measurement = measurements.dimensions[i];
        if (!measurement.valid) continue;
        line.add(any ? ", " : "\n");
        any = true;
        for (const char letter : fitting::kDimensionNames[i])
            line.add(letter == '_' ? std::string_view(" ") : std::string_view(&letter, 1));
        line.add(" ");
        line.addCentimetres(measurement.value);
        line.add(" ± ");
        line.addCentimetres(measurement.uncertainty);
        line.add(" cm");
    }
}

}  // namespace

std::string serviceText(const Error& error) {
    std::string text = std::filesystem::path(error.file).filename().string();
    if (text.empty()) text = error.file;
    if (!text.empty()) text += (error.line > 0 ? ":" + std::to_string(error.line) : "") + ": ";
    if (!error.key.empty()) text += error.key + ": ";
    text += error.cause;
    if (!error.mend.empty()) text += ". Mend: " + error.mend;
    return text;
}

void writeCarousel(const Wardrobe& wardrobe, render::HudState& hud) {
    hud.carouselCount = std::min(wardrobe.outfits.size(), render::kMaximumCarousel);
    for (std::size_t i = 0; i < hud.carouselCount; ++i)
        hud.carousel[i].name.assign(wardrobe.outfits[i].name);
}

void writeHud(const HudSources& sources, render::HudState& hud) {
    hud.screen = screenOf(sources);
    hud.carouselSelected = sources.session->outfit();
    hud.prompt.assign(sources.away ? std::string_view("One moment, the mirror will be back")
                                   : promptOf(sources.session->state()));
    fitting::AdviceText advice{};
    const bool told = sources.advice != nullptr && sources.session->dressed() && !sources.away;
    hud.advice.assign(told ? fitting::adviceInWords(*sources.advice, advice) : std::string_view());
    join(sources.fault, sources.notice, hud.service);
    if (hud.service.length == 0) hud.service.assign("All is well.");
    if (sources.session->serviceScreen() && sources.measurements != nullptr) {
        Line line;
        line.add(hud.service.view());
        addMeasurements(*sources.measurements, line);
        hud.service.assign(line.view());
    }
    for (std::size_t side = 0; side < fitting::kSideCount; ++side) {
        hud.cursors[side] = {};
        if (sources.session->dressed() && sources.hands != nullptr && sources.mapping != nullptr)
            hud.cursors[side] = cursorOf(sources.hands->hands[side], sources);
    }
}

}  // namespace cheval::daemon

#include "render/hud.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace cheval::render {
namespace {

enum Layer : std::size_t { kTitle, kPrompt, kCarousel, kAdvice, kService, kCursorOpen, kCursorClosed, kLayerCount };

constexpr double kDesignWidth = 1080.0;
constexpr double kDesignHeight = 1920.0;
constexpr int kCursorSize = 132;

/// Layers' places in the design: x, y, width, height. Cursors lie round their own middle.
struct Place {
    int x, y, width, height;
    bool bottom;  ///< Measured from the display's lower edge.
};
constexpr std::array<Place, kLayerCount> kPlaces = {{{0, 470, 1080, 560, false},
                                                     {60, 84, 960, 220, false},
                                                     {0, -330, 1080, 330, true},
                                                     {60, -497, 960, 163, true},
                                                     {80, 500, 920, 800, false},
                                                     {-66, -66, kCursorSize, kCursorSize, false},
                                                     {-66, -66, kCursorSize, kCursorSize, false}}};

constexpr std::string_view kName = "Cheval";
constexpr std::string_view kInvitation = "Step closer";

template <std::size_t Capacity>
bool same(const FixedText<Capacity>& a, const FixedText<Capacity>& b) {
    return a.view() == b.view();
}

bool sameCarousel(const HudState& a, const HudState& b) {
    if (a.carouselCount != b.carouselCount || a.carouselSelected != b.carouselSelected) return false;
    const std::size_t count = std::min(a.carouselCount, kMaximumCarousel);
    return std::equal(a.carousel.begin(), a.carousel.begin() + static_cast<std::ptrdiff_t>(count), b.carousel.begin(),
                      [](const CarouselItem& x, const CarouselItem& y) { return same(x.name, y.name); });
}

}  // namespace

Hud::Hud(int width, int height)
    : unit_(std::min(width / kDesignWidth, height / kDesignHeight)), width_(width), height_(height) {}

Expected<Hud> Hud::create(int width, int height) {
    Hud hud(width, height);
    const double side = (width - kDesignWidth * hud.unit_) / 2.0;
    for (std::size_t i = 0; i < kLayerCount; ++i) {
        const Place& place = kPlaces[i];
        const bool cursor = i >= kCursorOpen;
        const double top = place.bottom ? height : 0.0;
        auto layer = HudLayer::create(static_cast<int>(std::lround(place.x * hud.unit_ + (cursor ? 0.0 : side))),
                                      static_cast<int>(std::lround(top + place.y * hud.unit_)),
                                      std::max(static_cast<int>(std::lround(place.width * hud.unit_)), 1),
                                      std::max(static_cast<int>(std::lround(place.height * hud.unit_)), 1));
        if (!layer) return std::move(layer).error();
        hud.layers_.push_back(std::move(layer).value());
    }
    hud.layers_[kCursorOpen].redraw([&hud](Pen& pen) { hud.drawCursor(pen, fitting::HandState::open); });
    hud.layers_[kCursorClosed].redraw([&hud](Pen& pen) { hud.drawCursor(pen, fitting::HandState::closed); });
    return hud;
}

void Hud::refresh(const HudState& state) {
    const auto redraw = [this, &state](Layer layer, bool changed, auto drawOne) {
        if (!fresh_ || changed)
            layers_[layer].redraw([&](Pen& pen) {
                cairo_save(pen.cairo());
                cairo_scale(pen.cairo(), unit_, unit_);
                (this->*drawOne)(pen, state);
                cairo_restore(pen.cairo());
            });
    };
    const bool prompt = !same(state.prompt, drawn_.prompt);
    redraw(kTitle, prompt, &Hud::drawTitle);
    redraw(kPrompt, prompt, &Hud::drawPrompt);
    redraw(kCarousel, !sameCarousel(state, drawn_), &Hud::drawCarousel);
    redraw(kAdvice, !same(state.advice, drawn_.advice), &Hud::drawAdvice);
    redraw(kService, !same(state.service, drawn_.service), &Hud::drawService);
    drawn_ = state;
    fresh_ = true;
}

void Hud::draw(const HudState& state, hal::ImageView<hal::Rgba8> target) {
    refresh(state);
    switch (state.screen) {
        case Screen::attract:
            layers_[kTitle].blend(target);
            return;
        case Screen::service:
            layers_[kService].blend(target);
            return;
        case Screen::acquiring:
            layers_[kPrompt].blend(target);
            break;
        case Screen::wearing:
            layers_[kCarousel].blend(target);
            layers_[kAdvice].blend(target);
            layers_[kPrompt].blend(target);
            break;
    }
    for (const HandCursor& cursor : state.cursors) {
        if (!cursor.visible || !cursor.position.allFinite()) continue;
        const Eigen::Vector2f place = cursor.position.cwiseMax(0.0F).cwiseMin(1.0F);
        const Layer layer = cursor.state == fitting::HandState::closed ? kCursorClosed : kCursorOpen;
        layers_[layer].blend(target, static_cast<int>(place.x() * static_cast<float>(width_)),
                             static_cast<int>(place.y() * static_cast<float>(height_)));
    }
}

void Hud::drawTitle(Pen& pen, const HudState& state) const {
    const double width = kPlaces[kTitle].width;
    pen.text(kName, {.size = 190, .weight = PANGO_WEIGHT_LIGHT, .letterSpacing = 8}, 0, 0, width);
    pen.colour(1, 1, 1, 0.55);
    pen.fillRoundedBox(width / 2 - 60, 270, 120, 3, 1.5);
    const std::string_view prompt = state.prompt.length > 0 ? state.prompt.view() : kInvitation;
    pen.text(prompt, {.size = 68, .weight = PANGO_WEIGHT_NORMAL, .alpha = 0.92, .lines = 3}, 60, 320, width - 120);
}

void Hud::drawPrompt(Pen& pen, const HudState& state) const {
    if (state.prompt.length == 0) return;
    const double width = kPlaces[kPrompt].width;
    const TextStyle style{.size = 54, .weight = PANGO_WEIGHT_MEDIUM, .lines = 2};
    const auto [textWidth, textHeight] = pen.measure(state.prompt.view(), style, width - 120);
    const double box = textWidth + 112;
    pen.colour(0.07, 0.08, 0.10, 0.72);
    pen.fillRoundedBox((width - box) / 2, 0, box, textHeight + 56, 60);
    pen.text(state.prompt.view(), style, 60, 28, width - 120);
}

void Hud::drawCarousel(Pen& pen, const HudState& state) const {
    const std::size_t count = std::min(state.carouselCount, kMaximumCarousel);
    if (count == 0) return;
    const double width = kPlaces[kCarousel].width;
    const double height = kPlaces[kCarousel].height;
    // A veil that rises from the lower edge keeps the cards readable on any floor.
    cairo_pattern_t* veil = cairo_pattern_create_linear(0, 0, 0, height);
    cairo_pattern_add_color_stop_rgba(veil, 0.0, 0.04, 0.05, 0.06, 0.0);
    cairo_pattern_add_color_stop_rgba(veil, 1.0, 0.04, 0.05, 0.06, 0.78);
    cairo_set_source(pen.cairo(), veil);
    // Past the sides where the display is wider than the design; Cairo cuts it at the surface.
    cairo_rectangle(pen.cairo(), 0, 0, width, height);
    cairo_fill(pen.cairo());
    cairo_pattern_destroy(veil);

    const std::size_t selected = std::min(state.carouselSelected, count - 1);
    constexpr double kCard = 400;
    constexpr double kSideCard = 290;
    constexpr double kGap = 30;
    constexpr double kTop = 84;
    constexpr double kCardHeight = 132;
    const auto card = [&](std::size_t item, double x, double cardWidth, bool chosen) {
        const double inset = chosen ? 0 : 14;
        const double cardHeight = kCardHeight - 2 * inset;
        if (chosen)
            pen.colour(0.97, 0.96, 0.94, 0.97);
        else
            pen.colour(0.10, 0.11, 0.13, 0.66);
        pen.fillRoundedBox(x, kTop + inset, cardWidth, cardHeight, 32);
        if (!chosen) {
            pen.colour(1, 1, 1, 0.22);
            pen.strokeRoundedBox(x, kTop + inset, cardWidth, cardHeight, 32, 2);
        }
        const double ink = chosen ? 0.09 : 0.93;
        TextStyle style{.size = chosen ? 52.0 : 38.0,
                        .weight = chosen ? PANGO_WEIGHT_SEMIBOLD : PANGO_WEIGHT_NORMAL,
                        .red = ink,
                        .green = ink,
                        .blue = ink,
                        .lines = 2};
        const std::string_view name = state.carousel[item].name.view();
        // A name that needs two lines is set smaller, so that both stand in the card.
        const double line = pen.measure("H", style, cardWidth - 40).second;
        if (pen.measure(name, style, cardWidth - 40).second > 1.5 * line) style.size *= chosen ? 0.74 : 0.84;
        const double textHeight = pen.measure(name, style, cardWidth - 40).second;
        pen.text(name, style, x + 20, kTop + (kCardHeight - textHeight) / 2, cardWidth - 40);
    };
    const double middle = width / 2;
    if (selected > 0) card(selected - 1, middle - kCard / 2 - kGap - kSideCard, kSideCard, false);
    if (selected + 1 < count) card(selected + 1, middle + kCard / 2 + kGap, kSideCard, false);
    card(selected, middle - kCard / 2, kCard, true);
    // One dot a garment: how many there are, and where one is among them.
    constexpr double kPitch = 34;
    const double first = middle - kPitch * static_cast<double>(count - 1) / 2;
    for (std::size_t i = 0; i < count; ++i) {
        pen.colour(1, 1, 1, i == selected ? 0.95 : 0.35);
        pen.fillCircle(first + kPitch * static_cast<double>(i), kTop + kCardHeight + 52, i == selected ? 9 : 7);
    }
}

void Hud::drawAdvice(Pen& pen, const HudState& state) const {
    if (state.advice.length == 0) return;
    const double width = kPlaces[kAdvice].width;
    const TextStyle style{
        .size = 44, .weight = PANGO_WEIGHT_MEDIUM, .red = 0.09, .green = 0.09, .blue = 0.09, .lines = 2};
    const auto [textWidth, textHeight] = pen.measure(state.advice.view(), style, width - 80);
    // A second line rises into the picture; the last one always stands right above the cards.
    constexpr double kOneLineTop = 67;
    const double top = kOneLineTop + pen.measure("H", style, width - 80).second - textHeight;
    const double box = textWidth + 72;
    pen.colour(0.97, 0.96, 0.94, 0.9);
    pen.fillRoundedBox((width - box) / 2, top, box, textHeight + 32, 44);
    pen.text(state.advice.view(), style, 40, top + 16, width - 80);
}

void Hud::drawService(Pen& pen, const HudState& state) const {
    const double width = kPlaces[kService].width;
    const double height = kPlaces[kService].height;
    pen.colour(0.08, 0.09, 0.11, 0.94);
    pen.fillRoundedBox(0, 0, width, height, 48);
    pen.colour(0.96, 0.71, 0.26, 1);
    pen.fillRoundedBox(0, 0, width, 16, 8);
    constexpr double kLeft = 72;
    const double inner = width - 2 * kLeft;
    double y = 84;
    y += pen.text(
        "Service",
        {.size = 48, .weight = PANGO_WEIGHT_SEMIBOLD, .red = 0.96, .green = 0.71, .blue = 0.26, .align = Align::left},
        kLeft, y, inner);
    y += 36;
    // The first line says what happened, the rest what to do about it.
    const std::string_view text = state.service.view();
    const std::size_t line = std::min(text.find('\n'), text.size());
    // Alone it may fill the panel.
    const int lines = line < text.size() ? 6 : 10;
    y += pen.text(text.substr(0, line),
                  {.size = 50, .weight = PANGO_WEIGHT_MEDIUM, .align = Align::left, .lines = lines}, kLeft, y, inner);
    if (line < text.size())
        pen.text(text.substr(line + 1), {.size = 44, .alpha = 0.8, .align = Align::left, .lines = 6}, kLeft, y + 36,
                 inner);
}

void Hud::drawCursor(Pen& pen, fitting::HandState hand) const {
    cairo_t* cairo = pen.cairo();
    cairo_save(cairo);
    cairo_scale(cairo, unit_, unit_);
    constexpr double kMiddle = kCursorSize / 2.0;
    const bool closed = hand == fitting::HandState::closed;
    pen.colour(0.05, 0.06, 0.08, 0.55);
    pen.fillCircle(kMiddle, kMiddle, 64);
    pen.colour(closed ? 0.96 : 0.97, closed ? 0.71 : 0.96, closed ? 0.26 : 0.94, 0.95);
    cairo_new_sub_path(cairo);
    cairo_arc(cairo, kMiddle, kMiddle, 58, 0, 2 * std::numbers::pi);
    cairo_set_line_width(cairo, 6);
    cairo_stroke(cairo);
    // A palm, with fingers stretched or folded.
    pen.fillRoundedBox(kMiddle - 22, kMiddle - 8, 44, 40, 15);
    cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
    cairo_set_line_width(cairo, 10);
    for (int finger = 0; finger < 4; ++finger) {
        const double x = kMiddle - 17 + 11.4 * finger;
        const double length = closed ? 10 : (finger == 0 || finger == 3 ? 24 : 31);
        cairo_move_to(cairo, x, kMiddle - 4);
        cairo_line_to(cairo, x, kMiddle - 4 - length);
        cairo_stroke(cairo);
    }
    cairo_move_to(cairo, kMiddle - 20, kMiddle + 14);
    if (closed)
        cairo_line_to(cairo, kMiddle - 6, kMiddle + 4);
    else
        cairo_line_to(cairo, kMiddle - 33, kMiddle + 2);
    cairo_stroke(cairo);
    cairo_restore(cairo);
}

}  // namespace cheval::render

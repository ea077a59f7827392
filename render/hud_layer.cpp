#include "render/hud_layer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <utility>

namespace cheval::render {
namespace {

/// The first of these that is installed; the last has Latin, Greek and Cyrillic on every Debian that the list of
/// packages made.
constexpr const char* kFamilies = "Inter, DejaVu Sans";

void roundedBox(cairo_t* cairo, double x, double y, double width, double height, double radius) {
    constexpr double kQuarter = std::numbers::pi / 2.0;
    const double r = std::min({radius, width / 2.0, height / 2.0});
    cairo_new_sub_path(cairo);
    cairo_arc(cairo, x + width - r, y + r, r, -kQuarter, 0.0);
    cairo_arc(cairo, x + width - r, y + height - r, r, 0.0, kQuarter);
    cairo_arc(cairo, x + r, y + height - r, r, kQuarter, 2.0 * kQuarter);
    cairo_arc(cairo, x + r, y + r, r, 2.0 * kQuarter, 3.0 * kQuarter);
    cairo_close_path(cairo);
}

}  // namespace

void Pen::colour(double red, double green, double blue, double alpha) {
    cairo_set_source_rgba(cairo_, red, green, blue, alpha);
}

void Pen::fillRoundedBox(double x, double y, double width, double height, double radius) {
    roundedBox(cairo_, x, y, width, height, radius);
    cairo_fill(cairo_);
}

void Pen::strokeRoundedBox(double x, double y, double width, double height, double radius, double line) {
    roundedBox(cairo_, x, y, width, height, radius);
    cairo_set_line_width(cairo_, line);
    cairo_stroke(cairo_);
}

void Pen::fillCircle(double x, double y, double radius) {
    cairo_new_sub_path(cairo_);
    cairo_arc(cairo_, x, y, radius, 0.0, 2.0 * std::numbers::pi);
    cairo_fill(cairo_);
}

void Pen::set(std::string_view text, const TextStyle& style, double width) {
    PangoFontDescription* font = pango_font_description_from_string(kFamilies);
    pango_font_description_set_absolute_size(font, style.size * PANGO_SCALE);
    pango_font_description_set_weight(font, static_cast<PangoWeight>(style.weight));
    pango_layout_set_font_description(layout_, font);
    pango_font_description_free(font);
    PangoAttrList* attributes = pango_attr_list_new();
    pango_attr_list_insert(attributes,
                           pango_attr_letter_spacing_new(static_cast<int>(style.letterSpacing * PANGO_SCALE)));
    pango_layout_set_attributes(layout_, attributes);
    pango_attr_list_unref(attributes);
    pango_layout_set_width(layout_, static_cast<int>(width * PANGO_SCALE));
    pango_layout_set_height(layout_, -style.lines);
    pango_layout_set_ellipsize(layout_, PANGO_ELLIPSIZE_END);
    pango_layout_set_wrap(layout_, PANGO_WRAP_WORD_CHAR);
    pango_layout_set_alignment(layout_, style.align == Align::centre ? PANGO_ALIGN_CENTER : PANGO_ALIGN_LEFT);
    pango_layout_set_text(layout_, text.data(), static_cast<int>(text.size()));
    // Before anything is measured: text set for another scale is another width.
    pango_cairo_update_layout(cairo_, layout_);
}

std::pair<double, double> Pen::measure(std::string_view text, const TextStyle& style, double width) {
    set(text, style, width);
    int textWidth = 0;
    int textHeight = 0;
    pango_layout_get_pixel_size(layout_, &textWidth, &textHeight);
    return {textWidth, textHeight};
}

double Pen::text(std::string_view text, const TextStyle& style, double x, double y, double width) {
    const double height = measure(text, style, width).second;
    colour(style.red, style.green, style.blue, style.alpha);
    cairo_move_to(cairo_, x, y);
    pango_cairo_show_layout(cairo_, layout_);
    return height;
}

Expected<HudLayer> HudLayer::create(int x, int y, int width, int height) {
    HudLayer layer(x, y, width, height);
    layer.surface_.reset(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height));
    layer.cairo_.reset(cairo_create(layer.surface_.get()));
    layer.layout_.reset(pango_cairo_create_layout(layer.cairo_.get()));
    if (cairo_status(layer.cairo_.get()) != CAIRO_STATUS_SUCCESS)
        return Error{.code = ErrorCode::resource,
                     .cause = std::string("the head-up display has no surface to draw on: ") +
                              cairo_status_to_string(cairo_status(layer.cairo_.get())),
                     .mend = "check free memory"};
    layer.spans_.resize(static_cast<std::size_t>(height));
    return layer;
}

void HudLayer::redraw(const std::function<void(Pen&)>& draw) {
    cairo_t* cairo = cairo_.get();
    cairo_save(cairo);
    cairo_set_operator(cairo, CAIRO_OPERATOR_CLEAR);
    cairo_paint(cairo);
    cairo_restore(cairo);
    Pen pen(cairo, layout_.get());
    draw(pen);
    cairo_surface_flush(surface_.get());
    const unsigned char* data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    for (int y = 0; y < height_; ++y) {
        Span span{.first = width_, .last = 0};
        for (int x = 0; x < width_; ++x) {
            std::uint32_t pixel = 0;
            std::memcpy(&pixel, data + static_cast<std::ptrdiff_t>(y) * stride + 4 * x, sizeof pixel);
            if (pixel == 0) continue;
            span.first = std::min(span.first, x);
            span.last = x + 1;
        }
        spans_[static_cast<std::size_t>(y)] = span;
    }
}

void HudLayer::blend(hal::ImageView<hal::Rgba8> target, int dx, int dy) const {
    const unsigned char* data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    for (int y = 0; y < height_; ++y) {
        const int targetY = y_ + dy + y;
        if (targetY < 0 || targetY >= target.height) continue;
        const Span span = spans_[static_cast<std::size_t>(y)];
        const int left = x_ + dx;
        const int first = std::max(span.first, -left);
        const int last = std::min(span.last, target.width - left);
        if (first >= last) continue;
        auto* to = reinterpret_cast<std::uint8_t*>(target.row(targetY) + left + first);
        const unsigned char* from = data + static_cast<std::ptrdiff_t>(y) * stride + 4 * first;
        for (int x = first; x < last; ++x, from += 4, to += 4) {
            // Cairo's ARGB32: native-endian words, premultiplied.
            std::uint32_t pixel = 0;
            std::memcpy(&pixel, from, sizeof pixel);
            const std::uint32_t rest = 255U - (pixel >> 24U);
            const auto over = [rest](std::uint32_t drawn, std::uint8_t under) {
                const std::uint32_t product = under * rest + 127U;
                return static_cast<std::uint8_t>(
                    std::min(drawn + ((product + 1U + (product >> 8U)) >> 8U), std::uint32_t{255}));
            };
            to[0] = over((pixel >> 16U) & 255U, to[0]);
            to[1] = over((pixel >> 8U) & 255U, to[1]);
            to[2] = over(pixel & 255U, to[2]);
            to[3] = 255;
        }
    }
}

}  // namespace cheval::render

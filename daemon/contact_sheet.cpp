#include "daemon/contact_sheet.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>

#include <pango/pangocairo.h>

namespace cheval::daemon {
namespace {

// Pixels.
constexpr int kMargin = 32;
constexpr int kGap = 20;
constexpr int kTitleHeight = 92;
constexpr int kCaptionHeight = 44;
constexpr int kLargestSide = 32767;  // Cairo's.

struct Colour {
    double r, g, b;
};
constexpr Colour kPaper{0.965, 0.960, 0.950};
constexpr Colour kInk{0.13, 0.13, 0.15};
constexpr Colour kPaleInk{0.40, 0.40, 0.43};
constexpr Colour kFrame{0.80, 0.79, 0.77};

struct Release {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
    void operator()(PangoLayout* layout) const { g_object_unref(layout); }
    void operator()(PangoFontDescription* font) const { pango_font_description_free(font); }
};
template <typename T>
using Owned = std::unique_ptr<T, Release>;

/// Cairo's pixel: native-endian 0xAARRGGBB, here always opaque.
std::uint32_t toCairo(hal::Rgba8 pixel) {
    return 0xff000000U | static_cast<std::uint32_t>(pixel.r) << 16U | static_cast<std::uint32_t>(pixel.g) << 8U |
           pixel.b;
}

hal::Rgba8 fromCairo(std::uint32_t pixel) {
    return {static_cast<std::uint8_t>(pixel >> 16U), static_cast<std::uint8_t>(pixel >> 8U),
            static_cast<std::uint8_t>(pixel), 255};
}

/// Draws one line of text with its top left corner at (x, y) and returns how wide it came out, at most `width`.
int drawText(cairo_t* context, const std::string& text, const char* font, Colour colour, int x, int y, int width) {
    const Owned<PangoLayout> layout(pango_cairo_create_layout(context));
    const Owned<PangoFontDescription> description(pango_font_description_from_string(font));
    pango_layout_set_font_description(layout.get(), description.get());
    pango_layout_set_width(layout.get(), std::max(width, 0) * PANGO_SCALE);
    pango_layout_set_ellipsize(layout.get(), PANGO_ELLIPSIZE_END);
    pango_layout_set_single_paragraph_mode(layout.get(), TRUE);
    // Somebody else's words may be cut in the middle of a character; Pango wants valid UTF-8.
    const std::unique_ptr<char, void (*)(void*)> valid(g_utf8_make_valid(text.data(), static_cast<gssize>(text.size())),
                                                       g_free);
    pango_layout_set_text(layout.get(), valid.get(), -1);
    cairo_set_source_rgb(context, colour.r, colour.g, colour.b);
    cairo_move_to(context, x, y);
    pango_cairo_show_layout(context, layout.get());
    int textWidth = 0;
    pango_layout_get_pixel_size(layout.get(), &textWidth, nullptr);
    return textWidth;
}

void copyPicture(hal::ImageView<const hal::Rgba8> picture, cairo_surface_t* surface, int left, int top) {
    cairo_surface_flush(surface);
    unsigned char* data = cairo_image_surface_get_data(surface);
    const int stride = cairo_image_surface_get_stride(surface);
    for (int y = 0; y < picture.height; ++y) {
        unsigned char* row =
            data + static_cast<std::ptrdiff_t>(top + y) * stride + static_cast<std::ptrdiff_t>(left) * 4;
        for (int x = 0; x < picture.width; ++x) {
            const std::uint32_t pixel = toCairo(picture.at(x, y));
            std::memcpy(row + static_cast<std::ptrdiff_t>(x) * 4, &pixel, sizeof pixel);
        }
    }
    cairo_surface_mark_dirty(surface);
}

}  // namespace

Expected<hal::Image<hal::Rgba8>> drawContactSheet(const std::vector<SheetPicture>& pictures,
                                                  const ContactSheetOptions& options) {
    const bool anyEmpty =
        std::any_of(pictures.begin(), pictures.end(), [](const SheetPicture& entry) { return entry.picture.empty(); });
    if (pictures.empty() || anyEmpty || options.columns < 1) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "a contact sheet needs pictures and at least one column"};
    }
    int cellWidth = 0;
    int cellHeight = 0;
    for (const SheetPicture& entry : pictures) {
        cellWidth = std::max(cellWidth, entry.picture.width);
        cellHeight = std::max(cellHeight, entry.picture.height);
    }
    const auto count = static_cast<std::int64_t>(pictures.size());
    const std::int64_t columns = std::min<std::int64_t>(options.columns, count);
    const std::int64_t rows = (count + columns - 1) / columns;
    const std::int64_t width = 2 * kMargin + columns * cellWidth + (columns - 1) * kGap;
    const std::int64_t height =
        kMargin + kTitleHeight + rows * (cellHeight + kCaptionHeight) + (rows - 1) * kGap + kMargin;
    if (width > kLargestSide || height > kLargestSide) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the contact sheet would be larger than 32767 pixels",
                     .mend = "ask for fewer or smaller pictures"};
    }

    const Owned<cairo_surface_t> surface(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width), static_cast<int>(height)));
    const Owned<cairo_t> context(cairo_create(surface.get()));
    if (cairo_status(context.get()) != CAIRO_STATUS_SUCCESS) {
        return Error{.code = ErrorCode::resource,
                     .cause = std::string("the contact sheet cannot be drawn: ") +
                              cairo_status_to_string(cairo_status(context.get()))};
    }
    cairo_set_source_rgb(context.get(), kPaper.r, kPaper.g, kPaper.b);
    cairo_paint(context.get());
    const int textWidth = static_cast<int>(width) - 2 * kMargin;
    drawText(context.get(), options.title, "sans-serif Bold 30px", kInk, kMargin, kMargin - 4, textWidth);
    drawText(context.get(), options.subtitle, "sans-serif 18px", kPaleInk, kMargin, kMargin + 38, textWidth);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const SheetPicture& entry = pictures[i];
        const int column = static_cast<int>(static_cast<std::int64_t>(i) % columns);
        const int row = static_cast<int>(static_cast<std::int64_t>(i) / columns);
        const int left = kMargin + column * (cellWidth + kGap);
        const int top = kMargin + kTitleHeight + row * (cellHeight + kCaptionHeight + kGap);
        const int pictureLeft = left + (cellWidth - entry.picture.width) / 2;
        const int pictureTop = top + (cellHeight - entry.picture.height) / 2;
        cairo_set_source_rgb(context.get(), kFrame.r, kFrame.g, kFrame.b);
        cairo_rectangle(context.get(), pictureLeft - 1, pictureTop - 1, entry.picture.width + 2,
                        entry.picture.height + 2);
        cairo_fill(context.get());
        copyPicture(entry.picture, surface.get(), pictureLeft, pictureTop);
        const int textTop = top + cellHeight + 9;
        const int headingWidth =
            drawText(context.get(), entry.heading, "sans-serif Bold 17px", kInk, left, textTop, cellWidth);
        drawText(context.get(), entry.caption, "sans-serif 17px", kPaleInk, left + headingWidth + 10, textTop,
                 cellWidth - headingWidth - 10);
    }

    cairo_surface_flush(surface.get());
    hal::Image<hal::Rgba8> sheet(static_cast<int>(width), static_cast<int>(height));
    const unsigned char* data = cairo_image_surface_get_data(surface.get());
    const int stride = cairo_image_surface_get_stride(surface.get());
    for (int y = 0; y < sheet.height; ++y) {
        hal::Rgba8* row = sheet.view().row(y);
        for (int x = 0; x < sheet.width; ++x) {
            std::uint32_t pixel = 0;
            std::memcpy(&pixel, data + static_cast<std::ptrdiff_t>(y) * stride + static_cast<std::ptrdiff_t>(x) * 4,
                        sizeof pixel);
            row[x] = fromCairo(pixel);
        }
    }
    return sheet;
}

}  // namespace cheval::daemon

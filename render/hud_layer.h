// One piece of the head-up display, drawn by Cairo into a surface of its own and blended onto every frame: text is laid
// out when it changes and not before.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <cairo.h>
#include <pango/pangocairo.h>

#include "hal/expected.h"
#include "hal/image.h"

namespace cheval::render {

enum class Align { left, centre };

/// How text is set. Sizes in pixels of the surface.
struct TextStyle {
    double size = 40.0;
    int weight = PANGO_WEIGHT_NORMAL;
    double red = 1.0, green = 1.0, blue = 1.0, alpha = 1.0;
    Align align = Align::centre;
    int lines = 1;  ///< More than these end in an ellipsis.
    double letterSpacing = 0.0;
};

/// What a layer is drawn with; only valid while it is.
class Pen {
  public:
    Pen(cairo_t* cairo, PangoLayout* layout) : cairo_(cairo), layout_(layout) {}

    void colour(double red, double green, double blue, double alpha);
    void fillRoundedBox(double x, double y, double width, double height, double radius);
    void strokeRoundedBox(double x, double y, double width, double height, double radius, double line);
    void fillCircle(double x, double y, double radius);
    /// Sets text into a box of `width` with its top at y; returns its height.
    double text(std::string_view text, const TextStyle& style, double x, double y, double width);
    /// Width and height that text() would take within `width`.
    std::pair<double, double> measure(std::string_view text, const TextStyle& style, double width);
    [[nodiscard]] cairo_t* cairo() const { return cairo_; }

  private:
    void set(std::string_view text, const TextStyle& style, double width);

    cairo_t* cairo_;
    PangoLayout* layout_;
};

/// A surface of fixed size at a fixed place. Thread-bound.
class HudLayer {
  public:
    static Expected<HudLayer> create(int x, int y, int width, int height);

    /// Clears the surface and draws anew.
    void redraw(const std::function<void(Pen&)>& draw);
    /// Lays it over `target` at its place, moved by (dx, dy), cut at the edges.
    void blend(hal::ImageView<hal::Rgba8> target, int dx = 0, int dy = 0) const;
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }

  private:
    HudLayer(int x, int y, int width, int height) : x_(x), y_(y), width_(width), height_(height) {}

    struct Span {
        int first = 0, last = 0;  ///< Pixels of a row that are not empty; last is one past.
    };
    struct Release {
        void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
        void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
        void operator()(PangoLayout* layout) const { g_object_unref(layout); }
    };
    int x_, y_, width_, height_;
    std::unique_ptr<cairo_surface_t, Release> surface_;
    std::unique_ptr<cairo_t, Release> cairo_;
    std::unique_ptr<PangoLayout, Release> layout_;
    std::vector<Span> spans_;
};

}  // namespace cheval::render

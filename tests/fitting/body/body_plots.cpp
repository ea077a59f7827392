// Draws what body_visits wrote: how fast girths come right, and whether the tall and the short are measured alike.
//
//     body_plots FOLDER FILE.json...
//
// Writes FOLDER/convergence.png and FOLDER/error-by-stature.png with one colour a file's kind of clothes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <cairo.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "daemon/guarded_main.h"
#include "tests/fitting/tracking/visit_statistics.h"

namespace cheval::fitting::test {
namespace {

using nlohmann::json;

struct Colour {
    double red, green, blue;
};
constexpr Colour kInk{0.15, 0.16, 0.20};
constexpr Colour kFaint{0.86, 0.87, 0.90};
constexpr std::array<Colour, 4> kColours = {
    {{0.09, 0.40, 0.67}, {0.85, 0.42, 0.10}, {0.18, 0.55, 0.34}, {0.55, 0.27, 0.60}}};
constexpr std::array<const char*, 3> kGirths = {"chest_girth", "waist_girth", "hip_girth"};
constexpr std::array<const char*, 3> kTitles = {"chest", "waist", "hips"};

/// What one file holds.
struct Series {
    std::string name;
    json visits;
    Colour colour;
};

/// Metres that the value is off the truth, of a reading that tells it.
std::optional<double> errorOf(const json& visit, const json& reading, const char* girth) {
    const auto told = reading["values"].find(girth);
    if (told == reading["values"].end()) return std::nullopt;
    return (*told)[0].get<double>() - visit["truth"][girth].get<double>();
}

/// The multiples of `step` in a range.
std::vector<double> marks(double from, double to, double step) {
    std::vector<double> all;
    for (auto i = std::lround(std::ceil(from / step - 1e-9)); static_cast<double>(i) * step < to + 1e-9; ++i)
        all.push_back(static_cast<double>(i) * step);
    return all;
}

/// A row of panels with axes; x and y are in the units of the axes.
class Sheet {
  public:
    Sheet(const std::string& title, double fromX, double toX, double fromY, double toY)
        : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, kWidth, kHeight), cairo_surface_destroy),
          cairo_(cairo_create(surface_.get()), cairo_destroy),
          fromX_(fromX),
          toX_(toX),
          fromY_(fromY),
          toY_(toY) {
        cairo_set_source_rgb(pen(), 1.0, 1.0, 1.0);
        cairo_paint(pen());
        cairo_select_font_face(pen(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
        write(kLeft, 34.0, title, 21.0, 0.0, kInk);
    }
    /// Everything after is drawn into panel `panel`, whose axes are drawn now.
    void begin(int panel, const char* title, double stepX, double stepY, const char* unitX, const char* unitY) {
        left_ = kLeft + panel * (kPanel + kGap);
        write(left_, kTop - 12.0, title, 17.0, 0.0, kInk);
        for (const double y : marks(fromY_, toY_, stepY)) {
            line({{fromX_, y}, {toX_, y}}, kFaint, std::abs(y) < 1e-9 ? 2.0 : 1.0, false);
            write(left_ - 8.0, atY(y) + 5.0, fmt::format("{:g}", y), 14.0, 1.0, kInk);
        }
        for (const double x : marks(fromX_, toX_, stepX))
            write(atX(x), kTop + kTall + 20.0, fmt::format("{:g}", x), 14.0, 0.5, kInk);
        line({{fromX_, fromY_}, {toX_, fromY_}}, kInk, 1.0, false);
        line({{fromX_, fromY_}, {fromX_, toY_}}, kInk, 1.0, false);
        write(left_ + 0.5 * kPanel, kTop + kTall + 44.0, unitX, 14.0, 0.5, kInk);
        if (panel == 0) write(left_ - 8.0, kTop - 12.0, unitY, 14.0, 1.0, kInk);
    }
    void line(const std::vector<std::pair<double, double>>& points, const Colour& colour, double width, bool dashed) {
        cairo_save(pen());
        clip();
        colourPen(colour, 1.0);
        cairo_set_line_width(pen(), width);
        const std::array<double, 2> dash = {7.0, 5.0};
        cairo_set_dash(pen(), dash.data(), dashed ? 2 : 0, 0.0);
        for (std::size_t i = 0; i < points.size(); ++i)
            (i == 0 ? cairo_move_to : cairo_line_to)(pen(), atX(points[i].first), atY(points[i].second));
        cairo_stroke(pen());
        cairo_restore(pen());
    }
    void dot(double x, double y, const Colour& colour) {
        cairo_save(pen());
        clip();
        colourPen(colour, 0.55);
        cairo_arc(pen(), atX(x), atY(std::clamp(y, fromY_, toY_)), 3.2, 0.0, 6.2832);
        cairo_fill(pen());
        cairo_restore(pen());
    }
    /// Row `row` of the legend at the panel's top right, or a remark.
    void legend(int row, const std::string& text, const Colour& colour) {
        write(left_ + kPanel - 6.0, kTop + 18.0 + 20.0 * row, text, 14.0, 1.0, colour);
    }
    [[nodiscard]] bool save(const std::string& file) {
        return cairo_surface_write_to_png(surface_.get(), file.c_str()) == CAIRO_STATUS_SUCCESS;
    }

  private:
    static constexpr double kLeft = 66.0, kTop = 86.0, kPanel = 430.0, kTall = 380.0, kGap = 62.0;
    static constexpr int kWidth = 1500, kHeight = 530;

    [[nodiscard]] cairo_t* pen() const { return cairo_.get(); }
    [[nodiscard]] double atX(double x) const { return left_ + kPanel * (x - fromX_) / (toX_ - fromX_); }
    [[nodiscard]] double atY(double y) const { return kTop + kTall * (toY_ - y) / (toY_ - fromY_); }
    void colourPen(const Colour& colour, double share) {
        cairo_set_source_rgba(pen(), colour.red, colour.green, colour.blue, share);
    }
    void clip() {
        cairo_rectangle(pen(), left_ - 4.0, kTop - 4.0, kPanel + 8.0, kTall + 8.0);
        cairo_clip(pen());
    }
    /// `anchor`: the share of the text that lies left of x.
    void write(double x, double y, const std::string& text, double size, double anchor, const Colour& colour) {
        cairo_set_font_size(pen(), size);
        cairo_text_extents_t extents;
        cairo_text_extents(pen(), text.c_str(), &extents);
        colourPen(colour, 1.0);
        cairo_move_to(pen(), x - anchor * extents.x_advance, y);
        cairo_show_text(pen(), text.c_str());
    }

    std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
    std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
    double fromX_, toX_, fromY_, toY_;
    double left_ = kLeft;
};

Sheet convergence(const std::vector<Series>& all) {
    Sheet sheet("Absolute error of girths while the shopper faces the glass: median (line) and 90 % (dashed)", 0.0, 5.5,
                0.0, 80.0);
    for (int panel = 0; panel < 3; ++panel) {
        const char* girth = kGirths[static_cast<std::size_t>(panel)];
        sheet.begin(panel, kTitles[static_cast<std::size_t>(panel)], 1.0, 10.0, "seconds of facing", "mm");
        int row = 0;
        for (const Series& series : all) {
            std::vector<std::pair<double, double>> middle, most;
            for (std::size_t i = 0;; ++i) {
                std::vector<double> errors;
                double seconds = 0.0;
                for (const json& visit : series.visits) {
                    if (i >= visit["facing"].size()) continue;
                    const json& reading = visit["facing"][i];
                    seconds = reading["seconds"].get<double>();
                    if (const auto error = errorOf(visit, reading, girth)) errors.push_back(1000.0 * std::abs(*error));
                }
                if (seconds == 0.0) break;
                if (errors.size() < 3) continue;
                middle.emplace_back(seconds, quantile(errors, 0.5));
                most.emplace_back(seconds, quantile(errors, 0.9));
            }
            sheet.line(middle, series.colour, 2.5, false);
            sheet.line(most, series.colour, 1.8, true);
            sheet.legend(row++, middle.empty() ? series.name + ": nothing told" : series.name, series.colour);
        }
    }
    return sheet;
}

Sheet errorByStature(const std::vector<Series>& all) {
    Sheet sheet("Error of girths at the end of the visit, by stature", 1.45, 2.0, -100.0, 100.0);
    for (int panel = 0; panel < 3; ++panel) {
        const char* girth = kGirths[static_cast<std::size_t>(panel)];
        sheet.begin(panel, kTitles[static_cast<std::size_t>(panel)], 0.1, 20.0, "stature, m", "mm");
        int row = 0;
        for (const Series& series : all) {
            std::vector<double> errors;
            for (const json& visit : series.visits) {
                if (!visit["moments"].contains("end")) continue;
                const auto error = errorOf(visit, visit["moments"]["end"], girth);
                if (!error) continue;
                errors.push_back(std::abs(*error));
                sheet.dot(visit["truth"]["stature"].get<double>(), 1000.0 * *error, series.colour);
            }
            double sum = 0.0;
            for (const double error : errors)
                sum += error;
            sheet.legend(row++,
                         errors.empty() ? series.name + ": nothing told"
                                        : fmt::format("{}: mean |error| {:.0f} mm, {} told", series.name,
                                                      1000.0 * sum / static_cast<double>(errors.size()), errors.size()),
                         series.colour);
        }
    }
    return sheet;
}

int run(int count, char** words) {
    if (count < 3) {
        std::fprintf(stderr, "usage: body_plots FOLDER FILE.json...\n");
        return 2;
    }
    const std::string folder = words[1];
    std::vector<Series> all;
    for (int i = 2; i < count; ++i) {
        std::ifstream file(words[i]);
        json visits = json::parse(file, nullptr, false);
        if (!visits.is_array() || visits.empty()) {
            std::fprintf(stderr, "body_plots: %s holds no visits\n", words[i]);
            return 1;
        }
        std::string name = visits[0]["clothing"].get<std::string>();
        all.push_back({std::move(name), std::move(visits), kColours[all.size() % kColours.size()]});
    }
    if (!convergence(all).save(folder + "/convergence.png") ||
        !errorByStature(all).save(folder + "/error-by-stature.png")) {
        std::fprintf(stderr, "body_plots: cannot write into %s\n", folder.c_str());
        return 1;
    }
    return 0;
}

}  // namespace
}  // namespace cheval::fitting::test

int main(int count, char** words) {
    return cheval::daemon::guardedMain(cheval::fitting::test::run, count, words, 1);
}

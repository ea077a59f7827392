#include "fitting/bake/fabric.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fitting/bake/cloth_tools.h"
#include "fitting/bake/spline.h"

namespace cheval::fitting::bake {
namespace {

/// A point of a panel as its painter sees it; metres.
struct Spot {
    Panel panel;
    double u, v;
    double fromTop, fromBottom;  ///< To the panel's upper and lower edge.
    double fromSide;             ///< To the nearer side edge.
    int x, y;                    ///< Pixel.
};

double pixelNoise(int x, int y) {
    auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
    h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
    h = (h ^ (h >> 13U)) * 0x297A2D39U;
    return static_cast<double>(h >> 8U) / 8388607.5 - 1.0;
}

/// 1 on a line of that half-width, fading to 0 over a pixel.
double line(double distance, double halfWidth) {
    return smoothStep(halfWidth + 0.0010, std::max(halfWidth - 0.0003, 0.0), std::abs(distance));
}

/// Stitches along a line: `along` metres on it, `distance` from it.
double stitches(double along, double distance) {
    const double phase = along / 0.0042 - std::floor(along / 0.0042);
    return line(distance, 0.0006) * smoothStep(0.02, 0.14, phase) * smoothStep(0.86, 0.70, phase);
}

bool isSleeve(Panel panel) {
    return panel == Panel::leftSleeve || panel == Panel::rightSleeve;
}

/// The mirror mark: an oval glass on its stand. 1 inside the ink.
double mirrorMark(double u, double v) {
    const double oval = std::hypot(u / 0.030, v / 0.044);
    const double ring = line((oval - 1.0) * 0.036, 0.0021);
    const double glint = line((u - v) * std::numbers::sqrt2 / 2.0 + 0.006, 0.0012) * smoothStep(0.75, 0.65, oval) +
                         line((u - v) * std::numbers::sqrt2 / 2.0 - 0.003, 0.0008) * smoothStep(0.60, 0.50, oval);
    const bool besidePost = v > -0.030 && v < 0.056;
    const double posts = besidePost ? line(std::abs(u) - 0.039, 0.0014) : 0.0;
    const double pivots = std::abs(v) < 0.0016 && std::abs(u) > 0.030 && std::abs(u) < 0.039 ? 1.0 : 0.0;
    const double foot =
        v > 0.040 && v < 0.062 ? line(std::abs(u) - 0.039 - 0.35 * std::max(v - 0.050, 0.0), 0.0016) : 0.0;
    const double bar = std::abs(u) < 0.039 ? line(v - 0.052, 0.0013) : 0.0;
    return std::max({ring, 0.8 * glint, posts, pivots, foot, bar});
}

Colour paintTop(const Spot& spot, const Fabric& fabric) {
    Colour colour = fabric.main;
    if (fabric.weave == Weave::striped) {
        // Breton stripes on body and sleeves, the yoke left plain.
        const double pitch = 0.030;
        const double from = isSleeve(spot.panel) ? spot.fromBottom - 0.030 : spot.fromBottom - 0.045;
        const double phase = from / pitch - std::floor(from / pitch);
        const bool striped = from > 0.0 && (isSleeve(spot.panel) ? spot.fromTop > 0.045 : spot.fromTop > 0.175);
        const double stripe = striped ? smoothStep(0.0, 0.05, phase) * smoothStep(0.40, 0.35, phase) : 0.0;
        colour += stripe * (fabric.second - fabric.main);
    }
    // Heather: fibres of two shades along the wales; then the wales themselves.
    const double fibre = 0.55 * smoothNoise({spot.u * 900.0, spot.v * 260.0, 0.5}) +
                         0.45 * smoothNoise({spot.u * 380.0, spot.v * 120.0, 7.5}) + 0.25 * pixelNoise(spot.x, spot.y);
    const double wale = std::cos(2.0 * std::numbers::pi * spot.u / 0.0035);
    colour *= 1.0 + 0.050 * fibre + 0.016 * wale;
    colour *= 1.0 + 0.035 * smoothNoise({spot.u * 7.0, spot.v * 7.0, 3.5});

    const bool collar = !isSleeve(spot.panel) && spot.fromTop < 0.021;
    if (collar) {
        const double rib = std::cos(2.0 * std::numbers::pi * spot.u / 0.0048);
        colour *= 0.93 + 0.060 * rib;
    }
    if (!isSleeve(spot.panel)) {
        colour *= 1.0 - 0.34 * line(spot.fromTop - 0.0215, 0.0009);
        colour *= 1.0 - 0.10 * smoothStep(0.010, 0.0, std::abs(spot.fromTop - 0.0245));
        if (spot.fromTop > 0.030) colour *= 1.0 - 0.16 * line(spot.fromSide, 0.0010);
    }
    // A double row of cover stitches above hem and cuff.
    const double hem = isSleeve(spot.panel) ? 0.020 : 0.024;
    colour *= 1.0 - 0.22 * (stitches(spot.u, spot.fromBottom - hem) +
                            stitches(spot.u + 0.002, spot.fromBottom - hem + 0.004));
    colour *= 1.0 - 0.07 * line(spot.fromBottom - hem - 0.002, 0.0012);
    if (fabric.print && spot.panel == Panel::front) {
        const double ink = mirrorMark(spot.u, spot.fromTop - 0.175);
        colour += 0.92 * ink * (fabric.second * (1.0 + 0.05 * fibre) - colour);
    }
    return colour;
}

/// Distance to a rounded rectangle's outline, negative inside.
double roundedBox(double u, double v, double halfWidth, double halfHeight, double radius) {
    const double du = std::abs(u) - halfWidth + radius;
    const double dv = std::abs(v) - halfHeight + radius;
    return std::hypot(std::max(du, 0.0), std::max(dv, 0.0)) + std::min(std::max(du, dv), 0.0) - radius;
}

Colour paintTrousers(const Spot& spot, const Fabric& fabric) {
    const bool denim = fabric.weave == Weave::denim;
    const bool front = spot.panel == Panel::leftFront || spot.panel == Panel::rightFront;
    // Outwards from the body's middle, whichever leg.
    const bool leftLeg = spot.panel == Panel::leftFront || spot.panel == Panel::leftBack;
    const bool runsOutwards = front == leftLeg;
    const double outward = runsOutwards ? spot.u : -spot.u;
    Colour colour = fabric.main;
    const double twill = std::cos(2.0 * std::numbers::pi * (spot.u * 0.8 + spot.v) / 0.0042);
    const double slub = smoothNoise({spot.u * 700.0, spot.v * 60.0, 1.5});
    const double grain = pixelNoise(spot.x, spot.y);
    if (denim) {
        // Worn paler on the thigh and the seat, darker at the seams.
        const double thigh = std::exp(-std::pow(spot.u / 0.075, 2.0) - std::pow((spot.v - 0.34) / 0.20, 2.0));
        const double knee = std::exp(-std::pow(spot.u / 0.070, 2.0) - std::pow((spot.v - 0.56) / 0.10, 2.0));
        const Colour worn = fabric.main + Colour(0.20, 0.21, 0.20);
        const double wear =
            (front ? 0.50 : 0.30) * thigh + 0.22 * knee + 0.05 * smoothNoise({spot.u * 16.0, spot.v * 9.0, 2.5});
        colour += std::clamp(wear, 0.0, 0.8) * (worn - colour);
        colour *= 1.0 + 0.050 * twill + 0.075 * slub + 0.050 * grain;
    } else {
        colour *=
            1.0 + 0.018 * twill + 0.025 * slub + 0.020 * grain + 0.025 * smoothNoise({spot.u * 8.0, spot.v * 6.0, 2.5});
    }
    double thread = 0.0;
    double shade = 0.0;
    // Side seams and hem.
    shade += 0.26 * line(spot.fromSide, 0.0012) + 0.10 * smoothStep(0.008, 0.0, spot.fromSide);
    if (denim && outward > 0.0) thread += stitches(spot.v, spot.fromSide - 0.0055);
    const double hem = denim ? 0.016 : 0.030;
    thread += (denim ? 1.0 : 0.4) * stitches(spot.u, spot.fromBottom - hem);
    shade += 0.10 * line(spot.fromBottom - hem - 0.0015, 0.0012);
    // Waistband with its loops.
    constexpr double kBand = 0.036;
    shade += 0.30 * line(spot.fromTop - kBand, 0.0011);
    thread += stitches(spot.u, spot.fromTop - kBand + 0.003) + stitches(spot.u, spot.fromTop - 0.003);
    if (spot.fromTop < kBand + 0.004) {
        const double loop = std::abs(spot.u - (front ? 0.0 : 0.01)) - 0.005;
        shade += 0.25 * line(loop, 0.0008);
        if (loop < 0.0) colour *= 1.06;
    }
    const double below = spot.fromTop - kBand;
    if (front && below > 0.0) {
        // The slant pocket, and on the left the fly.
        const double opening =
            denim ? 0.062 - std::sqrt(std::max(0.0, 0.0055 - 0.9 * below * below)) * 0.9 : 0.022 + 0.24 * below;
        const double mouth = below < (denim ? 0.078 : 0.150) ? outward - opening - 0.012 : 1.0;
        if (below < (denim ? 0.078 : 0.150)) {
            shade += 0.28 * line(mouth, 0.0010);
            thread += stitches(below * 1.4, mouth + 0.004) + (denim ? stitches(below * 1.4, mouth + 0.009) : 0.0);
        }
        const double fromMiddle = spot.fromSide;
        if (outward < 0.0 && leftLeg && below < 0.150) {
            const double curve =
                0.032 * std::sqrt(std::max(0.0, 1.0 - std::pow(std::max(below - 0.105, 0.0) / 0.045, 2.0)));
            thread += stitches(below, fromMiddle - curve) + (denim ? stitches(below, fromMiddle - curve + 0.004) : 0.0);
        }
    }
    if (!front && below > 0.0) {
        if (denim) {
            const double pocket =
                roundedBox(spot.u - 0.0, below - 0.115, 0.062, 0.062 + 0.010 * (1.0 - std::abs(spot.u) / 0.062), 0.010);
            shade += 0.20 * line(pocket, 0.0010);
            thread += stitches(spot.u + below, pocket + 0.004) + (pocket < 0.0 ? stitches(spot.u, below - 0.068) : 0.0);
            thread += stitches(spot.u, below - 0.028 - 0.10 * std::abs(spot.u));
        } else {
            shade += 0.32 * line(roundedBox(spot.u, below - 0.075, 0.060, 0.0045, 0.002), 0.0009);
        }
    }
    if (!denim && std::abs(spot.u) < 0.02 && below > 0.10) {
        colour *= 1.0 + 0.05 * line(spot.u, 0.0016);  // The pressed crease.
    }
    colour *= 1.0 - std::min(shade, 0.6);
    colour += (denim ? 0.80 : 0.35) * std::min(thread, 1.0) * (fabric.second - colour);
    return colour;
}

}  // namespace

hal::Image<hal::Rgba8> paint(const PatternLayout& layout, const Fabric& fabric) {
    hal::Image<hal::Rgba8> image(kTexturePixels, kTexturePixels);
    const double scale = layout.side / kTexturePixels;
    for (int y = 0; y < kTexturePixels; ++y) {
        for (int x = 0; x < kTexturePixels; ++x) {
            const Vec2 place(scale * (x + 0.5), scale * (y + 0.5));
            // The nearest panel's colour, so that gaps between panels continue it.
            const FlatPanel* nearest = nullptr;
            double distance = 1e9;
            Panel panel = Panel::front;
            for (std::size_t p = 0; p < kPanelCount; ++p) {
                const FlatPanel& flat = layout.panels[p];
                if (!flat.used) continue;
                const Vec2 outside =
                    (flat.origin + flat.low - place).cwiseMax(place - flat.origin - flat.high).cwiseMax(0.0);
                if (outside.squaredNorm() < distance) {
                    distance = outside.squaredNorm();
                    nearest = &flat;
                    panel = static_cast<Panel>(p);
                }
            }
            const Vec2 local = place - nearest->origin;
            const FlatPanel::Row row = nearest->rowAt(local.y());
            Spot spot{panel,
                      local.x(),
                      local.y(),
                      local.y() - nearest->low.y(),
                      nearest->high.y() - local.y(),
                      std::max(0.0, std::min(local.x() - row.left, row.right - local.x())),
                      x,
                      y};
            const bool top = panel <= Panel::rightSleeve;
            const Colour colour = top ? paintTop(spot, fabric) : paintTrousers(spot, fabric);
            const auto channel = [](double value) {
                return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
            };
            image.view().at(x, y) = {channel(colour.x()), channel(colour.y()), channel(colour.z()), 255};
        }
    }
    return image;
}

}  // namespace cheval::fitting::bake

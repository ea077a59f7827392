// Lays a garment's panels flat, true to scale, side by side in one square texture.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "fitting/bake/cloth_cut.h"

namespace cheval::fitting::bake {

/// One panel laid flat, in metres: u to the right from its middle line, v down from its top.
struct FlatPanel {
    struct Row {
        double v = 0.0, left = 0.0, right = 0.0;  ///< Where the row lies and how far it reaches.
    };
    bool used = false;
    std::map<GridPlace, Vec2> places;
    std::map<int, Row> rows;  ///< By grid row.
    Vec2 low = Vec2::Zero(), high = Vec2::Zero();
    Vec2 origin = Vec2::Zero();  ///< Place of (0, 0) in the texture, metres.

    /// The panel's reach at `v`, between rows.
    [[nodiscard]] Row rowAt(double v) const;
};

struct PatternLayout {
    std::array<FlatPanel, kPanelCount> panels;
    double side = 1.0;  ///< Metres that the square texture spans.

    [[nodiscard]] Vec2 uv(Panel panel, const GridPlace& place) const {
        const FlatPanel& flat = panels[static_cast<std::size_t>(panel)];
        return (flat.origin + flat.places.at(place)) / side;
    }
};

/// Widths along each row are exact; rows keep their mean distances, so that hems and stripes are straight.
PatternLayout layOut(const Cloth& cloth);

}  // namespace cheval::fitting::bake

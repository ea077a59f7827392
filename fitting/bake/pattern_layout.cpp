#include "fitting/bake/pattern_layout.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace cheval::fitting::bake {
namespace {

/// The grid column that runs down a panel's middle.
int middleColumn(Panel panel) {
    constexpr int kQuarter = 1 << kSubdivisions;
    switch (panel) {
        case Panel::back:
            return 8 * kQuarter;
        case Panel::leftFront:
        case Panel::rightFront:
            return 1 * kQuarter;
        case Panel::leftBack:
        case Panel::rightBack:
            return 7 * kQuarter;
        default:
            return 0;
    }
}

/// Right-hand trousers panels count their columns from the middle outwards, so they run to the left in the texture.
double direction(Panel panel) {
    return panel == Panel::rightFront || panel == Panel::rightBack || panel == Panel::rightSleeve ? -1.0 : 1.0;
}

void flatten(FlatPanel& flat, Panel panel, const std::map<int, std::map<int, std::uint32_t>>& rows,
             const Cloth& cloth) {
    double v = 0.0;
    const std::map<int, std::uint32_t>* above = nullptr;
    for (const auto& [row, columns] : rows) {
        if (above != nullptr) {
            double sum = 0.0;
            int count = 0;
            for (const auto& [column, vertex] : columns) {
                const auto upper = above->find(column);
                if (upper == above->end()) continue;
                sum += (cloth.positions[vertex] - cloth.positions[upper->second]).norm();
                ++count;
            }
            if (count > 0) v += sum / count;
        }
        above = &columns;
        // From the column nearest the middle line outwards, both ways.
        auto middle = columns.begin();
        for (auto it = columns.begin(); it != columns.end(); ++it) {
            if (std::abs(it->first - middleColumn(panel)) < std::abs(middle->first - middleColumn(panel))) middle = it;
        }
        FlatPanel::Row reach{v, 0.0, 0.0};
        const auto put = [&](int column, double u) {
            const Vec2 place(direction(panel) * u, v);
            flat.places[{row, column}] = place;
            reach.left = std::min(reach.left, place.x());
            reach.right = std::max(reach.right, place.x());
        };
        put(middle->first, 0.0);
        double u = 0.0;
        for (auto it = middle; std::next(it) != columns.end(); ++it) {
            u += (cloth.positions[std::next(it)->second] - cloth.positions[it->second]).norm();
            put(std::next(it)->first, u);
        }
        u = 0.0;
        for (auto it = middle; it != columns.begin(); --it) {
            u -= (cloth.positions[std::prev(it)->second] - cloth.positions[it->second]).norm();
            put(std::prev(it)->first, u);
        }
        flat.rows[row] = reach;
        flat.low = flat.low.cwiseMin(Vec2(reach.left, v));
        flat.high = flat.high.cwiseMax(Vec2(reach.right, v));
    }
}

}  // namespace

FlatPanel::Row FlatPanel::rowAt(double v) const {
    const Row* before = nullptr;
    for (const auto& [number, row] : rows) {
        if (row.v >= v) {
            if (before == nullptr) return row;
            const double t = (v - before->v) / std::max(row.v - before->v, 1e-9);
            return {v, before->left + t * (row.left - before->left), before->right + t * (row.right - before->right)};
        }
        before = &row;
    }
    return *before;
}

PatternLayout layOut(const Cloth& cloth) {
    std::array<std::map<int, std::map<int, std::uint32_t>>, kPanelCount> grids;
    for (const Cloth::Face& face : cloth.faces) {
        if (face.turned) continue;
        for (std::size_t c = 0; c < 4; ++c) {
            grids[static_cast<std::size_t>(face.panel)][face.at[c].row][face.at[c].column] = face.vertex[c];
        }
    }
    constexpr double kGap = 0.02;
    constexpr double kShelfWidth = 1.22;
    PatternLayout layout;
    Vec2 pen(kGap, kGap);
    double shelfHeight = 0.0;
    double width = 0.0;
    for (std::size_t p = 0; p < kPanelCount; ++p) {
        if (grids[p].empty()) continue;
        FlatPanel& flat = layout.panels[p];
        flat.used = true;
        flatten(flat, static_cast<Panel>(p), grids[p], cloth);
        const Vec2 size = flat.high - flat.low;
        if (pen.x() + size.x() + kGap > kShelfWidth) {
            pen = Vec2(kGap, pen.y() + shelfHeight + kGap);
            shelfHeight = 0.0;
        }
        flat.origin = pen - flat.low;
        pen.x() += size.x() + kGap;
        width = std::max(width, pen.x());
        shelfHeight = std::max(shelfHeight, size.y());
    }
    layout.side = std::max(width, pen.y() + shelfHeight + kGap);
    return layout;
}

}  // namespace cheval::fitting::bake

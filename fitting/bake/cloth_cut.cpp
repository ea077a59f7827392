#include "fitting/bake/cloth_cut.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <utility>

#include "fitting/bake/cloth_tools.h"
#include "fitting/bake/spline.h"

namespace cheval::fitting::bake {
namespace {

constexpr int kQuarter = 1 << kSubdivisions;  ///< Fine steps a ring or column.
constexpr double kClothThickness = 0.0030;

int quarters(double lattice) {
    return static_cast<int>(std::lround(lattice * kQuarter));
}

bool isArm(Chart chart) {
    return chart == Chart::leftArm || chart == Chart::rightArm;
}
bool isLeg(Chart chart) {
    return chart == Chart::leftLeg || chart == Chart::rightLeg;
}
double sideOf(Chart chart) {
    return chart == Chart::rightArm || chart == Chart::rightLeg ? -1.0 : 1.0;
}

struct Span {
    double low, high;
};
Span ringSpan(const QuadMesh::Quad& quad) {
    Span span{quad.lattice[0].x(), quad.lattice[0].x()};
    for (const Vec2& place : quad.lattice) {
        span.low = std::min(span.low, place.x());
        span.high = std::max(span.high, place.x());
    }
    return span;
}
double meanColumn(const QuadMesh::Quad& quad) {
    return 0.25 * (quad.lattice[0].y() + quad.lattice[1].y() + quad.lattice[2].y() + quad.lattice[3].y());
}

/// Grid places of a quad: rows count down the body (`sign` −1 for the trunk), columns are shifted whole turns.
Placement placed(const QuadMesh::Quad& quad, Panel panel, int rowSign, int columnShift, bool absolute) {
    Placement placement{panel, {}};
    for (std::size_t c = 0; c < 4; ++c) {
        int column = quarters(quad.lattice[c].y()) + columnShift;
        if (absolute) column = std::abs(column);
        placement.at[c] = {rowSign * quarters(quad.lattice[c].x()), column};
    }
    return placement;
}

/// Noise with the narrow crests and wide valleys of folded cloth, about −1…1.
double crease(const Vec3& place) {
    return 1.0 - 2.6 * std::sqrt(std::pow(smoothNoise(place), 2.0) + 0.006);
}

Vec3 mirrorX(const Vec3& point) {
    return {-point.x(), point.y(), point.z()};
}

/// Where each cloth vertex of some charts stands in the grid.
using Grid = std::map<std::pair<Chart, GridPlace>, std::uint32_t>;

Grid gridOf(const Tailor& tailor, const Cloth& cloth) {
    Grid grid;
    for (const QuadMesh::Quad& quad : tailor.model().fine.quads) {
        if (quad.cap) continue;
        for (std::size_t c = 0; c < 4; ++c) {
            if (cloth.coveredSkin[quad.vertex[c]] == 0) continue;
            grid[{quad.chart, {quarters(quad.lattice[c].x()), quarters(quad.lattice[c].y())}}] =
                cloth.clothOnSkin[quad.vertex[c]];
        }
    }
    return grid;
}

/// The trunk's middle at a height.
Vec3 trunkAxis(const BodyModel& model, double y) {
    const Vec3 centre = model.field.trunkLoft().centre(std::clamp(y, 0.80, 1.56));
    return {0.0, y, centre.z()};
}

/// One column of a top between chest and hem: cut straight, drawn in a little at the waist, and never into the body.
class Fall {
  public:
    struct End {
        Vec3 skin;
        double ease;
    };
    Fall(const BodyModel& model, const End& chest, const End& hem, double waisting)
        : model_(model), chest_(at(chest)), hem_(at(hem)), waisting_(waisting) {}

    [[nodiscard]] Vec3 over(const Vec3& skin, double ease) const {
        const Place body = at({skin, ease});
        const double way = (chest_.y - body.y) / (chest_.y - hem_.y);
        const double straight = chest_.radius + way * (hem_.radius - chest_.radius);
        const double radius = std::max(body.radius, straight - waisting_ * std::sin(std::numbers::pi * way));
        return trunkAxis(model_, body.y) + radius * body.outward;
    }
    /// Straight down below the hem's ring.
    [[nodiscard]] Vec3 hang(double y) const {
        return trunkAxis(model_, hem_.y) + hem_.radius * hem_.outward + Vec3(0.0, y - hem_.y, 0.0);
    }

  private:
    struct Place {
        double radius, y;
        Vec3 outward;
    };
    [[nodiscard]] Place at(const End& end) const {
        Vec3 outward = end.skin - trunkAxis(model_, end.skin.y());
        outward.y() = 0.0;
        const double radius = outward.norm();
        return {radius + end.ease, end.skin.y(), outward / radius};
    }
    const BodyModel& model_;
    Place chest_, hem_;
    double waisting_;
};

}  // namespace

Cloth cutTop(const BodyModel& model, const TopCut& cut) {
    constexpr double kHemRing = 1.0;
    constexpr double kChestRing = 8.0;
    constexpr int kHangRows = 6;
    Tailor tailor(model);
    tailor.takeSkin([&](const QuadMesh::Quad& quad) -> std::optional<Placement> {
        const Span rings = ringSpan(quad);
        if (quad.cap) return std::nullopt;
        if (isArm(quad.chart)) {
            if (rings.high > cut.sleeveRing) return std::nullopt;
            const bool pastSeam = meanColumn(quad) > 0.5 * kArmColumns;
            return placed(quad, quad.chart == Chart::leftArm ? Panel::leftSleeve : Panel::rightSleeve, 1,
                          pastSeam ? -kArmColumns * kQuarter : 0, false);
        }
        if (quad.chart != Chart::trunk || rings.low < kHemRing || rings.high > kNecklineRing) return std::nullopt;
        const double column = meanColumn(quad);
        if (std::abs(column) < 4.0) return placed(quad, Panel::front, -1, 0, false);
        return placed(quad, Panel::back, -1, column < 0.0 ? kTrunkColumns * kQuarter : 0, false);
    });
    Cloth& cloth = tailor.cloth();
    const Grid grid = gridOf(tailor, cloth);
    const std::vector<Vec3> skin = cloth.positions;

    // Shoulders and yoke lie on the body with a little air, the collar closest.
    const Spline yokeEase(std::array{7.0, 8.0, 10.0, 11.5, 12.4, 13.0},
                          std::array{cut.ease, cut.ease, 0.80 * cut.ease, 0.0065, 0.0058, 0.0075});
    for (const auto& [key, v] : grid) {
        const double ring = static_cast<double>(key.second.row) / kQuarter;
        if (key.first == Chart::trunk && ring >= kChestRing) {
            cloth.positions[v] = skin[v] + yokeEase(ring) * tailor.skinNormal(tailor.skinOf()[v]);
        }
    }
    // Sleeves: on the arm above, hanging below, wider towards the hem.
    const Loft& arm = model.field.armLoft();
    double sleeveEnd = 0.0;
    for (const auto& [key, v] : grid) {
        if (key.first == Chart::leftArm) {
            sleeveEnd = std::max(sleeveEnd, (skin[v] - arm.shape().origin).dot(arm.shape().axis));
        }
    }
    for (const auto& [key, v] : grid) {
        if (!isArm(key.first) || key.second.row == 0) continue;
        const double ring = static_cast<double>(key.second.row) / kQuarter;
        const double side = sideOf(key.first);
        const Vec3 place = side < 0.0 ? mirrorX(skin[v]) : skin[v];
        const double along = (place - arm.shape().origin).dot(arm.shape().axis);
        Vec3 outward = place - arm.centre(along);
        outward -= outward.dot(arm.shape().axis) * arm.shape().axis;
        outward.normalize();
        const double below = 0.5 * (1.0 - outward.dot(arm.shape().second));
        const double way = std::clamp(along / sleeveEnd, 0.0, 1.0);
        const double ease = 0.007 + way * (0.006 + cut.sleeveEase * below);
        Vec3 normal = tailor.skinNormal(tailor.skinOf()[v]);
        if (side < 0.0) normal = mirrorX(normal);
        const double radial = smoothStep(0.5, 2.0, ring);
        const Vec3 result = place + (1.0 - radial) * cut.ease * normal + radial * ease * outward;
        cloth.positions[v] = side < 0.0 ? mirrorX(result) : result;
    }
    // The body of the shirt falls from the chest.
    const int columns = kTrunkColumns * kQuarter;
    std::map<int, std::vector<std::uint32_t>> hangingRows;
    for (int column = -columns / 2 + 1; column <= columns / 2; ++column) {
        const double angle = 2.0 * std::numbers::pi * column / columns;
        const double sideways = std::sin(angle) * std::sin(angle);
        const auto at = [&](int row) {
            const int latticeColumn = column < 0 || grid.contains({Chart::trunk, {row, column}}) ? column : -column;
            return grid.at({Chart::trunk, {row, latticeColumn}});
        };
        const double hemEase = cut.ease + 0.008;
        const Fall fall(model, {skin[at(quarters(kChestRing))], cut.ease}, {skin[at(quarters(kHemRing))], hemEase},
                        0.006 + 0.010 * sideways);
        for (int row = quarters(kChestRing); row >= quarters(kHemRing); --row) {
            const std::uint32_t v = at(row);
            cloth.positions[v] = fall.over(skin[v], cut.ease);
        }
        const std::uint32_t hem = at(quarters(kHemRing));
        hangingRows[column].push_back(hem);
        for (int k = 1; k <= kHangRows; ++k) {
            const double share = static_cast<double>(k) / kHangRows;
            const double y = cloth.positions[hem].y() + share * (cut.hemHeight - cloth.positions[hem].y());
            hangingRows[column].push_back(tailor.addHanging(fall.hang(y)));
        }
    }
    for (int column = -columns / 2; column < columns / 2; ++column) {
        const int from = column == -columns / 2 ? columns / 2 : column;
        for (int k = 0; k < kHangRows; ++k) {
            const auto vertex = [&](int c, int row) { return hangingRows.at(c)[static_cast<std::size_t>(row)]; };
            Cloth::Face face;
            face.vertex = {vertex(from, k + 1), vertex(column + 1, k + 1), vertex(column + 1, k), vertex(from, k)};
            const bool isFront = column >= -columns / 4 && column < columns / 4;
            face.panel = isFront ? Panel::front : Panel::back;
            const int shift = !isFront && column < 0 ? columns : 0;
            const int row = -quarters(kHemRing) + k;
            face.at = {GridPlace{row + 1, column + shift}, GridPlace{row + 1, column + 1 + shift},
                       GridPlace{row, column + 1 + shift}, GridPlace{row, column + shift}};
            tailor.addFace(face);
        }
    }
    // Below the waist a top leaves room for what is worn under it.
    const auto roomFor = [](const Vec3& place) {
        return kClearance + 0.0150 * smoothStep(1.10, 0.95, place.y()) * smoothStep(0.30, 0.24, std::abs(place.x()));
    };
    tailor.smooth(10, 0.5);
    tailor.clear([&](const Vec3& place) { return roomFor(place) + 0.002; });
    tailor.smooth(4, 0.4);
    tailor.fold([&](const Vec3& place, const Vec3&) {
        // Folds run down from the chest, slantwise from the armpits, and round the sleeves.
        const double below = smoothStep(1.32, 0.95, place.y());
        const double lean = 0.22 * place.x() * smoothStep(1.05, 1.35, place.y());
        const double down = crease({(place.x() + lean) * 15.0 + 3.1, place.y() * 2.6, place.z() * 15.0}) +
                            0.5 * crease({place.x() * 26.0, place.y() * 4.5 + 9.7, place.z() * 26.0});
        const double slant = std::abs(place.x()) * 0.75 + place.y() * 0.65;
        const double armpit = smoothStep(0.20, 0.03, (Vec3(std::abs(place.x()) - 0.18, place.y() - 1.29, 0.0)).norm());
        const double pull = crease({slant * 24.0, place.x() > 0.0 ? 2.3 : 7.9, place.z() * 7.0});
        const double sleeve = smoothStep(0.21, 0.26, std::abs(place.x()));
        const double along = (std::abs(place.x()) - place.y()) * std::numbers::sqrt2 / 2.0;
        const double round = crease({along * 22.0, place.z() * 12.0 + (place.x() > 0.0 ? 0.0 : 5.0), place.y() * 6.0});
        return cut.foldDepth *
               ((1.0 - sleeve) * (below * down + 0.8 * armpit * pull) + sleeve * (0.25 + 0.55 * below + 0.25) * round);
    });
    tailor.smooth(1, 0.35);
    tailor.clear(roomFor);
    tailor.weighHanging();
    tailor.turnEdges(kClothThickness);
    return std::move(cloth);
}

Cloth cutTrousers(const BodyModel& model, const TrousersCut& cut) {
    constexpr double kWaistRing = 3.25;
    constexpr int kHangRows = 4;
    const int columns = kLegColumns * kQuarter;
    Tailor tailor(model);
    tailor.takeSkin([&](const QuadMesh::Quad& quad) -> std::optional<Placement> {
        const Span rings = ringSpan(quad);
        if (quad.cap) return std::nullopt;
        const double column = meanColumn(quad);
        if (isLeg(quad.chart)) {
            if (rings.high > cut.hemRing) return std::nullopt;
            const bool isBack = column > 4.0 && column < 10.0;
            const bool isLeft = quad.chart == Chart::leftLeg;
            const Panel panel = isLeft ? (isBack ? Panel::leftBack : Panel::leftFront)
                                       : (isBack ? Panel::rightBack : Panel::rightFront);
            return placed(quad, panel, 1, column > 10.0 ? -columns : 0, false);
        }
        if (quad.chart != Chart::trunk || rings.high > kWaistRing) return std::nullopt;
        const bool isBack = std::abs(column) > 4.0;
        const Panel panel = column > 0.0 ? (isBack ? Panel::leftBack : Panel::leftFront)
                                         : (isBack ? Panel::rightBack : Panel::rightFront);
        return placed(quad, panel, -1, 0, true);
    });
    Cloth& cloth = tailor.cloth();
    const Grid grid = gridOf(tailor, cloth);
    const std::vector<Vec3> skin = cloth.positions;
    const Spline hipEase(std::array{0.0, 1.0, 2.0, 3.0, 3.3}, std::array{0.0115, 0.0095, 0.0075, 0.0058, 0.0058});
    // The leg's radius at each place along it: straight from the thigh, a little narrower at the knee.
    const Spline cutRadius(std::array{0.10, 0.20, 0.415, 0.60, 0.82}, std::array{0.096, 0.092, 0.077, 0.074, 0.073});
    const Loft& leg = model.field.legLoft();
    for (const auto& [key, v] : grid) {
        const double ring = static_cast<double>(key.second.row) / kQuarter;
        const Vec3& normal = tailor.skinNormal(tailor.skinOf()[v]);
        if (!isLeg(key.first)) {
            cloth.positions[v] = skin[v] + hipEase(ring) * normal;
            continue;
        }
        if (key.second.row == 0) {
            cloth.positions[v] = skin[v] + hipEase(0.0) * normal;
            continue;
        }
        const double side = sideOf(key.first);
        const Vec3 place = side < 0.0 ? mirrorX(skin[v]) : skin[v];
        const double along = (place - leg.shape().origin).dot(leg.shape().axis);
        const Vec3 centre = leg.centre(along);
        Vec3 outward = place - centre;
        const double skinRadius = outward.norm();
        outward /= skinRadius;
        const double radius = std::max(skinRadius + 0.009, cutRadius(along) + cut.extraWidth);
        const double radial = smoothStep(0.0, 1.6, ring);
        Vec3 result = place + (1.0 - radial) * hipEase(0.0) * (side < 0.0 ? mirrorX(normal) : normal) +
                      radial * (radius - skinRadius) * outward;
        result.x() = std::max(result.x(), 0.004 + 0.02 * smoothStep(0.5, 4.0, ring));
        cloth.positions[v] = side < 0.0 ? mirrorX(result) : result;
    }
    if (cut.hang > 0.0) {
        for (const Chart chart : {Chart::leftLeg, Chart::rightLeg}) {
            const auto bottom = [&](int column) {
                const int wrapped = column % columns;
                const auto found = grid.find({chart, {quarters(cut.hemRing), wrapped}});
                return found != grid.end() ? found->second
                                           : grid.at({chart, {quarters(cut.hemRing), wrapped + columns}});
            };
            std::vector<std::vector<std::uint32_t>> rows(kHangRows + 1);
            for (int column = 0; column < columns; ++column) {
                rows[0].push_back(bottom(column));
                for (int k = 1; k <= kHangRows; ++k) {
                    const Vec3 drop(0.0, -cut.hang * k / kHangRows, 0.0);
                    rows[static_cast<std::size_t>(k)].push_back(
                        tailor.addHanging(cloth.positions[rows[0].back()] + drop));
                }
            }
            for (int column = 0; column < columns; ++column) {
                for (int k = 0; k < kHangRows; ++k) {
                    const auto vertex = [&](int c, int row) {
                        return rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(c % columns)];
                    };
                    const bool isLeft = chart == Chart::leftLeg;
                    const bool isBack = column >= 4 * kQuarter && column < 10 * kQuarter;
                    const int shift = column >= 10 * kQuarter ? -columns : 0;
                    const int row = quarters(cut.hemRing) + k;
                    Cloth::Face face;
                    face.panel = isLeft ? (isBack ? Panel::leftBack : Panel::leftFront)
                                        : (isBack ? Panel::rightBack : Panel::rightFront);
                    face.vertex = {vertex(column, k + 1), vertex(column + 1, k + 1), vertex(column + 1, k),
                                   vertex(column, k)};
                    face.at = {GridPlace{row + 1, column + shift}, GridPlace{row + 1, column + 1 + shift},
                               GridPlace{row, column + 1 + shift}, GridPlace{row, column + shift}};
                    if (!isLeft) {
                        std::swap(face.vertex[0], face.vertex[1]);
                        std::swap(face.vertex[2], face.vertex[3]);
                        std::swap(face.at[0], face.at[1]);
                        std::swap(face.at[2], face.at[3]);
                    }
                    tailor.addFace(face);
                }
            }
        }
    }
    tailor.smooth(8, 0.5);
    tailor.clear([](const Vec3&) { return kClearance + 0.0015; });
    tailor.fold([&](const Vec3& place, const Vec3&) {
        // Creases fan out from the crotch, gather behind the knee and break above the shoe.
        const double crotch = smoothStep(0.22, 0.04, std::hypot(place.x(), place.y() - 0.80));
        const double fan = crease({std::atan2(place.y() - 0.80, std::abs(place.x())) * 5.0, place.x() > 0.0 ? 1.7 : 6.2,
                                   place.z() > 0.0 ? 0.0 : 3.0});
        const double knee = std::exp(-std::pow((place.y() - 0.48) / 0.09, 2.0)) * (place.z() < 0.0 ? 1.0 : 0.35);
        const double ankle = smoothStep(0.30, 0.10, place.y());
        const double across =
            crease({place.x() * 9.0, place.y() * 22.0 + 0.35 * smoothNoise(9.0 * place), place.z() * 11.0});
        const double down = crease({place.x() * 17.0, place.y() * 3.0, place.z() * 17.0 + 4.0});
        return cut.foldDepth * (0.9 * crotch * fan + (0.9 * knee + 1.1 * ankle) * across +
                                0.45 * smoothStep(0.95, 0.75, place.y()) * down);
    });
    tailor.smooth(1, 0.35);
    tailor.clear([](const Vec3&) { return kClearance; });
    tailor.weighHanging();
    tailor.turnEdges(kClothThickness);
    return std::move(cloth);
}

}  // namespace cheval::fitting::bake

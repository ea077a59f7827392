#include "fitting/bake/body_topology.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

namespace cheval::fitting::bake {
namespace {

/// An island of the shared UV: rings become the outlines of nested squares, so a tube with a closed end lies flat
/// without a seam along it.
struct Island {
    double centreU, centreV, cell;
};
constexpr std::array<Island, 4> kIslands = {{{0.5, 0.735, 0.24 / 21.0},     // Trunk and head.
                                             {0.865, 0.36, 0.12 / 28.0},    // Left arm.
                                             {0.955, 0.93, 0.02 / 3.0},     // Left thumb.
                                             {0.745, 0.13, 0.20 / 38.0}}};  // Left leg.

/// Corner positions along the outline of a grid of `across` × `down` cells, beginning at its top's middle (or, where
/// that is no corner, at the next one) and going round towards growing `across`.
struct CapGrid {
    int across, down;  ///< Cells.
    int start;         ///< Column of the corner (0, 0) of the grid, counted along the tube's ring.
    bool forwards;     ///< Whether ring columns go from (0, 0) towards growing `across`.

    [[nodiscard]] int perimeter() const { return 2 * (across + down); }
    /// The grid corner (b across, a down) that a ring's column stands at.
    [[nodiscard]] std::pair<int, int> corner(int column) const {
        const int n = perimeter();
        int step = (forwards ? column - start : start - column) % n;
        if (step < 0) step += n;
        if (step < across) return {step, 0};
        step -= across;
        if (step < down) return {across, step};
        step -= down;
        if (step < across) return {across - step, down};
        step -= across;
        return {0, down - step};
    }
    [[nodiscard]] Vec2 offset(int b, int a) const { return {b - 0.5 * across, a - 0.5 * down}; }
};

// The crown: columns across from the right side, rows from front to back; column 0 (front) stands at (2, 0).
constexpr CapGrid kCrown{4, 4, -2, true};
// Finger tips: across from back to front, down from the outer side to the palm; column 0 stands at (1, 0).
constexpr CapGrid kFingers{2, 3, 9, true};
// Toes: across from the inner to the outer side, down from instep to sole; column 1 (instep) stands at (2, 0).
constexpr CapGrid kToes{4, 2, 11, true};
constexpr CapGrid kThumbTip{2, 1, 0, true};

class Builder {
  public:
    void addTrunk();
    void addArm();
    void addLeg();
    BodyTopology finish();

  private:
    using Key = std::tuple<Chart, int, int, bool>;

    std::uint32_t vertex(Chart chart, int ring, int column, bool cap = false);
    /// A corner of a quad: vertex, place in the lattice, UV.
    struct Corner {
        std::uint32_t vertex;
        Vec2 lattice;
        Vec2 uv;
    };
    Corner trunkCorner(int ring, int column) {
        return {vertex(Chart::trunk, ring, column), Vec2(ring, column),
                islandUv(Chart::trunk, kCrown, column, kTrunkLastRing - ring)};
    }
    Corner armCorner(int ring, int column);
    Corner thumbCorner(int ring, int column);
    Corner legCorner(int ring, int column);
    static Vec2 islandUv(Chart chart, const CapGrid& grid, int column, int ringsFromCap);
    static Vec2 capUv(Chart chart, const CapGrid& grid, int b, int a);
    void quad(Chart chart, const std::array<Corner, 4>& corners, bool cap = false);
    template <typename RingCorner>
    void closeCap(Chart chart, const CapGrid& grid, int firstB, int lastRing, bool flipped, RingCorner ringCorner);

    std::map<Key, std::uint32_t> vertices_;
    BodyTopology topology_;
};

std::uint32_t Builder::vertex(Chart chart, int ring, int column, bool cap) {
    const auto [found, isNew] =
        vertices_.try_emplace({chart, ring, column, cap}, static_cast<std::uint32_t>(topology_.places.size()));
    if (isNew) topology_.places.push_back({chart, ring, column, cap});
    return found->second;
}

Vec2 Builder::islandUv(Chart chart, const CapGrid& grid, int column, int ringsFromCap) {
    const auto [b, a] = grid.corner(column);
    const Island& island = kIslands[static_cast<std::size_t>(chart)];
    // Each ring is one cell further out along the shorter side.
    const double scale = island.cell * (1.0 + ringsFromCap / (0.5 * std::min(grid.across, grid.down)));
    const Vec2 offset = grid.offset(b, a);
    return {island.centreU + scale * offset.x(), island.centreV + scale * offset.y()};
}

Vec2 Builder::capUv(Chart chart, const CapGrid& grid, int b, int a) {
    const Island& island = kIslands[static_cast<std::size_t>(chart)];
    const Vec2 offset = grid.offset(b, a);
    return {island.centreU + island.cell * offset.x(), island.centreV + island.cell * offset.y()};
}

void Builder::quad(Chart chart, const std::array<Corner, 4>& corners, bool cap) {
    QuadMesh::Quad quad;
    for (std::size_t c = 0; c < 4; ++c) {
        quad.vertex[c] = corners[c].vertex;
        quad.lattice[c] = corners[c].lattice;
        quad.uv[c] = corners[c].uv;
    }
    quad.chart = chart;
    quad.cap = cap;
    topology_.mesh.quads.push_back(quad);
}

template <typename RingCorner>
void Builder::closeCap(Chart chart, const CapGrid& grid, int firstB, int lastRing, bool flipped,
                       RingCorner ringCorner) {
    const auto corner = [&](int b, int a) -> Corner {
        Corner result{};
        if (b == 0 || a == 0 || b == grid.across || a == grid.down) {
            for (int column = 0; column < grid.perimeter(); ++column) {
                if (grid.corner(column) == std::pair(b, a)) result = ringCorner(column);
            }
        } else {
            result.vertex = vertex(chart, lastRing + 1, a * (grid.across + 1) + b, true);
            result.uv = capUv(chart, grid, b, a);
        }
        result.lattice = Vec2(lastRing + 1, 1);
        return result;
    };
    for (int a = 0; a < grid.down; ++a) {
        for (int b = firstB; b < grid.across; ++b) {
            if (flipped) {
                quad(chart, {corner(b, a + 1), corner(b + 1, a + 1), corner(b + 1, a), corner(b, a)}, true);
            } else {
                quad(chart, {corner(b, a), corner(b + 1, a), corner(b + 1, a + 1), corner(b, a + 1)}, true);
            }
        }
    }
}

void Builder::addTrunk() {
    for (int ring = 0; ring < kTrunkLastRing; ++ring) {
        for (int column = 0; column < kTrunkColumns / 2; ++column) {
            if (ring >= kArmholeFirstRing && ring < kArmholeLastRing && (column == 3 || column == 4)) continue;
            quad(Chart::trunk, {trunkCorner(ring, column), trunkCorner(ring, column + 1),
                                trunkCorner(ring + 1, column + 1), trunkCorner(ring + 1, column)});
        }
    }
    closeCap(Chart::trunk, kCrown, 2, kTrunkLastRing, false,
             [&](int column) { return trunkCorner(kTrunkLastRing, column); });
}

Builder::Corner Builder::armCorner(int ring, int column) {
    const Vec2 uv = islandUv(Chart::leftArm, kFingers, column, kArmLastRing - ring);
    if (ring > 0) return {vertex(Chart::leftArm, ring, column % kArmColumns), Vec2(ring, column), uv};
    // The armhole, from its top down the front and up the back.
    constexpr std::array<std::pair<int, int>, kArmColumns> kArmhole = {
        {{11, 4}, {11, 3}, {10, 3}, {9, 3}, {8, 3}, {8, 4}, {8, 5}, {9, 5}, {10, 5}, {11, 5}}};
    const auto [trunkRing, trunkColumn] = kArmhole[static_cast<std::size_t>(column % kArmColumns)];
    return {vertex(Chart::trunk, trunkRing, trunkColumn), Vec2(ring, column), uv};
}

Builder::Corner Builder::thumbCorner(int ring, int column) {
    const Vec2 uv = islandUv(Chart::leftThumb, kThumbTip, column, kThumbLastRing - ring);
    if (ring > 0) return {vertex(Chart::leftThumb, ring, column % kThumbColumns), Vec2(ring, column), uv};
    constexpr std::array<std::pair<int, int>, kThumbColumns> kHole = {{{0, 2}, {1, 2}, {2, 2}, {2, 3}, {1, 3}, {0, 3}}};
    const auto [armRing, armColumn] = kHole[static_cast<std::size_t>(column % kThumbColumns)];
    return {vertex(Chart::leftArm, kThumbFirstRing + armRing, armColumn), Vec2(ring, column), uv};
}

Builder::Corner Builder::legCorner(int ring, int column) {
    const Vec2 uv = islandUv(Chart::leftLeg, kToes, column, kLegLastRing - ring);
    const int wrapped = column % kLegColumns;
    if (ring > 0 || wrapped > kTrunkColumns / 2) {
        return {vertex(Chart::leftLeg, ring, wrapped), Vec2(ring, column), uv};
    }
    return {vertex(Chart::trunk, 0, wrapped), Vec2(ring, column), uv};
}

void Builder::addArm() {
    for (int ring = 0; ring < kArmLastRing; ++ring) {
        for (int column = 0; column < kArmColumns; ++column) {
            if (column == 2 && (ring == kThumbFirstRing || ring == kThumbFirstRing + 1)) continue;
            quad(Chart::leftArm, {armCorner(ring, column + 1), armCorner(ring + 1, column + 1),
                                  armCorner(ring + 1, column), armCorner(ring, column)});
        }
    }
    closeCap(Chart::leftArm, kFingers, 0, kArmLastRing, false,
             [&](int column) { return armCorner(kArmLastRing, column); });
    for (int ring = 0; ring < kThumbLastRing; ++ring) {
        for (int column = 0; column < kThumbColumns; ++column) {
            quad(Chart::leftThumb, {thumbCorner(ring, column + 1), thumbCorner(ring, column),
                                    thumbCorner(ring + 1, column), thumbCorner(ring + 1, column + 1)});
        }
    }
    closeCap(Chart::leftThumb, kThumbTip, 0, kThumbLastRing, true,
             [&](int column) { return thumbCorner(kThumbLastRing, column); });
}

void Builder::addLeg() {
    for (int ring = 0; ring < kLegLastRing; ++ring) {
        for (int column = 0; column < kLegColumns; ++column) {
            quad(Chart::leftLeg, {legCorner(ring + 1, column), legCorner(ring + 1, column + 1),
                                  legCorner(ring, column + 1), legCorner(ring, column)});
        }
    }
    closeCap(Chart::leftLeg, kToes, 0, kLegLastRing, true, [&](int column) { return legCorner(kLegLastRing, column); });
}

BodyPart trunkPart(int ring) {
    if (ring <= 2) return BodyPart::hips;
    if (ring <= 6) return BodyPart::waist;
    if (ring <= 12) return BodyPart::chest;
    return ring <= 14 ? BodyPart::neck : BodyPart::head;
}

/// The part that a vertex belongs to in the island of `chart`.
BodyPart partOf(Chart chart, int ring) {
    switch (chart) {
        case Chart::trunk:
            return trunkPart(ring);
        case Chart::leftArm:
            return ring < kElbowRing ? BodyPart::leftUpperArm
                                     : (ring < kWristRing ? BodyPart::leftForearm : BodyPart::leftHand);
        case Chart::rightArm:
            return ring < kElbowRing ? BodyPart::rightUpperArm
                                     : (ring < kWristRing ? BodyPart::rightForearm : BodyPart::rightHand);
        case Chart::leftThumb:
            return BodyPart::leftHand;
        case Chart::rightThumb:
            return BodyPart::rightHand;
        case Chart::leftLeg:
            return ring < kKneeRing ? BodyPart::leftThigh
                                    : (ring < kAnkleRing ? BodyPart::leftShin : BodyPart::leftFoot);
        case Chart::rightLeg:
            return ring < kKneeRing ? BodyPart::rightThigh
                                    : (ring < kAnkleRing ? BodyPart::rightShin : BodyPart::rightFoot);
    }
    return BodyPart::waist;
}

/// Adds the right half: every vertex off the mid-plane and every quad once more.
void mirror(BodyTopology& topology) {
    QuadMesh& mesh = topology.mesh;
    const std::size_t leftVertices = topology.places.size();
    const auto isCentre = [&](const LatticePlace& place) {
        if (place.chart == Chart::trunk) {
            if (place.cap) return place.column % (kCrown.across + 1) == kCrown.across / 2;
            return place.column == 0 || place.column == kTrunkColumns / 2;
        }
        return place.chart == Chart::leftLeg && place.ring == 0 && !place.cap;
    };
    mesh.mirrored.resize(leftVertices);
    for (std::size_t v = 0; v < leftVertices; ++v) {
        if (isCentre(topology.places[v])) {
            mesh.mirrored[v] = static_cast<std::uint32_t>(v);
            continue;
        }
        LatticePlace place = topology.places[v];
        place.chart = mirrorOf(place.chart);
        if (place.chart == Chart::trunk) place.column = -place.column;
        mesh.mirrored[v] = static_cast<std::uint32_t>(topology.places.size());
        topology.places.push_back(place);
        mesh.mirrored.push_back(static_cast<std::uint32_t>(v));
    }
    const std::size_t leftQuads = mesh.quads.size();
    for (std::size_t q = 0; q < leftQuads; ++q) {
        const QuadMesh::Quad original = mesh.quads[q];
        QuadMesh::Quad image = original;
        image.chart = mirrorOf(original.chart);
        for (std::size_t c = 0; c < 4; ++c) {
            const std::size_t from = (4 - c) % 4;
            image.vertex[c] = mesh.mirrored[original.vertex[from]];
            image.lattice[c] = original.lattice[from];
            if (original.chart == Chart::trunk) image.lattice[c].y() = -image.lattice[c].y();
            image.uv[c] = Vec2(1.0 - original.uv[from].x(), original.uv[from].y());
        }
        mesh.quads.push_back(image);
    }
    mesh.positions.assign(topology.places.size(), Vec3::Zero());
}

BodyTopology Builder::finish() {
    mirror(topology_);
    QuadMesh& mesh = topology_.mesh;
    CageTemplate& cage = topology_.cageTemplate;
    // A template vertex is a mesh vertex in an island; islands meet in seams.
    std::map<std::pair<std::uint32_t, Chart>, Vec2> uvOf;
    std::map<std::pair<std::uint32_t, Chart>, int> ringOf;
    for (const QuadMesh::Quad& quad : mesh.quads) {
        for (std::size_t c = 0; c < 4; ++c) {
            uvOf.try_emplace({quad.vertex[c], quad.chart}, quad.uv[c]);
            if (quad.cap) {
                ringOf.try_emplace({quad.vertex[c], quad.chart}, topology_.places[quad.vertex[c]].ring);
            } else {
                ringOf[{quad.vertex[c], quad.chart}] = static_cast<int>(quad.lattice[c].x());
            }
        }
    }
    std::map<std::pair<std::uint32_t, Chart>, std::uint16_t> numberOf;
    std::vector<std::uint16_t> lowest(mesh.positions.size(), 0xFFFF);
    for (const auto& [key, uv] : uvOf) {
        const auto number = static_cast<std::uint16_t>(cage.uv.size());
        numberOf[key] = number;
        cage.uv.emplace_back(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
        lowest[key.first] = std::min(lowest[key.first], number);
        cage.weld.push_back(lowest[key.first]);
        cage.part.push_back(partOf(key.second, ringOf.at(key)));
        topology_.meshVertexOf.push_back(key.first);
    }
    for (const auto& [key, uv] : uvOf) {
        cage.mirrored.push_back(numberOf.at({mesh.mirrored[key.first], mirrorOf(key.second)}));
    }
    for (const QuadMesh::Quad& quad : mesh.quads) {
        for (const Triangle& t : cut(quad)) {
            cage.triangles.push_back(
                {numberOf.at({t.a, quad.chart}), numberOf.at({t.b, quad.chart}), numberOf.at({t.c, quad.chart})});
        }
    }
    cage.hash = hashCageTemplate(cage);
    return std::move(topology_);
}

}  // namespace

BodyTopology makeTopology() {
    Builder builder;
    builder.addTrunk();
    builder.addArm();
    builder.addLeg();
    return builder.finish();
}

}  // namespace cheval::fitting::bake

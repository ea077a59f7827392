#include "fitting/bake/body_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "fitting/bake/body_shapes.h"
#include "fitting/bake/skinning.h"

namespace cheval::fitting::bake {
namespace {

constexpr double kPi = std::numbers::pi;

/// Heights of a trunk ring at the front's middle, the side and the back's middle.
struct RingHeights {
    double front, side, back;
};
constexpr std::array<RingHeights, kTrunkLastRing + 1> kTrunkRings = {
    {{0.838, 0.900, 0.836}, {0.888, 0.928, 0.886}, {0.936, 0.956, 0.936}, {0.990, 1.000, 0.992},
     {1.048, 1.050, 1.048}, {1.108, 1.108, 1.108}, {1.166, 1.166, 1.166}, {1.222, 1.228, 1.224},
     {1.274, 1.283, 1.279}, {1.317, 1.328, 1.322}, {1.353, 1.373, 1.364}, {1.385, 1.416, 1.404},
     {1.412, 1.441, 1.441}, {1.437, 1.468, 1.477}, {1.480, 1.502, 1.512}, {1.519, 1.534, 1.546},
     {1.560, 1.573, 1.585}, {1.610, 1.618, 1.626}, {1.658, 1.664, 1.668}, {1.702, 1.706, 1.708}}};

/// A ring round a limb: where its plane cuts the axis on the column-0 side, and how much further on the other side.
struct LimbRing {
    double along, shift;
};
constexpr std::array<LimbRing, kArmLastRing + 1> kArmRings = {{{0.0, 0.0},
                                                               {0.010, 0.070},
                                                               {0.045, 0.052},
                                                               {0.085, 0.030},
                                                               {0.133, 0.012},
                                                               {0.190, 0.0},
                                                               {0.240, 0.0},
                                                               {0.267, 0.0},
                                                               {0.290, 0.0},
                                                               {0.313, 0.0},
                                                               {0.358, 0.0},
                                                               {0.430, 0.0},
                                                               {0.500, 0.0},
                                                               {0.540, 0.0},
                                                               {0.573, 0.0},
                                                               {0.607, 0.0},
                                                               {0.645, 0.0},
                                                               {0.692, 0.0}}};
/// As above from hip to ankle; the shift is from the outer to the inner side.
constexpr std::array<LimbRing, kAnkleRing + 1> kLegRings = {{{0.0, 0.0},
                                                             {0.062, 0.062},
                                                             {0.118, 0.038},
                                                             {0.178, 0.015},
                                                             {0.250, 0.0},
                                                             {0.320, 0.0},
                                                             {0.374, 0.0},
                                                             {0.413, 0.0},
                                                             {0.450, 0.0},
                                                             {0.495, 0.0},
                                                             {0.560, 0.0},
                                                             {0.640, 0.0},
                                                             {0.730, 0.0},
                                                             {0.795, 0.0}}};
/// Foot rings: centre (forward of the ankle's foot origin, height) and the tilt of the plane from level to upright.
struct FootRing {
    double forward, height, tilt;
};
constexpr std::array<FootRing, kLegLastRing - kAnkleRing> kFootRings = {
    {{-0.006, 0.062, 30.0}, {0.002, 0.044, 62.0}, {0.055, 0.034, 84.0}, {0.108, 0.026, 90.0}, {0.158, 0.020, 90.0}}};

class Placer {
  public:
    Placer(const BodyField& field, const BodyTopology& topology) : field_(field), topology_(topology) {}

    /// The first place of each left-hand vertex, on or near the skin.
    [[nodiscard]] Vec3 place(std::size_t vertex) const {
        const LatticePlace& place = topology_.places[vertex];
        switch (place.chart) {
            case Chart::leftArm:
                return place.cap ? fingerTip(place.column) : arm(place.ring, place.column);
            case Chart::leftThumb:
                return thumb(place.ring, place.column);
            case Chart::leftLeg:
                if (place.cap) return toe(place.column);
                return place.ring == 0 ? crotch(place.column) : leg(place.ring, place.column);
            default:
                return place.cap ? crown(place.column) : trunk(place.ring, place.column);
        }
    }

  private:
    [[nodiscard]] Vec3 trunk(int ring, int column) const {
        const RingHeights& heights = kTrunkRings[static_cast<std::size_t>(ring)];
        const double angle = 2.0 * kPi * column / kTrunkColumns;
        const double forward = std::cos(angle);
        const double ends = forward >= 0.0 ? heights.front : heights.back;
        const double y = heights.side + (ends - heights.side) * forward * forward;
        const Vec3 centre = field_.trunkLoft().centre(std::min(y, 1.56));
        const Vec3 origin(0.0, y, y > 1.53 ? 0.006 : centre.z());
        // Equal steps of an ellipse's parameter set columns closer where the side turns.
        const double flatness = ring >= 14 ? 1.0 : 0.72;
        const Vec3 direction = Vec3(std::sin(angle), 0.0, flatness * forward).normalized();
        Vec3 result = castOut([&](const Vec3& p) { return field_.trunk(p); }, origin, direction, 0.30);
        if (column == 0 || column == kTrunkColumns / 2) result.x() = 0.0;
        return result;
    }
    [[nodiscard]] Vec3 crown(int number) const {
        const int b = number % 5;
        const int a = number / 5;
        const Vec3 direction = Vec3(0.42 * (b - 2), 0.80, -0.50 * (a - 2)).normalized();
        return castOut([&](const Vec3& p) { return field_.trunk(p); }, Vec3(0.0, 1.670, 0.002), direction, 0.2);
    }
    [[nodiscard]] Vec3 arm(int ring, int column) const {
        const LimbRing& limbRing = kArmRings[static_cast<std::size_t>(ring)];
        const Loft& loft = field_.armLoft();
        double angle = 2.0 * kPi * column / kArmColumns;
        if (ring > kWristRing) angle += 0.10 * std::sin(4.0 * angle);  // Closer to the edges of the flat hand.
        const double along = limbRing.along + limbRing.shift * 0.5 * (1.0 - std::cos(angle));
        const Vec3 direction = std::cos(angle) * loft.shape().second + std::sin(angle) * loft.shape().first;
        return castOut([&](const Vec3& p) { return field_.arm(p); }, loft.centre(along), direction, 0.12);
    }
    [[nodiscard]] Vec3 fingerTip(int number) const {
        const int a = number / 3;
        const Loft& loft = field_.armLoft();
        const Vec3 origin = loft.centre(0.690);
        const Vec3 direction = (loft.shape().axis + 0.12 * (1.5 - a) * loft.shape().second).normalized();
        return castOut([&](const Vec3& p) { return field_.arm(p); }, origin, direction, 0.08);
    }
    [[nodiscard]] Vec3 thumb(int ring, int column) const {
        const Vec3 root = field_.thumbRoot();
        const Vec3 tip = field_.thumbTip();
        const Vec3 axis = (tip - root).normalized();
        const Vec3 up = field_.armLoft().shape().second;
        const Vec3 side = axis.cross(up).normalized();
        const Vec3 top = side.cross(axis);
        // Columns 0 to 2 are the outer edge from wrist to tip, 3 to 5 come back on the palm's side.
        const std::array<Vec2, kThumbColumns> kOutline = {Vec2{-0.8, 0.75}, Vec2{0.0, 1.0},  Vec2{0.8, 0.75},
                                                          Vec2{0.8, -0.75}, Vec2{0.0, -1.0}, Vec2{-0.8, -0.75}};
        const Vec2& outline = kOutline[static_cast<std::size_t>(column)];
        const double along = ring == 1 ? 0.66 : 1.02;
        const double radius = ring == 1 ? 0.0125 : 0.0085;
        // `side` points towards the tip of the hand or away from it, by the handedness of the frame.
        const double sign = side.dot(field_.armLoft().shape().axis) > 0.0 ? 1.0 : -1.0;
        return root + along * (tip - root) + radius * (sign * outline.x() * side + outline.y() * top);
    }
    [[nodiscard]] Vec3 crotch(int column) const {
        const std::array<Vec3, 3> kCrotch = {Vec3{0.0, 0.806, -0.060}, Vec3{0.0, 0.796, -0.010},
                                             Vec3{0.0, 0.806, 0.045}};
        return kCrotch[static_cast<std::size_t>(column - 9)];
    }
    [[nodiscard]] Vec3 leg(int ring, int column) const {
        const double angle = 2.0 * kPi * (4 - column) / kLegColumns;
        const Field field = [&](const Vec3& p) { return field_.leg(p); };
        if (ring <= kAnkleRing) {
            const LimbRing& limbRing = kLegRings[static_cast<std::size_t>(ring)];
            const Loft& loft = field_.legLoft();
            const double along = limbRing.along + limbRing.shift * 0.5 * (1.0 - std::cos(angle));
            const Vec3 direction = std::cos(angle) * loft.shape().second + std::sin(angle) * loft.shape().first;
            return castOut(field, loft.centre(along), direction, 0.16);
        }
        const FootRing& footRing = kFootRings[static_cast<std::size_t>(ring - kAnkleRing - 1)];
        const Loft& loft = field_.footLoft();
        const double tilt = footRing.tilt * kPi / 180.0;
        const Vec3 front = std::cos(tilt) * loft.shape().axis + std::sin(tilt) * Vec3::UnitY();
        const Vec3 centre =
            loft.shape().origin + footRing.forward * loft.shape().axis + footRing.height * Vec3::UnitY();
        const Vec3 direction = std::cos(angle) * loft.shape().second + std::sin(angle) * front;
        return castOut(field, centre, direction, 0.12);
    }
    [[nodiscard]] Vec3 toe(int number) const {
        const int b = number % 5;
        const Loft& loft = field_.footLoft();
        const Vec3 origin = loft.shape().origin + 0.165 * loft.shape().axis + 0.016 * Vec3::UnitY();
        const Vec3 direction = (loft.shape().axis + 0.45 * (b - 2) * loft.shape().second).normalized();
        return castOut([&](const Vec3& p) { return field_.leg(p); }, origin, direction, 0.08);
    }

    const BodyField& field_;
    const BodyTopology& topology_;
};

/// How a vertex is laid onto the skin: along the surface's slope, or, where the flesh is thin and comes to an end,
/// straight out from its middle.
enum class Zone : std::uint8_t { skin, hand, thumb, foot };

std::vector<Zone> zonesOf(const QuadMesh& mesh) {
    std::vector<Zone> zones(mesh.positions.size(), Zone::skin);
    for (const QuadMesh::Quad& quad : mesh.quads) {
        for (std::size_t c = 0; c < 4; ++c) {
            Zone& zone = zones[quad.vertex[c]];
            const double ring = quad.lattice[c].x();
            if (quad.chart == Chart::leftArm && ring > kThumbFirstRing + 2.2 && zone == Zone::skin) zone = Zone::hand;
            if (quad.chart == Chart::leftThumb && ring > 1.0) zone = Zone::thumb;
            if (quad.chart == Chart::leftLeg && ring > kAnkleRing + 3.2) zone = Zone::foot;
        }
    }
    return zones;
}

Vec3 layOut(const BodyField& field, Zone zone, const Vec3& place) {
    constexpr double kReach = 0.12;
    const auto castFrom = [&](const Vec3& anchor, const Field& flesh) {
        return castOut(flesh, anchor, (place - anchor).normalized(), kReach);
    };
    const auto along = [&](const Loft& loft, double from, double to) {
        return loft.centre(std::clamp((place - loft.shape().origin).dot(loft.shape().axis), from, to));
    };
    switch (zone) {
        case Zone::hand:
            return castFrom(along(field.armLoft(), 0.5, 0.690), [&](const Vec3& p) { return field.arm(p); });
        case Zone::foot:
            return castFrom(along(field.footLoft(), -0.015, 0.158), [&](const Vec3& p) { return field.leg(p); });
        case Zone::thumb: {
            const Vec3 root = field.thumbRoot();
            const Vec3 thumb = field.thumbTip() - root;
            const double t = std::clamp((place - root).dot(thumb) / thumb.squaredNorm(), 0.0, 0.95);
            return castFrom(root + t * thumb, [&](const Vec3& p) { return field.whole(p); });
        }
        case Zone::skin:
            break;
    }
    return place;
}

/// Lays the vertices of the left half onto the skin and copies them to the right.
void settle(QuadMesh& mesh, const std::vector<std::uint8_t>& left, const BodyField& field) {
    const std::vector<Zone> zones = zonesOf(mesh);
    const Field whole = [&](const Vec3& p) { return field.whole(p); };
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        if (left[v] == 0) continue;
        mesh.positions[v] = project(whole, layOut(field, zones[v], mesh.positions[v]), 0.0, mesh.onMidPlane(v));
    }
    mirrorPositions(mesh, left);
}

/// Evens the quads out along the surface: each vertex goes part of the way to its neighbours' mean. Ends of limbs stay.
void relax(QuadMesh& mesh, const std::vector<std::uint8_t>& left, const BodyField& field, int rounds, double share) {
    const auto around = neighbours(mesh);
    const std::vector<Zone> zones = zonesOf(mesh);
    const Field whole = [&](const Vec3& p) { return field.whole(p); };
    for (int round = 0; round < rounds; ++round) {
        std::vector<Vec3> moved = mesh.positions;
        for (std::size_t v = 0; v < moved.size(); ++v) {
            if (left[v] == 0 || zones[v] != Zone::skin) continue;
            Vec3 mean = Vec3::Zero();
            for (const std::uint32_t other : around[v]) {
                mean += mesh.positions[other];
            }
            const Vec3 step = mean / static_cast<double>(around[v].size()) - moved[v];
            const Vec3 normal = gradient(whole, mesh.positions[v]).normalized();
            moved[v] = project(whole, moved[v] + share * (step - step.dot(normal) * normal), 0.0, mesh.onMidPlane(v));
        }
        mesh.positions = std::move(moved);
        mirrorPositions(mesh, left);
    }
}

/// Render mesh: the fine mesh split where UV islands meet.
RestMesh renderMesh(const QuadMesh& fine, const std::vector<SkinningWeights>& weights) {
    std::vector<Triangle> triangles;
    for (const QuadMesh::Quad& quad : fine.quads) {
        for (const Triangle& triangle : cut(quad)) {
            triangles.push_back(triangle);
        }
    }
    const std::vector<Vec3> normals = vertexNormals(fine.positions, triangles);
    RestMesh mesh;
    std::map<std::pair<std::uint32_t, Chart>, std::uint32_t> numberOf;
    for (const QuadMesh::Quad& quad : fine.quads) {
        std::array<std::uint32_t, 4> corner{};
        for (std::size_t c = 0; c < 4; ++c) {
            const auto [found, isNew] =
                numberOf.try_emplace({quad.vertex[c], quad.chart}, static_cast<std::uint32_t>(mesh.positions.size()));
            if (isNew) {
                mesh.positions.push_back(fine.positions[quad.vertex[c]].cast<float>());
                mesh.normals.push_back(normals[quad.vertex[c]].cast<float>());
                mesh.uv.push_back(quad.uv[c].cast<float>());
                mesh.weights.push_back(weights[quad.vertex[c]]);
            }
            corner[c] = found->second;
        }
        mesh.triangles.push_back({corner[0], corner[1], corner[2]});
        mesh.triangles.push_back({corner[0], corner[2], corner[3]});
    }
    return mesh;
}

}  // namespace

BodyModel makeBody() {
    BodyModel model;
    model.topology = makeTopology();
    QuadMesh& coarse = model.topology.mesh;
    const Field whole = [&](const Vec3& point) { return model.field.whole(point); };

    const std::vector<std::uint8_t> coarseLeft = leftHalf(coarse);
    const Placer placer(model.field, model.topology);
    for (std::size_t v = 0; v < coarse.positions.size(); ++v) {
        if (coarseLeft[v] != 0) coarse.positions[v] = placer.place(v);
    }
    mirrorPositions(coarse, coarseLeft);
    settle(coarse, coarseLeft, model.field);
    relax(coarse, coarseLeft, model.field, 4, 0.25);

    model.fine = coarse;
    for (int level = 0; level < kSubdivisions; ++level) {
        model.fine = subdivide(model.fine);
        model.fineLeft = leftHalf(model.fine);
        settle(model.fine, model.fineLeft, model.field);
        relax(model.fine, model.fineLeft, model.field, 2, 0.3);
    }
    // The cage's vertices are the fine mesh's first ones, moved out.
    QuadMesh cage = coarse;
    std::copy_n(model.fine.positions.begin(), cage.positions.size(), cage.positions.begin());
    coarse.positions = cage.positions;
    for (std::size_t v = 0; v < cage.positions.size(); ++v) {
        if (coarseLeft[v] == 0) continue;
        cage.positions[v] = project(whole, cage.positions[v], kCageDistance, cage.onMidPlane(v));
    }
    mirrorPositions(cage, coarseLeft);
    model.fineWeights = skinningWeights(model.fine, model.field);

    Body& body = model.body;
    body.cageTemplate = model.topology.cageTemplate;
    for (const std::uint32_t v : model.topology.meshVertexOf) {
        body.outerCage.emplace_back(cage.positions[v].cast<float>());
        body.cageWeights.push_back(model.fineWeights[v]);
    }
    body.mesh = renderMesh(model.fine, model.fineWeights);
    for (std::size_t j = 0; j < kJointCount; ++j) {
        body.joints[j] = model.field.joints()[j].cast<float>();
    }
    body.meshWeld = weldPoints(body.mesh.positions);
    body.material.name = "Mannequin";
    body.material.baseColour = Eigen::Vector4f(0.80F, 0.775F, 0.745F, 1.0F);
    body.material.roughness = 0.55F;
    makeBodyShapes(model);
    return model;
}

}  // namespace cheval::fitting::bake

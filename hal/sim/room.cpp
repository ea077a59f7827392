#include "hal/sim/room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "hal/sim/canvas.h"
#include "hal/sim/hash.h"
#include "hal/sim/loft.h"
#include "hal/sim/motion.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kBaseboard = 0.11F;
constexpr float kPanelRail = 0.98F;  ///< Height of the moulding that ends the lower panels.
constexpr float kRackX = 1.36F;      ///< Middle of the rack, which stands along the wall.
constexpr float kRackZ = 3.62F;
constexpr float kRackHalfWidth = 0.62F;
constexpr float kRackHeight = 1.52F;

float smooth(float from, float to, float value) {
    const float u = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
    return u * u * (3.0F - 2.0F * u);
}

/// 1 on a line of half width `half` at 0, falling off over `blur`.
float line(float distance, float half, float blur) {
    return 1.0F - smooth(half, half + blur, std::abs(distance));
}

/// Oak boards that run towards the glass.
Vector3f floorColour(const Vector3f& p) {
    constexpr float kBoard = 0.16F;
    const float across = p.x() / kBoard;
    const auto board = static_cast<std::int32_t>(std::floor(across));
    const std::uint32_t key = scramble(static_cast<std::uint32_t>(board + 4096), 11U);
    const float length = 1.5F;
    const float alongBoard = p.z() / length + unitInterval(key);
    const auto piece = static_cast<std::int32_t>(std::floor(alongBoard));
    const std::uint32_t pieceKey = scramble(key, static_cast<std::uint32_t>(piece + 64));
    const float tone = unitInterval(pieceKey) - 0.5F;
    // Grain stretched along the board; two waves that never line up.
    const float phase = 40.0F * unitInterval(scramble(pieceKey));
    const float grain = 0.5F * std::sin(70.0F * p.x() + 1.7F * std::sin(2.3F * p.z() + phase) + phase) +
                        0.5F * std::sin(153.0F * p.x() + 1.1F * std::sin(3.1F * p.z() + 2.0F * phase));
    Vector3f colour = Vector3f(0.660F, 0.535F, 0.415F) * (1.0F + 0.10F * tone + 0.018F * grain);
    const float edge = std::abs(across - std::round(across)) * kBoard;
    const float butt = std::abs(alongBoard - std::round(alongBoard)) * length;
    // Joints fade with distance, as they would through a lens.
    const float fade = 1.0F - smooth(2.5F, 4.2F, p.z());
    colour *= 1.0F - 0.22F * (0.35F + 0.65F * fade) * std::max(line(edge, 0.001F, 0.004F), line(butt, 0.001F, 0.004F));
    return colour;
}

Vector3f wallColour(const Vector3f& p) {
    Vector3f colour(0.855F, 0.835F, 0.800F);
    if (p.y() < kBaseboard) {
        colour = Vector3f(0.925F, 0.915F, 0.895F) * (1.0F - 0.18F * line(p.y() - kBaseboard, 0.002F, 0.008F));
    } else if (p.y() < kPanelRail) {
        colour = Vector3f(0.660F, 0.705F, 0.680F);
        // Framed panels: a light upper and a shaded lower edge of each moulding.
        constexpr float kPanel = 0.74F;
        const float x = p.x() + 0.37F;
        const float inPanel = std::abs(x - kPanel * std::round(x / kPanel));
        const float side = 0.5F * kPanel - 0.07F - inPanel;
        const float height = std::min(p.y() - (kBaseboard + 0.09F), kPanelRail - 0.11F - p.y());
        const float frame = std::min(side, height);
        const bool upperEdge = p.y() > 0.5F * (kBaseboard + kPanelRail);
        const float lit = upperEdge ? -0.10F : 0.07F;
        colour *= 1.0F + lit * line(frame, 0.006F, 0.008F) - 0.08F * line(frame - 0.02F, 0.002F, 0.007F);
        if (frame > 0.02F) colour *= 1.015F;
    } else if (p.y() < kPanelRail + 0.05F) {
        const float v = (p.y() - kPanelRail) / 0.05F;
        colour = Vector3f(0.925F, 0.915F, 0.895F) * (0.90F + 0.12F * smooth(0.1F, 0.9F, v));
    }
    return colour;
}

/// A round rug marks where to stand.
Vector3f rugOver(const Vector3f& floor, const Vector3f& p) {
    const float radius = Vector2f(p.x(), p.z() - kStandDepth).norm();
    constexpr float kRadius = 0.72F;
    if (radius > kRadius + 0.01F) return floor;
    Vector3f rug(0.735F, 0.715F, 0.680F);
    rug *= 1.0F + 0.015F * std::sin(160.0F * radius);
    rug = rug - line(radius - 0.62F, 0.012F, 0.008F) * Vector3f(0.20F, 0.15F, 0.13F);
    const float share = 1.0F - smooth(kRadius - 0.004F, kRadius + 0.006F, radius);
    return (1.0F - share) * floor + share * rug;
}

float shadowOfRack(const Vector3f& p) {
    const float dx = std::max(0.0F, std::abs(p.x() - kRackX) - 0.5F * kRackHalfWidth);
    const float dz = p.z() - kRackZ;
    return 1.0F - 0.42F * std::exp(-(dx * dx) / 0.07F - (dz * dz) / 0.07F) * std::exp(-1.2F * p.y());
}

/// Light on walls and floor: pools from lamps above, darker towards corners.
Vector3f lit(const Vector3f& colour, const Vector3f& p, bool isFloor) {
    float light = 0.0F;
    if (isFloor) {
        const float dx = p.x();
        const float dz = p.z() - 2.4F;
        light = 0.80F + 0.22F * std::exp(-(dx * dx + dz * dz) / 2.2F) - 0.20F * smooth(3.6F, kWallDepth, p.z());
    } else {
        const float left = p.x() + 1.05F;
        const float right = p.x() - 1.05F;
        const float high = p.y() - 2.05F;
        light = 0.80F +
                0.20F * (std::exp(-(left * left) / 0.7F - high * high / 1.3F) +
                         std::exp(-(right * right) / 0.7F - high * high / 1.3F)) -
                0.10F * smooth(0.35F, 0.0F, p.y());
    }
    light *= shadowOfRack(p);
    return light * colour.cwiseProduct(Vector3f(1.0F, 0.992F, 0.975F));
}

void paintShell(const View& view, Canvas& canvas) {
    for (int y = 0; y < canvas.sampleHeight(); ++y) {
        for (int x = 0; x < canvas.sampleWidth(); ++x) {
            const float u = (static_cast<float>(x) + 0.5F) / kSamplesAcross - 0.5F;
            const float v = (static_cast<float>(y) + 0.5F) / kSamplesAcross - 0.5F;
            const Vector3f ray = view.ray(u, v);
            const float toWall = (kWallDepth - view.place().z()) / ray.z();
            const float toFloor = ray.y() < 0.0F ? -view.place().y() / ray.y() : 1e9F;
            const bool isFloor = toFloor < toWall;
            const float distance = isFloor ? toFloor : toWall;
            if (!(distance > 0.0F)) continue;
            const Vector3f p = view.place() + distance * ray;
            const Vector3f colour =
                lit(isFloor ? rugOver(floorColour(p), p) : wallColour(p), p, isFloor).cwiseMin(1.0F).cwiseMax(0.0F);
            // Rounded up or down by chance, so that slow gradients show no bands.
            const float chance = unitInterval(scramble(static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(x)));
            const auto byte = [chance](float value) { return static_cast<std::uint32_t>(254.99F * value + chance); };
            // The ray is one metre deep along the optical axis, so its factor is the depth.
            canvas.put(x, y, 1.0F / distance,
                       paint(byte(colour.x()), byte(colour.y()), byte(colour.z()), Material::room));
        }
    }
}

void addTube(Mesh& mesh, const Vector3f& from, const Vector3f& to, float radius, const Vector3f& colour) {
    const Vector3f along = (to - from).normalized();
    const Vector3f side = std::abs(along.y()) > 0.9F ? Vector3f::UnitX() : Vector3f::UnitY();
    const Vector3f across = (side - side.dot(along) * along).normalized();
    const Vector3f ahead = along.cross(across);
    std::array<Ring, 2> rings;
    for (std::size_t i = 0; i < 2; ++i) {
        rings[i] = {.centre = i == 0 ? from : to,
                    .across = across,
                    .ahead = ahead,
                    .halfWidth = radius,
                    .front = radius,
                    .back = radius,
                    .colour = colour};
    }
    addLoft(mesh, rings, 12, Material::glossy, Cap::flat, Cap::flat);
}

/// Something on a hanger, seen edge-on: shoulders, a fall of cloth, a hem.
void addHanging(Mesh& mesh, float x, float width, float length, float thickness, float turn, const Vector3f& colour) {
    constexpr std::array<float, 9> kDown = {0.0F, 0.02F, 0.07F, 0.12F, 0.25F, 0.5F, 0.75F, 0.97F, 1.0F};
    constexpr std::array<float, 9> kWide = {0.14F, 0.35F, 0.80F, 1.0F, 0.98F, 0.93F, 0.96F, 1.0F, 0.96F};
    constexpr std::array<float, 9> kThick = {0.3F, 0.5F, 0.8F, 0.95F, 0.9F, 0.9F, 1.0F, 1.1F, 1.0F};
    std::array<Ring, 9> rings;
    const Vector3f across(std::sin(turn), 0.0F, std::cos(turn));
    const Vector3f ahead = across.cross(Vector3f::UnitY());
    for (std::size_t i = 0; i < rings.size(); ++i) {
        rings[i] = {.centre = {x, kRackHeight - 0.075F - kDown[i] * length, kRackZ},
                    .across = across,
                    .ahead = ahead,
                    .halfWidth = width * kWide[i],
                    .front = thickness * kThick[i],
                    .back = thickness * kThick[i],
                    .colour = colour,
                    .squareness = 2.6F,
                    .shade = 0.92F - 0.12F * kDown[i]};
    }
    const std::size_t first = addLoft(mesh, rings, 28, Material::cloth, Cap::flat, Cap::flat);
    // Folds deepen towards the hem.
    for (std::size_t i = 3; i < rings.size(); ++i) {
        for (std::size_t j = 0; j < 28; ++j) {
            const float fold = std::sin(static_cast<float>(j) * 1.346F + 30.0F * x);
            Vector3f& p = mesh.positions[first + i * 28 + j];
            p += 0.004F * kDown[i] * fold * (p - rings[i].centre).normalized();
            mesh.albedo[first + i * 28 + j] *= 1.0F + 0.10F * kDown[i] * fold;
        }
    }
    addTube(mesh, {x, kRackHeight - 0.10F, kRackZ}, {x, kRackHeight + 0.015F, kRackZ}, 0.004F, {0.62F, 0.60F, 0.57F});
}

void buildRack(std::uint32_t seed, Mesh& mesh) {
    const Vector3f steel(0.33F, 0.32F, 0.31F);
    const float left = kRackX - kRackHalfWidth;
    const float right = kRackX + kRackHalfWidth;
    addTube(mesh, {left, kRackHeight, kRackZ}, {right, kRackHeight, kRackZ}, 0.014F, steel);
    for (const float x : {left, right}) {
        addTube(mesh, {x, 0.03F, kRackZ}, {x, kRackHeight + 0.012F, kRackZ}, 0.014F, steel);
        addTube(mesh, {x, 0.03F, kRackZ - 0.24F}, {x, 0.03F, kRackZ + 0.24F}, 0.014F, steel);
    }
    addTube(mesh, {left, 0.16F, kRackZ}, {right, 0.16F, kRackZ}, 0.010F, steel);
    constexpr std::array<std::array<float, 3>, 7> kColours = {{{0.79F, 0.60F, 0.50F},
                                                               {0.86F, 0.83F, 0.77F},
                                                               {0.48F, 0.58F, 0.66F},
                                                               {0.70F, 0.73F, 0.66F},
                                                               {0.84F, 0.76F, 0.58F},
                                                               {0.58F, 0.46F, 0.47F},
                                                               {0.74F, 0.77F, 0.81F}}};
    Draw draw(scramble(seed, 0x7acU));
    constexpr int kPieces = 9;
    std::uint32_t colour = draw.choice(7);
    for (int i = 0; i < kPieces; ++i) {
        const float x = left + 0.10F + (2.0F * kRackHalfWidth - 0.20F) * static_cast<float>(i) / (kPieces - 1) +
                        draw.between(-0.015F, 0.015F);
        colour = (colour + 1 + draw.choice(5)) % 7;
        addHanging(mesh, x, draw.between(0.19F, 0.225F), draw.between(0.62F, 1.02F), draw.between(0.026F, 0.042F),
                   draw.between(-0.22F, 0.22F), {kColours[colour][0], kColours[colour][1], kColours[colour][2]});
    }
}

}  // namespace

Room makeRoom(const View& view, std::uint32_t seed) {
    const Intrinsics& lens = view.intrinsics();
    Canvas canvas(lens.width, lens.height);
    paintShell(view, canvas);
    Mesh rack;
    buildRack(seed, rack);
    rack.finish();
    std::vector<CanvasVertex> vertices(rack.positions.size());
    if (!light(view, rack, rack.positions, rack.normals, vertices).empty()) canvas.draw(vertices, rack);

    Room room;
    room.colour.resize(lens.width, lens.height);
    room.depth.resize(lens.width, lens.height);
    room.material.resize(lens.width, lens.height, Material::room);
    for (int y = 0; y < lens.height; ++y) {
        for (int x = 0; x < lens.width; ++x) {
            std::array<std::uint32_t, 3> sum = {2, 2, 2};
            for (int sub = 0; sub < kSamplesAcross * kSamplesAcross; ++sub) {
                const Paint sample = canvas.paintRow(kSamplesAcross * y +
                                                     sub / kSamplesAcross)[kSamplesAcross * x + sub % kSamplesAcross];
                for (std::size_t c = 0; c < 3; ++c)
                    sum[c] += sample >> (8U * c) & 0xffU;
            }
            const Canvas::Pixel pixel = canvas.pixel(x, y);
            const auto channel = [&](std::size_t c) { return static_cast<std::uint8_t>(sum[c] / 4); };
            room.colour.view().at(x, y) = {channel(0), channel(1), channel(2)};
            room.depth.view().at(x, y) = pixel.samples > 0 ? 1000.0F / pixel.nearness : 0.0F;
            room.material.view().at(x, y) = materialOf(pixel.nearest);
        }
    }
    return room;
}

}  // namespace cheval::hal::sim

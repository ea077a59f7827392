#include "hal/sim/loft.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;

constexpr float kTau = 2.0F * std::numbers::pi_v<float>;
constexpr std::size_t kMaximumRings = 64;

void addVertex(Mesh& mesh, const Vector3f& position, const Ring& ring) {
    mesh.positions.push_back(position);
    mesh.albedo.push_back(ring.shade * toLinear(ring.colour));
    mesh.holds.push_back(ring.hold);
}

void addTriangle(Mesh& mesh, std::size_t a, std::size_t b, std::size_t c, bool flipped, Material material) {
    if (flipped) std::swap(b, c);
    mesh.triangles.push_back(
        {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
    mesh.materials.push_back(material);
}

}  // namespace

Vector3f pointOf(const Ring& ring, float angle) {
    const float power = 2.0F / ring.squareness;
    const auto swell = [power](float value) {
        return power == 1.0F ? value : std::copysign(std::pow(std::abs(value), power), value);
    };
    const float across = swell(std::cos(angle));
    const float ahead = swell(std::sin(angle));
    return ring.centre + across * ring.halfWidth * ring.across +
           ahead * (ahead > 0.0F ? ring.front : ring.back) * ring.ahead;
}

void Mesh::reserve(std::size_t vertices, std::size_t triangleCount) {
    positions.reserve(vertices);
    normals.reserve(vertices);
    albedo.reserve(vertices);
    holds.reserve(vertices);
    triangles.reserve(triangleCount);
    materials.reserve(triangleCount);
    // Only hanging cloth has folds: a small part of all.
    folds.reserve(vertices / 6);
}

void Mesh::clear() {
    positions.clear();
    normals.clear();
    albedo.clear();
    holds.clear();
    triangles.clear();
    materials.clear();
    folds.clear();
}

void Mesh::finish() {
    normals.assign(positions.size(), Vector3f::Zero());
    for (const auto& [a, b, c] : triangles) {
        const Vector3f face = (positions[b] - positions[a]).cross(positions[c] - positions[a]);
        normals[a] += face;
        normals[b] += face;
        normals[c] += face;
    }
    for (Vector3f& normal : normals)
        normal = normal.norm() > 0.0F ? normal.normalized() : Vector3f::UnitY();
}

std::size_t addLoft(Mesh& mesh, std::span<const Ring> rings, int segments, Material material, Cap start, Cap end) {
    const std::size_t first = mesh.positions.size();
    const std::size_t count = std::min(rings.size(), kMaximumRings);
    const auto n = static_cast<std::size_t>(segments);
    for (const Ring& ring : rings.first(count)) {
        for (int j = 0; j < segments; ++j) {
            addVertex(mesh, pointOf(ring, kTau * static_cast<float>(j) / static_cast<float>(segments)), ring);
        }
    }
    const Vector3f along = rings[count - 1].centre - rings[0].centre;
    const bool flipped = rings[0].across.cross(rings[0].ahead).dot(along) < 0.0F;
    for (std::size_t i = 0; i + 1 < count; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
            const std::size_t a = first + i * n + j;
            const std::size_t b = first + i * n + (j + 1) % n;
            addTriangle(mesh, a, b, a + n, flipped, material);
            addTriangle(mesh, b, b + n, a + n, flipped, material);
        }
    }
    const auto close = [&](std::size_t ring, bool atEnd) {
        const std::size_t centre = mesh.positions.size();
        addVertex(mesh, rings[ring].centre, rings[ring]);
        for (std::size_t j = 0; j < n; ++j) {
            addTriangle(mesh, centre, first + ring * n + j, first + ring * n + (j + 1) % n, flipped == atEnd, material);
        }
    };
    if (start == Cap::flat) close(0, false);
    if (end == Cap::flat) close(count - 1, true);
    return first;
}

void addEllipsoid(Mesh& mesh, const Ellipsoid& ellipsoid, int segments, int rings, Material material) {
    std::array<Ring, kMaximumRings> sections;
    const std::size_t count = std::min(static_cast<std::size_t>(rings), kMaximumRings);
    for (std::size_t i = 0; i < count; ++i) {
        const float angle = kTau * 0.5F * (static_cast<float>(i) + 0.5F) / static_cast<float>(count);
        const float radius = std::sin(angle);
        sections[i] = {.centre = ellipsoid.centre - std::cos(angle) * ellipsoid.halfSize.y() * ellipsoid.up,
                       .across = ellipsoid.across,
                       .ahead = ellipsoid.ahead,
                       .halfWidth = radius * ellipsoid.halfSize.x(),
                       .front = radius * ellipsoid.halfSize.z(),
                       .back = radius * ellipsoid.halfSize.z(),
                       .hold = ellipsoid.hold,
                       .colour = ellipsoid.colour,
                       .shade = ellipsoid.shade};
    }
    addLoft(mesh, std::span(sections).first(count), segments, material, Cap::flat, Cap::flat);
}

}  // namespace cheval::hal::sim

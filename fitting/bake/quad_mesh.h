// A mesh of quads that knows its mirror image and where each corner lies in the body's lattice of rings and columns.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fitting/bake/body_field.h"
#include "fitting/mesh.h"

namespace cheval::fitting::bake {

/// A piece of the body with rings and columns of its own; also an island of the shared UV.
enum class Chart : std::uint8_t { trunk, leftArm, leftThumb, leftLeg, rightArm, rightThumb, rightLeg };
inline constexpr std::size_t kChartCount = 7;

constexpr Chart mirrorOf(Chart chart) {
    const auto number = static_cast<std::uint8_t>(chart);
    if (number == 0) return chart;
    return static_cast<Chart>(number <= 3 ? number + 3 : number - 3);
}

/// Quads counter-clockwise from outside.
struct QuadMesh {
    struct Quad {
        std::array<std::uint32_t, 4> vertex{};
        std::array<Vec2, 4> lattice;  ///< (ring, column) of each corner in its chart; column may run past the wrap.
        std::array<Vec2, 4> uv;       ///< Shared UV of each corner.
        Chart chart = Chart::trunk;
        bool cap = false;  ///< Closes a tube's end: its columns mean nothing.
    };
    std::vector<Vec3> positions;
    std::vector<Quad> quads;
    std::vector<std::uint32_t> mirrored;  ///< The vertex on the other side; itself on the mid-plane.

    [[nodiscard]] bool onMidPlane(std::size_t vertex) const { return mirrored[vertex] == vertex; }
};

/// Cuts each quad of a closed mesh into four. Vertices of `mesh` keep their numbers and places; then come one a face
/// and one an edge, in their middles: the surface that they are laid onto next makes them smooth.
QuadMesh subdivide(const QuadMesh& mesh);

/// Makes the right half the exact image of the left: positions with x > 0 are copied, those on the mid-plane get x = 0.
/// `left[v]` says which side a vertex was made for.
void mirrorPositions(QuadMesh& mesh, const std::vector<std::uint8_t>& left);

/// The vertices of the left half and the mid-plane: those that a quad of x ≥ 0 reaches.
std::vector<std::uint8_t> leftHalf(const QuadMesh& mesh);

/// The vertices joined to each vertex by an edge, in order of number.
std::vector<std::vector<std::uint32_t>> neighbours(const QuadMesh& mesh);

/// Two triangles a quad, along the diagonal from its first corner (quads and their images begin at the same corner).
std::array<Triangle, 2> cut(const QuadMesh::Quad& quad);

/// Area-weighted unit vertex normals.
std::vector<Vec3> vertexNormals(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles);

}  // namespace cheval::fitting::bake

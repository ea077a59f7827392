#include "fitting/bake/quad_mesh.h"

#include <algorithm>
#include <unordered_map>

#include <Eigen/Geometry>

namespace cheval::fitting::bake {
namespace {

struct Edge {
    std::uint32_t a = 0, b = 0;
};

std::uint64_t edgeKey(std::uint32_t a, std::uint32_t b) {
    return (static_cast<std::uint64_t>(std::min(a, b)) << 32U) | std::max(a, b);
}

}  // namespace

QuadMesh subdivide(const QuadMesh& mesh) {
    const auto vertexCount = static_cast<std::uint32_t>(mesh.positions.size());
    const auto faceCount = static_cast<std::uint32_t>(mesh.quads.size());
    std::vector<Edge> edges;
    std::unordered_map<std::uint64_t, std::uint32_t> edgeOf;
    for (std::uint32_t f = 0; f < faceCount; ++f) {
        for (std::size_t c = 0; c < 4; ++c) {
            const std::uint32_t a = mesh.quads[f].vertex[c];
            const std::uint32_t b = mesh.quads[f].vertex[(c + 1) % 4];
            const bool isNew = edgeOf.try_emplace(edgeKey(a, b), static_cast<std::uint32_t>(edges.size())).second;
            if (isNew) edges.push_back({a, b});
        }
    }
    const std::uint32_t firstEdge = vertexCount + faceCount;
    QuadMesh fine;
    fine.positions.assign(firstEdge + edges.size(), Vec3::Zero());
    fine.mirrored.assign(fine.positions.size(), 0);
    for (std::uint32_t f = 0; f < faceCount; ++f) {
        const QuadMesh::Quad& quad = mesh.quads[f];
        for (const std::uint32_t v : quad.vertex) {
            fine.positions[vertexCount + f] += 0.25 * mesh.positions[v];
        }
    }
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const Edge& edge = edges[e];
        fine.positions[firstEdge + e] = 0.5 * (mesh.positions[edge.a] + mesh.positions[edge.b]);
        fine.mirrored[firstEdge + e] = firstEdge + edgeOf.at(edgeKey(mesh.mirrored[edge.a], mesh.mirrored[edge.b]));
    }
    std::unordered_map<std::uint64_t, std::uint32_t> faceByDiagonal;
    for (std::uint32_t f = 0; f < faceCount; ++f) {
        const auto& v = mesh.quads[f].vertex;
        faceByDiagonal[edgeKey(v[0], v[2])] = f;
        faceByDiagonal[edgeKey(v[1], v[3])] = f;
    }
    for (std::uint32_t v = 0; v < vertexCount; ++v) {
        fine.positions[v] = mesh.positions[v];
        fine.mirrored[v] = mesh.mirrored[v];
    }
    fine.quads.reserve(4 * mesh.quads.size());
    for (std::uint32_t f = 0; f < faceCount; ++f) {
        const QuadMesh::Quad& quad = mesh.quads[f];
        fine.mirrored[vertexCount + f] =
            vertexCount + faceByDiagonal.at(edgeKey(mesh.mirrored[quad.vertex[0]], mesh.mirrored[quad.vertex[2]]));
        Vec2 latticeCentre = Vec2::Zero();
        Vec2 uvCentre = Vec2::Zero();
        for (std::size_t c = 0; c < 4; ++c) {
            latticeCentre += 0.25 * quad.lattice[c];
            uvCentre += 0.25 * quad.uv[c];
        }
        for (std::size_t c = 0; c < 4; ++c) {
            const std::size_t next = (c + 1) % 4;
            const std::size_t last = (c + 3) % 4;
            const auto edgeVertex = [&](std::size_t from, std::size_t to) {
                return firstEdge + edgeOf.at(edgeKey(quad.vertex[from], quad.vertex[to]));
            };
            QuadMesh::Quad child = quad;
            child.vertex = {quad.vertex[c], edgeVertex(c, next), vertexCount + f, edgeVertex(last, c)};
            child.lattice = {quad.lattice[c], 0.5 * (quad.lattice[c] + quad.lattice[next]), latticeCentre,
                             0.5 * (quad.lattice[c] + quad.lattice[last])};
            child.uv = {quad.uv[c], 0.5 * (quad.uv[c] + quad.uv[next]), uvCentre, 0.5 * (quad.uv[c] + quad.uv[last])};
            fine.quads.push_back(child);
        }
    }
    return fine;
}

std::vector<std::uint8_t> leftHalf(const QuadMesh& mesh) {
    // Charts of limbs have a side; the trunk's left half has columns of 0 to 8, its right half the negative ones.
    std::vector<std::uint8_t> left(mesh.positions.size(), 0);
    for (const QuadMesh::Quad& quad : mesh.quads) {
        const auto chart = static_cast<std::uint8_t>(quad.chart);
        const double columns = quad.lattice[0].y() + quad.lattice[1].y() + quad.lattice[2].y() + quad.lattice[3].y();
        if (chart == 0 ? columns > 0.0 : chart <= 3) {
            for (const std::uint32_t v : quad.vertex) {
                left[v] = 1;
            }
        }
    }
    return left;
}

void mirrorPositions(QuadMesh& mesh, const std::vector<std::uint8_t>& left) {
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        if (mesh.onMidPlane(v)) {
            mesh.positions[v].x() = 0.0;
        } else if (left[v] == 0) {
            const Vec3& other = mesh.positions[mesh.mirrored[v]];
            mesh.positions[v] = Vec3(-other.x(), other.y(), other.z());
        }
    }
}

std::vector<std::vector<std::uint32_t>> neighbours(const QuadMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> result(mesh.positions.size());
    for (const QuadMesh::Quad& quad : mesh.quads) {
        for (std::size_t c = 0; c < 4; ++c) {
            const std::uint32_t a = quad.vertex[c];
            const std::uint32_t b = quad.vertex[(c + 1) % 4];
            result[a].push_back(b);
            result[b].push_back(a);
        }
    }
    for (auto& list : result) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return result;
}

std::array<Triangle, 2> cut(const QuadMesh::Quad& quad) {
    const auto& v = quad.vertex;
    return {Triangle{v[0], v[1], v[2]}, Triangle{v[0], v[2], v[3]}};
}

std::vector<Vec3> vertexNormals(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles) {
    std::vector<Vec3> normals(positions.size(), Vec3::Zero());
    for (const Triangle& t : triangles) {
        const Vec3 cross = (positions[t.b] - positions[t.a]).cross(positions[t.c] - positions[t.a]);
        normals[t.a] += cross;
        normals[t.b] += cross;
        normals[t.c] += cross;
    }
    for (Vec3& normal : normals) {
        const double length = normal.norm();
        normal = length > 0.0 ? Vec3(normal / length) : Vec3::UnitY();
    }
    return normals;
}

}  // namespace cheval::fitting::bake

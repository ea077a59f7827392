// Smooth normals of a mesh whose vertices are doubled at UV seams.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fitting/mesh.h"

namespace cheval::fitting {

/// For every vertex the lowest one at exactly the same place. Takes memory; for load time.
std::vector<std::uint32_t> weldByPosition(std::span<const Eigen::Vector3f> positions);

/// Area-weighted unit normals, equal for vertices of one place; zero where no triangle has area. All per-vertex spans
/// have the same length.
void smoothNormals(std::span<const Eigen::Vector3f> positions, std::span<const Triangle> triangles,
                   std::span<const std::uint32_t> weld, std::span<Eigen::Vector3f> normals);

/// Turns `normal` by the smallest rotation that takes `from` to `to` (unit vectors). Unchanged when either is zero or
/// they are opposed, where no rotation is smallest.
Eigen::Vector3f turnAlong(const Eigen::Vector3f& normal, const Eigen::Vector3f& from, const Eigen::Vector3f& to);

}  // namespace cheval::fitting

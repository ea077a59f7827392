// How a render mesh hangs in its garment's two cages (A1): found once, evaluated for every body.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fitting/mesh.h"

namespace cheval::fitting {

/// One render vertex in the space between the cages:
/// p = Σ bᵢ·((1 − t)·innerᵢ + t·outerᵢ) + (Σ bᵢ·LDᵢ)·residual, over the corners i of one cage triangle.
/// The residual holds what the prism cannot (curvature within the triangle), so that a garment on its own body returns
/// itself exactly.
struct CageBinding {
    std::uint32_t triangle = 0;
    Eigen::Vector3f barycentric = Eigen::Vector3f(1, 0, 0);
    float betweenCages = 0.0F;  ///< t: 0 on the inner cage, 1 on the outer one.
    Eigen::Vector3f residual = Eigen::Vector3f::Zero();
};

/// Two cages of one template, metres.
struct CagePair {
    std::span<const Triangle> triangles;
    std::span<const Eigen::Vector3f> inner;
    std::span<const Eigen::Vector3f> outer;
};

/// Binds every vertex to the nearest triangle midway between the cages, among those whose corners are all covered and
/// that look the same way as the vertex (so that a sleeve does not bind to the flank beside it); any of the covered
/// ones where none does. Empty when no triangle is covered. Takes memory; for load time.
std::vector<CageBinding> bindToCages(const CagePair& cages, std::span<const std::uint8_t> covered,
                                     std::span<const Eigen::Vector3f> positions,
                                     std::span<const Eigen::Vector3f> normals);

/// Evaluates bindings. `positions` out, as long as `bindings`; `vertexTransforms` as TriangleDeformerJob leaves them.
void evaluateBindings(const CagePair& cages, std::span<const Eigen::Matrix3f> vertexTransforms,
                      std::span<const CageBinding> bindings, std::span<Eigen::Vector3f> positions);

/// The point of triangle abc nearest to `point`, as barycentric coordinates.
Eigen::Vector3f nearestBarycentric(const Eigen::Vector3f& point, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                   const Eigen::Vector3f& c);

}  // namespace cheval::fitting

// The triangle deformer (A2, [0131]–[0135]): carries a garment's outer cage from its own inner cage onto whatever lies
// below.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "fitting/mesh.h"

namespace cheval::fitting {

/// Sums of one cage vertex; scratch that the caller owns.
struct CageVertexSum {
    Eigen::Matrix3d transform = Eigen::Matrix3d::Zero();  ///< Σ area · LD
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();     ///< Σ area · LD · LO
    double area = 0.0;
};

/// One run of the deformer over a cage template. All per-vertex spans have the same length n; metres, rest pose.
///
/// Per triangle: LD = P·G⁻¹, where P and G have the columns u/|u|, v/|v| and w/|w| (two edges and their cross product)
/// of the triangle in the previous outer cage (POC) and in the garment's inner cage (GIC). Every corner sums area·LD·LO
/// with LO = GOC − GIC, and the area; vertices at one place share their sums, so that a seam cannot open. Then
/// new GOC = POC + Σ/Σ. Where the garment covers nothing the cage below passes through unchanged.
///
/// Invalid when spans differ in length, when a triangle or weld index is not below n, or when a weld target is not its
/// own target.
struct TriangleDeformerJob {
    std::span<const Triangle> triangles;
    std::span<const std::uint16_t> weld;     ///< Lowest vertex at the same place.
    std::span<const std::uint8_t> covered;   ///< A triangle counts when all its corners are covered.
    std::span<const Eigen::Vector3f> below;  ///< POC.
    std::span<const Eigen::Vector3f> inner;  ///< GIC.
    std::span<const Eigen::Vector3f> outer;  ///< GOC.

    std::span<CageVertexSum> sums;                ///< Scratch.
    std::span<Eigen::Vector3f> newOuter;          ///< Out: new GOC.
    std::span<Eigen::Matrix3f> vertexTransforms;  ///< Out: area-weighted mean of LD; identity where nothing counts.

    [[nodiscard]] bool isValid() const;
    /// False, and nothing written, when the job is invalid. Linear in triangles and vertices; takes no memory.
    [[nodiscard]] bool run() const;
};

}  // namespace cheval::fitting

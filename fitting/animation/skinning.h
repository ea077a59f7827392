// Linear blend skinning with four bones a vertex (D4).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Geometry>

#include "fitting/mesh.h"

namespace cheval::fitting {

/// An affine bone transform as the skinning takes it: four columns of 3×4 [A | t], each padded to four floats.
struct BoneMatrix {
    alignas(16) std::array<float, 16> columns{};

    BoneMatrix() = default;
    explicit BoneMatrix(const Eigen::Affine3f& transform);
};

/// Vertices in rest pose, structure of arrays; all spans have the same length.
struct SkinningSource {
    std::span<const float> x, y, z;     ///< Positions, metres.
    std::span<const float> nx, ny, nz;  ///< Normals.
    std::span<const float> u, v;        ///< Texture coordinates, copied through.
    std::span<const SkinningWeights> weights;
};

/// Poses vertices: each by the weighted sum of its bones' matrices, its normal by that sum's cofactors (which is the
/// inverse transpose but for length), normalised. Writes each output vertex once, in order.
///
/// Invalid when lengths differ or there is no bone. A joint number that is not below bones.size() is a fault of whoever
/// made the weights; isValid() finds it, run() does not look, since it runs every frame.
struct SkinningJob {
    SkinningSource source;
    std::span<const BoneMatrix> bones;
    std::span<PosedVertex> vertices;  ///< Out.

    /// Looks at every vertex: for load time, tests and assertions.
    [[nodiscard]] bool isValid() const;
    /// False, and nothing written, when lengths differ or there is no bone. Takes no memory.
    [[nodiscard]] bool run() const;

  private:
    [[nodiscard]] bool lengthsMatch() const;
};

}  // namespace cheval::fitting

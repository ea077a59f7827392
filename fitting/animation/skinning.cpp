#include "fitting/animation/skinning.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting {

BoneMatrix::BoneMatrix(const Eigen::Affine3f& transform) {
    for (std::size_t column = 0; column < 4; ++column) {
        for (std::size_t row = 0; row < 3; ++row) {
            columns[column * 4 + row] =
                transform.matrix()(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
        }
    }
}

bool SkinningJob::lengthsMatch() const {
    const std::size_t n = vertices.size();
    return !bones.empty() && source.x.size() == n && source.y.size() == n && source.z.size() == n &&
           source.nx.size() == n && source.ny.size() == n && source.nz.size() == n && source.u.size() == n &&
           source.v.size() == n && source.weights.size() == n;
}

bool SkinningJob::isValid() const {
    return lengthsMatch() &&
           std::all_of(source.weights.begin(), source.weights.end(), [this](const SkinningWeights& weights) {
               return std::all_of(std::begin(weights.joint), std::end(weights.joint),
                                  [this](std::uint8_t joint) { return joint < bones.size(); });
           });
}

bool SkinningJob::run() const {
    if (!lengthsMatch()) return false;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const SkinningWeights& weights = source.weights[i];
        // Sixteen floats at a time, which the compiler turns into four vector lanes of four.
        alignas(16) float m[16];
        const float* const bone0 = bones[weights.joint[0]].columns.data();
        const float* const bone1 = bones[weights.joint[1]].columns.data();
        const float* const bone2 = bones[weights.joint[2]].columns.data();
        const float* const bone3 = bones[weights.joint[3]].columns.data();
        for (std::size_t k = 0; k < 16; ++k) {
            m[k] = weights.weight[0] * bone0[k] + weights.weight[1] * bone1[k] + weights.weight[2] * bone2[k] +
                   weights.weight[3] * bone3[k];
        }
        const float x = source.x[i];
        const float y = source.y[i];
        const float z = source.z[i];
        const float nx = source.nx[i];
        const float ny = source.ny[i];
        const float nz = source.nz[i];
        // Cofactors of the 3×3 part, column by column: c1×c2, c2×c0, c0×c1.
        const float* const c0 = m;
        const float* const c1 = m + 4;
        const float* const c2 = m + 8;
        const float px = (c1[1] * c2[2] - c1[2] * c2[1]) * nx + (c2[1] * c0[2] - c2[2] * c0[1]) * ny +
                         (c0[1] * c1[2] - c0[2] * c1[1]) * nz;
        const float py = (c1[2] * c2[0] - c1[0] * c2[2]) * nx + (c2[2] * c0[0] - c2[0] * c0[2]) * ny +
                         (c0[2] * c1[0] - c0[0] * c1[2]) * nz;
        const float pz = (c1[0] * c2[1] - c1[1] * c2[0]) * nx + (c2[0] * c0[1] - c2[1] * c0[0]) * ny +
                         (c0[0] * c1[1] - c0[1] * c1[0]) * nz;
        const float length = std::sqrt(px * px + py * py + pz * pz);
        // Opposed bones can fold a vertex flat; its rest normal is then as good as any.
        const float scale = length > 1e-12F ? 1.0F / length : 0.0F;
        const bool flat = scale == 0.0F;
        vertices[i] = {.x = m[0] * x + m[4] * y + m[8] * z + m[12],
                       .y = m[1] * x + m[5] * y + m[9] * z + m[13],
                       .z = m[2] * x + m[6] * y + m[10] * z + m[14],
                       .nx = flat ? nx : px * scale,
                       .ny = flat ? ny : py * scale,
                       .nz = flat ? nz : pz * scale,
                       .u = source.u[i],
                       .v = source.v[i]};
    }
    return true;
}

}  // namespace cheval::fitting

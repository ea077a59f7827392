// Skinning weights copied from the body (C1).
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "fitting/mesh.h"

namespace cheval::fitting {

struct WeightTransferOptions {
    std::size_t neighbours = 8;  ///< Body vertices that a garment vertex takes its weights from.
};

/// Weights for vertices at `positions` (metres, rest pose of `body`) with unit `normals` of the same length: those of
/// the nearest body vertices that face the same way and belong to the same limb as the nearest of them, weighted by
/// inverse distance, at most four bones, sum 1. The map is made in the A-pose, where limbs stand apart, so a sleeve
/// takes nothing from the flank and a trouser leg nothing from the other leg. Empty when the body has no vertices.
/// Takes memory; for load time.
std::vector<SkinningWeights> transferWeights(const RestMesh& body, std::span<const Eigen::Vector3f> positions,
                                             std::span<const Eigen::Vector3f> normals,
                                             const WeightTransferOptions& options = {});

}  // namespace cheval::fitting

#include "fitting/garment/cage_matching.h"

#include <cstdio>
#include <limits>

namespace cheval::fitting {

namespace {

constexpr float kSeamTolerance = 1e-4F;  // metres

std::string decimal(float value) {
    char text[32];
    (void)std::snprintf(text, sizeof text, "%.6f", static_cast<double>(value));
    return text;
}

}  // namespace

Expected<std::vector<std::size_t>> matchCage(const AssetFile& asset, const AssetMesh& cage,
                                             const CageTemplate& cageTemplate) {
    const std::size_t count = cageTemplate.vertexCount();
    const std::vector<Eigen::Vector2f>& uv = cage.mesh.uv;
    if (uv.size() != count) {
        return asset.refuse(cage.node, "the cage has " + std::to_string(uv.size()) + " vertices",
                            "start from the body's cage and move its vertices only; export it shaded smooth",
                            "the template has " + std::to_string(count));
    }
    std::vector<std::size_t> vertexAt(count, count);
    for (std::size_t i = 0; i < count; ++i) {
        std::size_t nearest = 0;
        float squared = std::numeric_limits<float>::max();
        for (std::size_t j = 0; j < count; ++j) {
            const float distance = (uv[i] - cageTemplate.uv[j]).squaredNorm();
            if (distance < squared) {
                squared = distance;
                nearest = j;
            }
        }
        if (!(squared <= kUvTolerance * kUvTolerance)) {
            return asset.refuse(cage.node,
                                "the UV of vertex " + std::to_string(i) + " (" + decimal(uv[i].x()) + ", " +
                                    decimal(uv[i].y()) + ") lies " + decimal(std::sqrt(squared)) +
                                    " from the nearest template vertex, " + std::to_string(nearest),
                                "copy the UV map from the body's cage again",
                                "cages correspond by their UV, within " + decimal(kUvTolerance));
        }
        if (vertexAt[nearest] != count) {
            return asset.refuse(cage.node,
                                "vertices " + std::to_string(vertexAt[nearest]) + " and " + std::to_string(i) +
                                    " have the UV of one template vertex, " + std::to_string(nearest),
                                "copy the UV map from the body's cage again", "cages correspond by their UV");
        }
        vertexAt[nearest] = i;
    }
    for (std::size_t j = 0; j < count; ++j) {
        const Eigen::Vector3f& place = cage.mesh.positions[vertexAt[j]];
        const Eigen::Vector3f& partner = cage.mesh.positions[vertexAt[cageTemplate.weld[j]]];
        if ((place - partner).norm() > kSeamTolerance) {
            return asset.refuse(cage.node,
                                "vertices " + std::to_string(vertexAt[cageTemplate.weld[j]]) + " and " +
                                    std::to_string(vertexAt[j]) + " of one seam lie " +
                                    decimal((place - partner).norm() * 1000.0F) + " mm apart",
                                "merge them by distance", "a cage is torn there");
        }
    }
    return vertexAt;
}

}  // namespace cheval::fitting

// A garment as loaded: validated, and its cages in template order (A9).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fitting/body/body.h"
#include "fitting/body/size_chart.h"
#include "fitting/material.h"
#include "fitting/mesh.h"
#include "hal/expected.h"

namespace cheval::fitting {

enum class GarmentKind : std::uint8_t { top, trousers, skirt, dress, outerwear, headwear, other };

/// Immutable asset. Rest pose of the reference body, metres.
struct Garment {
    std::string id;    ///< From the file's name, e.g. "tshirt".
    std::string name;  ///< For people, e.g. "T-shirt".
    GarmentKind kind = GarmentKind::other;
    std::uint8_t layerOrder = 1;             ///< 1 is worn innermost.
    float rigidity = 0.2F;                   ///< r of A7, 0…1.
    RestMesh mesh;                           ///< Weights copied from the body in rest pose (C1).
    std::vector<Eigen::Vector3f> innerCage;  ///< `<Garment>_InnerCage`, template order.
    std::vector<Eigen::Vector3f> outerCage;  ///< `<Garment>_OuterCage`, template order.
    std::vector<std::uint8_t>
        covered;  ///< Per cage vertex: 1 where the garment covers the body, else its cages do not count.
    std::vector<std::uint8_t> simulated;  ///< Per mesh vertex: 1 = free (D7).
    Material material;
    /// Whom it is cut for; nothing: the file does not say.
    std::optional<SizesFor> cutFor;
    /// Its maker's own chart, of the bodies that each size is for; nothing: it goes by the shop's.
    std::optional<SizeChart> sizes;
};

/// Limits that are checked before anything is allocated.
struct GarmentLimits {
    std::uint64_t fileBytes = 64ULL << 20;
    std::uint32_t vertices = 100'000;
    std::uint32_t triangles = 200'000;
    std::uint32_t texturePixels = 4096U * 4096U;
};

/// Loads and validates a garment for bodies with that template (format: fitting/garment/FORMAT.md). Refusals carry
/// cause, mend, why and the file: a missing cage, another vertex count, moved UV, NaN, an index out of range, a
/// truncated file, a buffer that claims more than the file holds.
Expected<Garment> loadGarment(const std::string& path, const CageTemplate& cageTemplate,
                              const GarmentLimits& limits = {});
/// As above; a garment without weights takes them from the body's mesh (C1).
Expected<Garment> loadGarment(const std::string& path, const Body& body, const GarmentLimits& limits = {});

/// As loadGarment, from memory; `file` is named in errors and gives the id.
Expected<Garment> parseGarment(std::span<const std::byte> bytes, const std::string& file,
                               const CageTemplate& cageTemplate, const GarmentLimits& limits = {});
Expected<Garment> parseGarment(std::span<const std::byte> bytes, const std::string& file, const Body& body,
                               const GarmentLimits& limits = {});

}  // namespace cheval::fitting

// Brings a garment's cage into template order by its UV (A9).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "fitting/body/cage_template.h"
#include "fitting/garment/asset_file.h"

namespace cheval::fitting {

/// How far a cage vertex may be from its template vertex in UV.
inline constexpr float kUvTolerance = 1e-4F;

/// For every template vertex, the vertex of `cage` with its UV. Refuses another number of vertices, a vertex whose UV
/// lies nowhere near (naming vertex and distance), two at one template vertex, and seam partners that do not share a
/// place within 0.1 mm. `asset` words the refusals.
Expected<std::vector<std::size_t>> matchCage(const AssetFile& asset, const AssetMesh& cage,
                                             const CageTemplate& cageTemplate);

}  // namespace cheval::fitting

// Which bone moves which piece of skin, and how much.
#pragma once

#include <vector>

#include "fitting/bake/body_field.h"
#include "fitting/bake/quad_mesh.h"
#include "fitting/mesh.h"

namespace cheval::fitting::bake {

/// Smooth weights for every vertex of a symmetric body mesh: bones are first laid out along the lattice, then their
/// borders are diffused over the skin, so that an arm takes nothing from the trunk beside it, nor a leg from the other.
/// At most four bones a vertex, largest first, summing to 1; the right side is the exact image of the left.
std::vector<SkinningWeights> skinningWeights(const QuadMesh& mesh, const BodyField& field);

}  // namespace cheval::fitting::bake

// Lays the template's topology onto the mannequin's surface: cage, smooth mesh, skeleton and skinning weights.
#pragma once

#include <vector>

#include "fitting/bake/body_field.h"
#include "fitting/bake/body_topology.h"
#include "fitting/body/body.h"

namespace cheval::fitting::bake {

/// The mannequin with all that the wardrobe is cut from.
struct BodyModel {
    BodyField field;
    BodyTopology topology;                     ///< Its positions are the coarse vertices on the skin.
    QuadMesh fine;                             ///< The skin; begins with the coarse vertices.
    std::vector<std::uint8_t> fineLeft;        ///< Per fine vertex: 1 on the left half or the mid-plane.
    std::vector<SkinningWeights> fineWeights;  ///< Per fine vertex.
    Body body;                                 ///< What the asset holds; its mesh is split at UV seams.
};

/// How far the body's outer cage lies outside the skin, metres.
inline constexpr double kCageDistance = 0.003;
/// Times that the coarse quads are subdivided for the render mesh.
inline constexpr int kSubdivisions = 2;

/// Makes the reference mannequin: 1.75 m tall, A-pose. The same bytes every time.
BodyModel makeBody();

}  // namespace cheval::fitting::bake

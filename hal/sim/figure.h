// The simulated shopper's surface: lofted torso, limbs, head, hands and clothes over the rig of rig.h.
#pragma once

#include <cstddef>

#include "hal/sim/loft.h"
#include "hal/sim/rig.h"
#include "hal/sim/shopper.h"

namespace cheval::hal::sim {

/// No shopper's mesh is larger; what is reserved once.
inline constexpr std::size_t kMaximumFigureVertices = 12'000;
inline constexpr std::size_t kMaximumFigureTriangles = 24'000;

/// Makes `mesh` the shopper in rest pose. Takes no memory when the mesh has kMaximumFigure… reserved.
void buildFigure(const Shopper& shopper, const Rig& rig, Mesh& mesh);

/// The trunk with neck, shirt and the trousers' seat (figure_trunk.cpp), the head with face and hair (figure_head.cpp),
/// one hand (figure_hand.cpp) and the wheelchair of who sits in one (figure_chair.cpp), as parts of buildFigure.
void addTrunk(const Shopper& shopper, const Rig& rig, Mesh& mesh);
void addHead(const Shopper& shopper, const Rig& rig, Mesh& mesh);
void addHand(const Shopper& shopper, const Rig& rig, fitting::Side side, Mesh& mesh);
void addWheelchair(const Shopper& shopper, const Rig& rig, Mesh& mesh);

}  // namespace cheval::hal::sim

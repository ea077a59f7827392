// The cage template's topology: rings of quads round trunk, arms and legs, written down once and frozen. Nothing here
// depends on the body's shape, so the template stays the same whatever the mannequin comes to look like.
#pragma once

#include <cstdint>
#include <vector>

#include "fitting/bake/quad_mesh.h"
#include "fitting/body/cage_template.h"

namespace cheval::fitting::bake {

inline constexpr int kTrunkColumns = 16;     ///< Round the trunk; column 0 is the front's middle, 4 the left side.
inline constexpr int kTrunkLastRing = 19;    ///< Ring 0 is the line of the legs, the last one below the crown.
inline constexpr int kArmholeFirstRing = 8;  ///< Of the trunk; the armhole spans columns 3 to 5.
inline constexpr int kArmholeLastRing = 11;
inline constexpr int kNecklineRing = 13;  ///< Trunk ring at the base of the neck.
inline constexpr int kArmColumns = 10;    ///< Column 0 is on top, then down the front.
inline constexpr int kArmLastRing = 17;   ///< Ring 0 is the armhole.
inline constexpr int kElbowRing = 8;
inline constexpr int kWristRing = 13;
inline constexpr int kThumbFirstRing = 14;  ///< Of the arm; the thumb grows out between columns 2 and 3.
inline constexpr int kThumbColumns = 6;
inline constexpr int kThumbLastRing = 2;
inline constexpr int kLegColumns = 12;   ///< Columns 0 to 8 go on from the trunk's; 9 to 11 begin at the crotch.
inline constexpr int kLegLastRing = 18;  ///< Ring 0 is the line of the leg.
inline constexpr int kKneeRing = 7;
inline constexpr int kAnkleRing = 13;

/// Where a vertex of the coarse mesh stands. Ring last + 1 is the inside of a cap, with `column` its running number.
struct LatticePlace {
    Chart chart = Chart::trunk;
    int ring = 0;
    int column = 0;
    bool cap = false;
};

struct BodyTopology {
    QuadMesh mesh;                     ///< Positions are zero.
    std::vector<LatticePlace> places;  ///< Per vertex; right-hand ones carry the chart of their side.
    CageTemplate cageTemplate;
    std::vector<std::uint32_t> meshVertexOf;  ///< Template vertex → mesh vertex.
};

/// The same every time.
BodyTopology makeTopology();

}  // namespace cheval::fitting::bake

// A dog: on the bones of rig.h, whose arms are its forelegs.
#pragma once

#include <cstdint>

#include "hal/sim/gait.h"
#include "hal/sim/loft.h"
#include "hal/sim/rig.h"

namespace cheval::hal::sim {

/// Proportions and coat, lengths in metres.
struct Dog {
    float shoulderHeight = 0.58F;
    float length = 0.68F;  ///< Chest to rump.
    Eigen::Vector3f coat = {0.55F, 0.42F, 0.28F};
};
Dog makeDog(std::uint32_t key);
/// Standing at the origin, facing +Z.
Rig makeDogRig(const Dog& dog);
void buildDog(const Dog& dog, const Rig& rig, Mesh& mesh);
/// Walking along `walk` at `time`, legs crossing in pairs.
Pose solveDog(const Dog& dog, const Rig& rig, const Walk& walk, double time);

}  // namespace cheval::hal::sim

// Finds the floor where nobody wrote down how the sensor is mounted.
#pragma once

#include <cstdint>

#include "fitting/tracking/cloud.h"
#include "fitting/tracking/placement.h"

namespace cheval::fitting::tracking {

/// Looks for the lowest large level surface, by planes through three random points each (RANSAC; Fischler and Bolles,
/// Communications of the ACM 24(6), 1981): many points on it, hardly any under it. The same cloud and seed give the
/// same floor. Exact to a few centimetres: FloorFitJob does the rest. Invalid without a cloud of its declared size.
struct FloorSearchJob {
    const Cloud* cloud = nullptr;
    float roll = 0.0F;       ///< The sensor's, about as it is mounted; radians.
    std::uint32_t seed = 1;  ///< Another one looks at other planes.

    MountEstimate mount;  ///< Out: as the floor shows it; valid only if found.
    bool found = false;   ///< Out.

    [[nodiscard]] bool isValid() const { return cloud != nullptr && cloud->isValid(); }
    void run();

    /// Where a sensor may be: metres above the floor, and radians from level
    /// and from the roll that is expected.
    static constexpr float kLowest = 0.6F;
    static constexpr float kHighest = 2.6F;
    static constexpr float kMostTilt = 0.61F;
    static constexpr float kMostRoll = 0.18F;
};

}  // namespace cheval::fitting::tracking

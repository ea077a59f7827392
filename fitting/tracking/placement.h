// Where the sensor is: from what the technician wrote down, refined by the floor that it sees.
#pragma once

#include <cstdint>

#include "fitting/skeleton.h"
#include "fitting/tracking/cloud.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Height, tilt and roll as hal::Mount has them, in metres and radians.
struct MountEstimate {
    float height = 1.25F;
    float tilt = 0.0F;  ///< Positive looks up.
    float roll = 0.0F;  ///< Positive turns the picture's content anticlockwise.
};

/// What was written down; where nothing was, a level sensor at the usual height, rolled as it is mounted.
MountEstimate mountEstimateFrom(const hal::Mount& mount);
/// The shorter way from one angle to another, radians.
float between(float from, float to);
/// The way from the sensor frame to the mirror frame: p_floor = Rx(tilt)·Rz(roll)·p_sensor + (0, height, 0), then x
/// changes sign, since the mirror frame is right-handed.
SensorPlacement placementFrom(const MountEstimate& mount);

/// The mount of a sensor placed at `placement` when the floor is the plane through `point` with this upward unit
/// normal, both in the mirror frame that this placement makes.
MountEstimate mountOver(const SensorPlacement& placement, const Eigen::Vector3f& normal, const Eigen::Vector3f& point);
/// The other way: where a floor that would give this mount lies in the mirror frame that `placement` makes, as
/// FloorFitJob::start has it.
Eigen::Vector3f floorUnder(const SensorPlacement& placement, const MountEstimate& mount);

/// Fits the floor's plane to the points near where it is expected (least squares, three rounds, each with a narrower
/// band) and turns it into a corrected mount. Invalid without a cloud of its declared size.
struct FloorFitJob {
    const Cloud* cloud = nullptr;  ///< Made with the placement that is expected.
    float band = 0.12F;            ///< Metres above and below the expected floor that are looked at first.
    /// Where that floor is in the cloud: y = start[0] + start[1]·x + start[2]·z.
    Eigen::Vector3f start = Eigen::Vector3f::Zero();

    MountEstimate corrected;    ///< Out: valid only if found.
    bool found = false;         ///< Out.
    std::uint32_t support = 0;  ///< Out: points on the plane,
    std::uint32_t under = 0;    ///< … and far under it.

    [[nodiscard]] bool isValid() const { return cloud != nullptr && cloud->isValid() && band > 0.0F; }
    void run();
};

/// Keeps the mount estimate over time: corrections are averaged, and bounded about what was written down. Where nothing
/// was written down the floor is searched for; until one is seen, floorKnown() stays false: heights are then only
/// relative. Thread-bound.
class PlacementFilter {
  public:
    explicit PlacementFilter(const hal::Mount& mount);
    /// Looks at every frame at first, then now and then. The result counts from the next frame on, unless this returns
    /// true: a floor was found where none was known, or given up, and the cloud's places are wrong.
    bool update(const Cloud& cloud);
    void reset();

    [[nodiscard]] const SensorPlacement& placement() const { return placement_; }
    [[nodiscard]] const MountEstimate& mount() const { return mount_; }
    [[nodiscard]] bool floorKnown() const { return writtenDown_ || floorSeen_; }

  private:
    MountEstimate written_;
    MountEstimate initial_;  ///< As written, or as first found: corrections are bounded about it.
    MountEstimate mount_;
    SensorPlacement placement_;
    bool writtenDown_ = false;
    bool floorSeen_ = false;
    std::uint32_t frames_ = 0;
    std::uint32_t fits_ = 0;
    std::uint32_t doubts_ = 0;  ///< Fits in a row that showed no floor there.
};

}  // namespace cheval::fitting::tracking

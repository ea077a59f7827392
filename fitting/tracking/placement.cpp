#include "fitting/tracking/placement.h"

#include <algorithm>
#include <cmath>

namespace cheval::fitting::tracking {
namespace {

constexpr float kRadiansPerDegree = 3.14159265F / 180.0F;
constexpr float kMostTiltCorrection = 3.0F * kRadiansPerDegree;
constexpr float kMostHeightCorrection = 0.10F;
/// Without a written mount the floor may be anywhere within these.
constexpr float kMostTiltUnknown = 15.0F * kRadiansPerDegree;
constexpr float kMostHeightUnknown = 0.60F;
constexpr std::uint32_t kLeastSupport = 400;
constexpr std::uint32_t kFramesAtFirst = 15;
constexpr std::uint32_t kFramesBetweenFits = 30;

}  // namespace

MountEstimate mountEstimateFrom(const hal::Mount& mount) {
    MountEstimate estimate;
    if (mount.known) {
        estimate.height = mount.heightMm * 1e-3F;
        estimate.tilt = mount.tiltDeg * kRadiansPerDegree;
        estimate.roll = mount.rollDeg * kRadiansPerDegree;
    }
    return estimate;
}

SensorPlacement placementFrom(const MountEstimate& mount) {
    const float ct = std::cos(mount.tilt);
    const float st = std::sin(mount.tilt);
    const float cr = std::cos(mount.roll);
    const float sr = std::sin(mount.roll);
    Eigen::Matrix3f tilt;
    tilt << 1, 0, 0, 0, ct, st, 0, -st, ct;
    Eigen::Matrix3f roll;
    roll << cr, -sr, 0, sr, cr, 0, 0, 0, 1;
    SensorPlacement placement;
    placement.rotation = Eigen::Vector3f(-1.0F, 1.0F, 1.0F).asDiagonal() * tilt * roll;
    placement.translation = Eigen::Vector3f(0.0F, mount.height, 0.0F);
    return placement;
}

void FloorFitJob::run() {
    found = false;
    // The plane y = a + b·x + c·z in the mirror frame that the present mount makes.
    Eigen::Vector3d plane = Eigen::Vector3d::Zero();
    float reach = band;
    for (int round = 0; round < 3; ++round, reach *= 0.5F) {
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        support = 0;
        // The floor lies in the lower part of the picture and fills it densely: every other cell is plenty.
        for (int row = kCloudHeight / 3; row < kCloudHeight; row += 2) {
            for (int column = 0; column < kCloudWidth; column += 2) {
                const std::size_t i = cellIndex(column, row);
                const float z = cloud->z[i];
                if (cloud->depth[i] <= 0.0F || z > 4.5F) continue;
                const double off = cloud->y[i] - (plane[0] + plane[1] * cloud->x[i] + plane[2] * z);
                if (std::abs(off) > reach) continue;
                const Eigen::Vector3d basis(1.0, cloud->x[i], z);
                normal += basis * basis.transpose();
                right += basis * cloud->y[i];
                ++support;
            }
        }
        if (support < kLeastSupport) return;
        // A floor seen as a thin strip fixes neither slope; the small weights hold them at 0 then.
        normal(1, 1) += 20.0;
        normal(2, 2) += 20.0;
        plane = normal.ldlt().solve(right);
        if (!plane.allFinite()) return;
    }
    corrected.height = mount.height - static_cast<float>(plane[0]);
    corrected.tilt = mount.tilt - static_cast<float>(std::atan(plane[2]));
    corrected.roll = mount.roll + static_cast<float>(std::atan(plane[1]));
    found = true;
}

PlacementFilter::PlacementFilter(const hal::Mount& mount)
    : initial_(mountEstimateFrom(mount)),
      mount_(initial_),
      placement_(placementFrom(initial_)),
      writtenDown_(mount.known) {}

void PlacementFilter::reset() {
    mount_ = initial_;
    placement_ = placementFrom(mount_);
    floorSeen_ = false;
    frames_ = 0;
    fits_ = 0;
}

void PlacementFilter::update(const Cloud& cloud) {
    const bool due = frames_ < kFramesAtFirst || frames_ % kFramesBetweenFits == 0;
    ++frames_;
    if (!due) return;
    FloorFitJob fit{.cloud = &cloud, .mount = mount_, .band = writtenDown_ || floorSeen_ ? 0.12F : 0.25F};
    if (!fit.isValid()) return;
    fit.run();
    if (!fit.found) return;
    const float tiltBound = writtenDown_ ? kMostTiltCorrection : kMostTiltUnknown;
    const float heightBound = writtenDown_ ? kMostHeightCorrection : kMostHeightUnknown;
    if (std::abs(fit.corrected.tilt - initial_.tilt) > tiltBound ||
        std::abs(fit.corrected.roll - initial_.roll) > tiltBound ||
        std::abs(fit.corrected.height - initial_.height) > heightBound) {
        return;
    }
    ++fits_;
    floorSeen_ = true;
    const float weight = std::max(0.05F, 1.0F / static_cast<float>(fits_));
    mount_.height += weight * (fit.corrected.height - mount_.height);
    mount_.tilt += weight * (fit.corrected.tilt - mount_.tilt);
    mount_.roll += weight * (fit.corrected.roll - mount_.roll);
    placement_ = placementFrom(mount_);
}

}  // namespace cheval::fitting::tracking

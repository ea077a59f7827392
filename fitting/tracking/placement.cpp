#include "fitting/tracking/placement.h"

#include <algorithm>
#include <cmath>

#include "fitting/tracking/floor_search.h"

namespace cheval::fitting::tracking {
namespace {

constexpr float kRadiansPerDegree = 3.14159265F / 180.0F;
constexpr float kMostTiltCorrection = 3.0F * kRadiansPerDegree;
constexpr float kMostHeightCorrection = 0.10F;
constexpr std::uint32_t kLeastSupport = 400;
/// What lies this far under a floor that was found shows that it is a table; noise does not reach there.
constexpr float kUnderFloor = 0.20F;
/// After so many fits that show no floor, or a table, a floor that was found is searched for anew.
constexpr std::uint32_t kMostDoubts = 5;
constexpr std::uint32_t kFramesAtFirst = 15;
constexpr std::uint32_t kFramesBetweenFits = 30;

}  // namespace

float between(float from, float to) {
    return std::remainder(to - from, 360.0F * kRadiansPerDegree);
}

MountEstimate mountEstimateFrom(const hal::Mount& mount) {
    MountEstimate estimate;
    // A sensor on its side is so whatever else is known.
    estimate.roll = mount.rollDeg * kRadiansPerDegree;
    if (mount.known) {
        estimate.height = mount.heightMm * 1e-3F;
        estimate.tilt = mount.tiltDeg * kRadiansPerDegree;
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

MountEstimate mountOver(const SensorPlacement& placement, const Eigen::Vector3f& normal, const Eigen::Vector3f& point) {
    // Up in the sensor frame: the middle row of Rx(tilt)·Rz(roll).
    const Eigen::Vector3f up = placement.rotation.transpose() * normal;
    return {.height = normal.dot(placement.translation - point),
            .tilt = std::asin(std::clamp(up.z(), -1.0F, 1.0F)),
            .roll = std::atan2(up.x(), up.y())};
}

Eigen::Vector3f floorUnder(const SensorPlacement& placement, const MountEstimate& mount) {
    const Eigen::Vector3f normal = placement.rotation * placementFrom(mount).rotation.row(1).transpose();
    const float offset = normal.dot(placement.translation) - mount.height;
    return Eigen::Vector3f(offset, -normal.x(), -normal.z()) / normal.y();
}

void FloorFitJob::run() {
    found = false;
    // The plane y = a + b·x + c·z in the mirror frame that the present mount makes.
    Eigen::Vector3d plane = start.cast<double>();
    float reach = band;
    for (int round = 0; round < 3; ++round, reach *= 0.5F) {
        Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        support = under = 0;
        // The floor fills its part of the picture densely: every other cell is plenty.
        for (int row = 0; row < kCloudHeight; row += 2) {
            for (int column = 0; column < kCloudWidth; column += 2) {
                const std::size_t i = cellIndex(column, row);
                const float z = cloud->z[i];
                if (cloud->depth[i] <= 0.0F || z > 4.5F) continue;
                const double off = cloud->y[i] - (plane[0] + plane[1] * cloud->x[i] + plane[2] * z);
                if (off < -kUnderFloor) ++under;
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
    const Eigen::Vector3f slopes = plane.cast<float>();
    corrected = mountOver(cloud->placement, Eigen::Vector3f(-slopes[1], 1.0F, -slopes[2]).normalized(),
                          Eigen::Vector3f(0.0F, slopes[0], 0.0F));
    found = true;
}

PlacementFilter::PlacementFilter(const hal::Mount& mount)
    : written_(mountEstimateFrom(mount)),
      initial_(written_),
      mount_(written_),
      placement_(placementFrom(written_)),
      writtenDown_(mount.known) {}

void PlacementFilter::reset() {
    initial_ = mount_ = written_;
    placement_ = placementFrom(mount_);
    frames_ = 0;
    fits_ = 0;
    floorSeen_ = false;
    doubts_ = 0;
}

bool PlacementFilter::update(const Cloud& cloud) {
    const bool due = frames_ < kFramesAtFirst || frames_ % kFramesBetweenFits == 0;
    ++frames_;
    if (!due) return false;
    if (!floorKnown()) {
        FloorSearchJob search{.cloud = &cloud, .roll = written_.roll, .seed = frames_};
        if (!search.isValid()) return false;
        search.run();
        if (!search.found) return false;
        // What it finds is looked at more closely from the next frame on.
        floorSeen_ = true;
        initial_ = mount_ = search.mount;
        placement_ = placementFrom(mount_);
        return true;
    }
    FloorFitJob fit{.cloud = &cloud};
    if (!fit.isValid()) return false;
    fit.run();
    const bool doubtful = !fit.found || 4 * fit.under > fit.support;
    doubts_ = doubtful ? doubts_ + 1 : 0;
    if (doubts_ >= kMostDoubts && !writtenDown_) {
        reset();
        return true;
    }
    if (!fit.found) return false;
    if (std::abs(fit.corrected.tilt - initial_.tilt) > kMostTiltCorrection ||
        std::abs(between(initial_.roll, fit.corrected.roll)) > kMostTiltCorrection ||
        std::abs(fit.corrected.height - initial_.height) > kMostHeightCorrection) {
        return false;
    }
    ++fits_;
    const float weight = std::max(0.05F, 1.0F / static_cast<float>(fits_));
    mount_.height += weight * (fit.corrected.height - mount_.height);
    mount_.tilt += weight * (fit.corrected.tilt - mount_.tilt);
    mount_.roll += weight * between(mount_.roll, fit.corrected.roll);
    placement_ = placementFrom(mount_);
    return false;
}

}  // namespace cheval::fitting::tracking

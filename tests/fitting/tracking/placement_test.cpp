#include "fitting/tracking/placement.h"

#include <cmath>

#include <gtest/gtest.h>

namespace cheval::fitting::tracking {
namespace {

constexpr float kRadiansPerDegree = 3.14159265F / 180.0F;

/// A floor, as a sensor of this mount sees it.
std::vector<std::uint16_t> floorSeenBy(const MountEstimate& mount, const hal::Intrinsics& intrinsics) {
    const SensorPlacement placement = placementFrom(mount);
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(kFrameWidth) * kFrameHeight);
    for (int v = 0; v < kFrameHeight; ++v) {
        for (int u = 0; u < kFrameWidth; ++u) {
            const Eigen::Vector3f ray =
                placement.rotation * unproject(intrinsics, static_cast<float>(u), static_cast<float>(v), 1.0F);
            const float z = ray.y() < -0.05F ? -mount.height / ray.y() : 0.0F;
            depth[static_cast<std::size_t>(v) * kFrameWidth + static_cast<std::size_t>(u)] =
                static_cast<std::uint16_t>(z < 5.0F ? std::lround(z * 1e3F) : 0);
        }
    }
    return depth;
}

Cloud cloudOf(const std::vector<std::uint16_t>& depth, const MountEstimate& mount, const hal::Intrinsics& intrinsics) {
    Cloud cloud;
    const CloudJob job{.depth = {depth.data(), kFrameWidth, kFrameHeight, kFrameWidth},
                       .intrinsics = intrinsics,
                       .placement = placementFrom(mount),
                       .cloud = &cloud};
    EXPECT_TRUE(job.isValid());
    job.run();
    return cloud;
}

TEST(Placement, TurnsSensorAxesIntoMirrorAxes) {
    const SensorPlacement placement = placementFrom(MountEstimate{.height = 1.25F});
    EXPECT_LT((placement.toMirror({100.0F, 0.0F, 2000.0F}) - Eigen::Vector3f(-0.1F, 1.25F, 2.0F)).norm(), 1e-5F);
    EXPECT_NEAR(placement.rotation.determinant(), -1.0F, 1e-5F);
}

TEST(Placement, AgreesWithTheConventionOfRecordedMounts) {
    // Height 1250 mm, tilt −4°, roll 0.3°: rotation and a point worked out by hand from the recording's description.
    const SensorPlacement placement = placementFrom(mountEstimateFrom({1250.0F, -4.0F, 0.3F, true}));
    Eigen::Matrix3f expected;
    expected << -0.999986F, 0.005236F, 0.0F, 0.005223F, 0.99755F, -0.069756F, 0.000365F, 0.069756F, 0.997564F;
    EXPECT_LT((placement.rotation - expected).cwiseAbs().maxCoeff(), 2e-5F);
}

TEST(Placement, ComesBackFromTheMirrorFrame) {
    const SensorPlacement placement = placementFrom({.height = 1.4F, .tilt = -0.12F, .roll = 0.05F});
    const Eigen::Vector3f point(123.0F, -456.0F, 2345.0F);
    EXPECT_LT((placement.toSensor(placement.toMirror(point)) - point).norm(), 0.01F);
}

TEST(FloorFit, RefusesToRunWithoutACloud) {
    EXPECT_FALSE(FloorFitJob{}.isValid());
}

TEST(FloorFit, FindsTheMountThatTheFloorShows) {
    const hal::Intrinsics intrinsics;
    for (const float tiltError : {-1.5F, 0.0F, 1.0F}) {
        for (const float rollError : {-0.8F, 0.0F, 0.7F}) {
            const MountEstimate written{.height = 1.25F, .tilt = -6.0F * kRadiansPerDegree};
            MountEstimate actual = written;
            actual.height += 0.03F;
            actual.tilt += tiltError * kRadiansPerDegree;
            actual.roll += rollError * kRadiansPerDegree;
            const std::vector<std::uint16_t> depth = floorSeenBy(actual, intrinsics);
            PlacementFilter filter({1250.0F, -6.0F, 0.0F, true});
            for (int i = 0; i < 15; ++i) {
                filter.update(cloudOf(depth, filter.mount(), intrinsics));
            }
            EXPECT_NEAR(filter.mount().tilt / kRadiansPerDegree, actual.tilt / kRadiansPerDegree, 0.15F);
            EXPECT_NEAR(filter.mount().roll / kRadiansPerDegree, actual.roll / kRadiansPerDegree, 0.15F);
            EXPECT_NEAR(filter.mount().height, actual.height, 0.01F);
        }
    }
}

TEST(FloorFit, KeepsWhatWasWrittenDownWhenNoFloorIsSeen) {
    const std::vector<std::uint16_t> nothing(static_cast<std::size_t>(kFrameWidth) * kFrameHeight);
    PlacementFilter filter({1300.0F, -5.0F, 0.2F, true});
    filter.update(cloudOf(nothing, filter.mount(), hal::Intrinsics{}));
    EXPECT_FLOAT_EQ(filter.mount().height, 1.3F);
    EXPECT_TRUE(filter.floorKnown());
}

TEST(FloorFit, KnowsThatItKnowsNothing) {
    const std::vector<std::uint16_t> nothing(static_cast<std::size_t>(kFrameWidth) * kFrameHeight);
    PlacementFilter filter(hal::Mount{});
    filter.update(cloudOf(nothing, filter.mount(), hal::Intrinsics{}));
    EXPECT_FALSE(filter.floorKnown());
}

}  // namespace
}  // namespace cheval::fitting::tracking

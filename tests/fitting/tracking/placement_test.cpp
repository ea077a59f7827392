#include "fitting/tracking/placement.h"

#include <cmath>

#include <gtest/gtest.h>

#include "fitting/tracking/floor_search.h"

namespace cheval::fitting::tracking {
namespace {

constexpr float kRadiansPerDegree = 3.14159265F / 180.0F;

/// A floor, as a sensor of this mount sees it, and a level table before it.
std::vector<std::uint16_t> floorSeenBy(const MountEstimate& mount, const hal::Intrinsics& intrinsics,
                                       const Eigen::AlignedBox3f& table = {}) {
    const SensorPlacement placement = placementFrom(mount);
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(kFrameWidth) * kFrameHeight);
    for (int v = 0; v < kFrameHeight; ++v) {
        for (int u = 0; u < kFrameWidth; ++u) {
            const Eigen::Vector3f ray =
                placement.rotation * unproject(intrinsics, static_cast<float>(u), static_cast<float>(v), 1.0F);
            float z = ray.y() < -0.05F ? -mount.height / ray.y() : 0.0F;
            const float toTable = ray.y() < -0.05F ? (table.max().y() - mount.height) / ray.y() : 0.0F;
            const Eigen::Vector3f onTable = placement.translation + toTable * ray;
            if (!table.isEmpty() && toTable > 0.0F && table.contains(onTable)) z = toTable;
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

TEST(FloorSearch, RefusesToRunWithoutACloud) {
    EXPECT_FALSE(FloorSearchJob{}.isValid());
}

TEST(FloorSearch, FindsAMountThatNobodyWroteDown) {
    const hal::Intrinsics intrinsics;
    for (const float height : {0.8F, 1.25F, 1.6F, 2.2F}) {
        for (const float tilt : {-28.0F, -12.0F, -4.0F}) {
            if (height > 2.0F && tilt > -10.0F) continue;  // Sees no floor within five metres.
            for (const float roll : {-6.0F, 0.0F, 2.0F}) {
                const MountEstimate actual{height, tilt * kRadiansPerDegree, roll * kRadiansPerDegree};
                PlacementFilter filter(hal::Mount{});
                const std::vector<std::uint16_t> depth = floorSeenBy(actual, intrinsics);
                for (int i = 0; i < 15; ++i) {
                    filter.update(cloudOf(depth, filter.mount(), intrinsics));
                }
                ASSERT_TRUE(filter.floorKnown()) << height << " m, " << tilt << "°, " << roll << "°";
                EXPECT_NEAR(filter.mount().height, height, 0.01F) << tilt << "°, " << roll << "°";
                EXPECT_NEAR(filter.mount().tilt / kRadiansPerDegree, tilt, 0.2F) << height << " m";
                EXPECT_NEAR(filter.mount().roll / kRadiansPerDegree, roll, 0.2F) << height << " m";
            }
        }
    }
}

TEST(FloorSearch, DoesNotTakeATableForTheFloor) {
    const hal::Intrinsics intrinsics;
    const MountEstimate actual{.height = 1.5F, .tilt = -10.0F * kRadiansPerDegree};
    const Eigen::AlignedBox3f table(Eigen::Vector3f(-0.9F, 0.74F, 1.8F), Eigen::Vector3f(0.5F, 0.76F, 2.8F));
    const Cloud cloud = cloudOf(floorSeenBy(actual, intrinsics, table), MountEstimate{}, intrinsics);
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        FloorSearchJob search{.cloud = &cloud, .seed = seed};
        search.run();
        ASSERT_TRUE(search.found) << seed;
        EXPECT_NEAR(search.mount.height, 1.5F, 0.05F) << seed;
    }
}

TEST(FloorSearch, FindsNoFloorInAWall) {
    const std::vector<std::uint16_t> wall(static_cast<std::size_t>(kFrameWidth) * kFrameHeight, 1800);
    PlacementFilter filter(hal::Mount{});
    for (int i = 0; i < 15; ++i) {
        EXPECT_FALSE(filter.update(cloudOf(wall, filter.mount(), hal::Intrinsics{})));
    }
    EXPECT_FALSE(filter.floorKnown());
}

TEST(FloorSearch, LeavesATableThatItTookForTheFloor) {
    // While somebody stood before the floor, only the table could be seen.
    const hal::Intrinsics intrinsics;
    const MountEstimate actual{.height = 1.5F, .tilt = -10.0F * kRadiansPerDegree};
    const MountEstimate overTable{.height = 0.75F, .tilt = actual.tilt};
    PlacementFilter filter(hal::Mount{});
    const std::vector<std::uint16_t> table = floorSeenBy(overTable, intrinsics);
    for (int i = 0; i < 15; ++i) {
        filter.update(cloudOf(table, filter.mount(), intrinsics));
    }
    ASSERT_NEAR(filter.mount().height, 0.75F, 0.05F);
    const Eigen::AlignedBox3f seenBeside(Eigen::Vector3f(-0.5F, 0.74F, 1.2F), Eigen::Vector3f(0.5F, 0.76F, 1.8F));
    const std::vector<std::uint16_t> floor = floorSeenBy(actual, intrinsics, seenBeside);
    for (int i = 0; i < 300; ++i) {
        filter.update(cloudOf(floor, filter.mount(), intrinsics));
    }
    EXPECT_NEAR(filter.mount().height, 1.5F, 0.02F);
}

}  // namespace
}  // namespace cheval::fitting::tracking

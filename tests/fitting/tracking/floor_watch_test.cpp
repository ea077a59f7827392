#include "fitting/tracking/floor_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::fitting::tracking {
namespace {

constexpr float kRadiansPerDegree = 3.14159265F / 180.0F;
using Verdict = FloorWatch::Verdict;

/// A shop as a sensor of this mount and lens really sees it: a floor, and walls at 4 m and to either side.
std::vector<std::uint16_t> shopSeenBy(const MountEstimate& mount, const hal::Intrinsics& lens, bool floor = true) {
    const SensorPlacement placement = placementFrom(mount);
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(kFrameWidth) * kFrameHeight);
    for (int v = 0; v < kFrameHeight; ++v) {
        for (int u = 0; u < kFrameWidth; ++u) {
            const Eigen::Vector3f ray =
                placement.rotation * unproject(lens, static_cast<float>(u), static_cast<float>(v), 1.0F);
            float z = 4.0F / ray.z();
            if (std::abs(ray.x()) > 1e-4F) z = std::min(z, 1.7F / std::abs(ray.x()));
            if (floor && ray.y() < 0.0F) z = std::min(z, -mount.height / ray.y());
            depth[static_cast<std::size_t>(v) * kFrameWidth + static_cast<std::size_t>(u)] =
                static_cast<std::uint16_t>(std::lround(z * 1e3F));
        }
    }
    return depth;
}

/// The cloud that a sensor makes of it that is taken to be mounted and to see like this.
Cloud cloudOf(const std::vector<std::uint16_t>& depth, const MountEstimate& written, const hal::Intrinsics& lens = {}) {
    Cloud cloud;
    const CloudJob job{.depth = {depth.data(), kFrameWidth, kFrameHeight, kFrameWidth},
                       .intrinsics = lens,
                       .placement = placementFrom(written),
                       .cloud = &cloud};
    job.run();
    return cloud;
}

constexpr hal::Mount kWritten{.heightMm = 1250.0F, .tiltDeg = -6.0F, .known = true};

hal::TimePoint at(double seconds) {
    return hal::TimePoint(hal::fromSeconds(seconds));
}

struct Case {
    const char* name;
    float higher, tiltedDeg, rolledDeg;  ///< Really, than written.
    float focal;                         ///< What is believed, in shares of what is.
    Verdict verdict;
};

TEST(FloorWatch, JudgesATableOfMountsAndLenses) {
    const MountEstimate written = mountEstimateFrom(kWritten);
    for (const Case& row : {Case{"as written", 0.0F, 0.0F, 0.0F, 1.0F, Verdict::agrees},
                            Case{"as a level shows", 0.02F, 1.0F, 0.5F, 1.0F, Verdict::agrees},
                            Case{"within what is corrected", -0.08F, -2.5F, 0.0F, 1.0F, Verdict::agrees},
                            Case{"a hand's breadth and more", 0.30F, 0.0F, 0.0F, 1.0F, Verdict::differs},
                            Case{"too low", -0.30F, 0.0F, 0.0F, 1.0F, Verdict::differs},
                            Case{"tilted", 0.0F, -10.0F, 0.0F, 1.0F, Verdict::differs},
                            Case{"rolled", 0.0F, 0.0F, 8.0F, 1.0F, Verdict::differs},
                            Case{"too short a lens", 0.0F, 0.0F, 0.0F, 0.6F, Verdict::differs},
                            Case{"too long a lens", 0.0F, 0.0F, 0.0F, 1.6F, Verdict::differs}}) {
        MountEstimate actual = written;
        actual.height += row.higher;
        actual.tilt += row.tiltedDeg * kRadiansPerDegree;
        actual.roll += row.rolledDeg * kRadiansPerDegree;
        hal::Intrinsics believed;
        believed.fx *= row.focal;
        believed.fy *= row.focal;
        const Cloud cloud = cloudOf(shopSeenBy(actual, {}), written, believed);
        int right = 0;
        for (std::uint32_t seed = 1; seed <= 10; ++seed)
            right += FloorWatch(kWritten).judge(cloud, seed) == row.verdict ? 1 : 0;
        EXPECT_EQ(right, 10) << row.name;
    }
}

TEST(FloorWatch, SaysNothingWithoutAFloorOrWithoutAWrittenMount) {
    const MountEstimate written = mountEstimateFrom(kWritten);
    const Cloud walls = cloudOf(shopSeenBy(written, {}, false), written);
    EXPECT_EQ(FloorWatch(kWritten).judge(walls, 1), Verdict::unseen);
    MountEstimate lower = written;
    lower.height -= 0.4F;
    const Cloud elsewhere = cloudOf(shopSeenBy(lower, {}), written);
    EXPECT_EQ(FloorWatch(hal::Mount{}).judge(elsewhere, 1), Verdict::unseen);
    EXPECT_EQ(FloorWatch(kWritten).judge(elsewhere, 1), Verdict::differs);
}

TEST(FloorWatch, BelievesWhatHasLastedAndTakesItBackLikewise) {
    const MountEstimate written = mountEstimateFrom(kWritten);
    MountEstimate lower = written;
    lower.height -= 0.4F;
    const Cloud sound = cloudOf(shopSeenBy(written, {}), written);
    const Cloud wrong = cloudOf(shopSeenBy(lower, {}), written);
    const Cloud hidden = cloudOf(shopSeenBy(written, {}, false), written);
    FloorWatch watch(kWritten);
    int frames = 0;
    const auto show = [&](const Cloud& cloud, double seconds) {
        for (const int end = frames + static_cast<int>(std::lround(10.0 * seconds)); frames < end; ++frames)
            watch.update(cloud, at(0.1 * frames));
    };
    show(sound, 5.0);
    show(wrong, 4.0);
    EXPECT_FALSE(watch.elsewhere());
    show(sound, 1.0);
    show(wrong, 4.0);
    EXPECT_FALSE(watch.elsewhere()) << "what comes and goes is not believed";
    show(hidden, 5.0);
    EXPECT_FALSE(watch.elsewhere());
    show(wrong, 1.0);
    EXPECT_TRUE(watch.elsewhere()) << "who stood before it for a while changes nothing";
    show(hidden, 20.0);
    EXPECT_TRUE(watch.elsewhere());
    show(sound, 4.0);
    EXPECT_TRUE(watch.elsewhere());
    show(sound, 1.0);
    EXPECT_FALSE(watch.elsewhere());
    show(wrong, 5.0);
    EXPECT_TRUE(watch.elsewhere());
    watch.reset();
    EXPECT_FALSE(watch.elsewhere());
}

}  // namespace
}  // namespace cheval::fitting::tracking

#include "hal/openni/profile.h"

#include <vector>

#include <gtest/gtest.h>

#include "hal/openni/device_clock.h"

namespace cheval::hal {
namespace {

struct Case {
    const char* name;
    std::vector<DepthMode> modes;
    int chosen;  ///< −1: none.
    int enlarge = 1;
};
void PrintTo(const Case& row, std::ostream* out) {  // NOLINT(readability-identifier-naming)
    *out << row.name;
}

class ProfileLadder : public testing::TestWithParam<Case> {};

TEST_P(ProfileLadder, TakesTheBestThatThereIs) {
    const auto profile = chooseProfile(GetParam().modes);
    ASSERT_EQ(profile.has_value(), GetParam().chosen >= 0);
    if (!profile) return;
    EXPECT_EQ(static_cast<int>(profile->mode), GetParam().chosen);
    EXPECT_EQ(profile->enlarge, GetParam().enlarge);
}

INSTANTIATE_TEST_SUITE_P(
    Profile, ProfileLadder,
    testing::Values(Case{"theUsualSensor", {{320, 240, 30}, {320, 240, 60}, {640, 480, 30}, {640, 480, 30, true}}, 2},
                    Case{"tenthsWhereThereAreNoWholeMillimetres", {{640, 480, 30, true}}, 0},
                    Case{"nearestAboveThirty", {{640, 480, 60}, {640, 480, 50}}, 1},
                    Case{"slowFullSizeBeforeQuickSmallSize", {{320, 240, 60}, {640, 480, 15}}, 1},
                    Case{"fastestBelowThirty", {{640, 480, 15}, {640, 480, 25}}, 1},
                    Case{"smallIsDoubled", {{320, 240, 30}, {160, 120, 30}}, 0, 2},
                    Case{"tooSlow", {{640, 480, 5}, {320, 240, 10}}, -1},
                    Case{"otherSizes", {{1280, 1024, 30}, {160, 120, 60}}, -1}, Case{"none", {}, -1}),
    [](const testing::TestParamInfo<Case>& test) { return test.param.name; });

constexpr Duration kPeriod = std::chrono::microseconds(33'333);

TEST(DeviceClock, FramesKeepTheDevicesDistanceWhateverTheDelay) {
    DeviceClock clock;
    TimePoint before{};
    for (int i = 0; i < 300; ++i) {
        const Duration stamp = kPeriod * i;
        const TimePoint captured(std::chrono::seconds(100) + stamp);
        const TimePoint arrival = captured + std::chrono::microseconds(300 + (i * 7919) % 9000);
        const TimePoint said = clock.captureTime(stamp, arrival);
        EXPECT_LE(said, arrival);
        EXPECT_GE(said, captured);
        if (i > 0) {
            EXPECT_NEAR(seconds(said - before), seconds(kPeriod), 0.001) << i;
        }
        before = said;
    }
    // The least delay that was seen is taken for none.
    EXPECT_NEAR(seconds(before - TimePoint(std::chrono::seconds(100) + kPeriod * 299)), 0.0003, 0.0015);
}

TEST(DeviceClock, FollowsADeviceThatRunsFast) {
    DeviceClock clock;
    Duration worst{};
    for (int i = 0; i < 30 * 600; ++i) {
        const TimePoint captured(kPeriod * i);
        const auto stamp = fromSeconds(seconds(captured) * 1.00005);
        worst = std::max<Duration>(worst, captured - clock.captureTime(stamp, captured));
    }
    EXPECT_LT(worst, std::chrono::milliseconds(1));
}

TEST(DeviceClock, ADeviceThatStartsAnewIsBelievedAtOnce) {
    DeviceClock clock;
    clock.captureTime(std::chrono::hours(3), TimePoint(std::chrono::seconds(10)));
    EXPECT_EQ(clock.captureTime(Duration::zero(), TimePoint(std::chrono::seconds(11))),
              TimePoint(std::chrono::seconds(11)));
}

}  // namespace
}  // namespace cheval::hal

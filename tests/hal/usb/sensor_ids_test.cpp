#include "hal/usb/sensor_ids.h"

#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

TEST(SensorIds, KnowsEachSensorAndTheDriverThatServesIt) {
    for (const int product : {0x0500, 0x0600, 0x0601, 0x0609}) {
        const SensorId* id = findSensorId(0x1d27, static_cast<std::uint16_t>(product));
        ASSERT_NE(id, nullptr) << std::hex << product;
        EXPECT_EQ(id->driver, "PS1080");
        EXPECT_TRUE(id->packaged);
    }
    for (const int product : {0x1250, 0x1260, 0x1270, 0x1280, 0x1290, 0xf9db}) {
        const SensorId* id = findSensorId(0x1d27, static_cast<std::uint16_t>(product));
        ASSERT_NE(id, nullptr) << std::hex << product;
        EXPECT_EQ(id->driver, "PSLink");
        EXPECT_TRUE(id->packaged);
    }
    for (const int product : {0x02ae, 0x02bf}) {
        const SensorId* id = findSensorId(0x045e, static_cast<std::uint16_t>(product));
        ASSERT_NE(id, nullptr) << std::hex << product;
        EXPECT_FALSE(id->packaged);
    }
    for (const int product : {0x0400, 0x0401, 0x04ff, 0x0600, 0x06ff}) {
        const SensorId* id = findSensorId(0x2bc5, static_cast<std::uint16_t>(product));
        ASSERT_NE(id, nullptr) << std::hex << product;
        EXPECT_FALSE(id->packaged);
    }
}

TEST(SensorIds, TakesNothingElseForASensor) {
    EXPECT_EQ(findSensorId(0x1d27, 0x0602), nullptr);
    EXPECT_EQ(findSensorId(0x1d6b, 0x0609), nullptr);
    EXPECT_EQ(findSensorId(0x045e, 0x02b0), nullptr);  // The motor of a Kinect.
    EXPECT_EQ(findSensorId(0x2bc5, 0x0500), nullptr);
    EXPECT_EQ(findSensorId(0x2bc5, 0x0700), nullptr);
}

}  // namespace
}  // namespace cheval::hal

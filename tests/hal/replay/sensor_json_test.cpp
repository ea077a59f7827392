#include "hal/replay/sensor_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

using testing::HasSubstr;

constexpr const char* kWhole = R"({
 "width": 640, "height": 480, "fx": 570.3, "fy": 571.5, "cx": 319.5, "cy": 239.5,
 "depth_unit_mm": 0.125, "fps": 15, "independent": true,
 "mount": {"height_mm": 1150, "tilt_deg": -2, "roll_deg": 0.3}
})";

TEST(SensorJsonTest, ReadsEveryKey) {
    const auto sensor = parseSensorJson(kWhole, "sensor.json");
    ASSERT_TRUE(sensor) << sensor.error().message();
    EXPECT_EQ(sensor->intrinsics.width, 640);
    EXPECT_EQ(sensor->intrinsics.height, 480);
    EXPECT_EQ(sensor->intrinsics.fx, 570.3F);
    EXPECT_EQ(sensor->intrinsics.fy, 571.5F);
    EXPECT_EQ(sensor->intrinsics.cx, 319.5F);
    EXPECT_EQ(sensor->intrinsics.cy, 239.5F);
    EXPECT_EQ(sensor->depthUnitMm, 0.125);
    EXPECT_EQ(sensor->framesPerSecond, 15.0);
    EXPECT_TRUE(sensor->independent);
    EXPECT_TRUE(sensor->mount.known);
    EXPECT_EQ(sensor->mount.heightMm, 1150.0F);
    EXPECT_EQ(sensor->mount.tiltDeg, -2.0F);
    EXPECT_EQ(sensor->mount.rollDeg, 0.3F);
}

TEST(SensorJsonTest, WithoutAMountNothingIsKnownOfIt) {
    const auto sensor =
        parseSensorJson(R"({"width": 32, "height": 24, "fx": 28, "fy": 28, "cx": 16, "cy": 12})", "sensor.json");
    ASSERT_TRUE(sensor) << sensor.error().message();
    EXPECT_FALSE(sensor->mount.known);
    EXPECT_FALSE(sensor->independent);
    EXPECT_EQ(sensor->depthUnitMm, 1.0);
    EXPECT_EQ(sensor->framesPerSecond, 30.0);
}

TEST(SensorJsonTest, WhatIsWrittenReadsBack) {
    auto sensor = parseSensorJson(kWhole, "sensor.json");
    ASSERT_TRUE(sensor);
    const std::string text = formatSensorJson(*sensor);
    EXPECT_THAT(text, HasSubstr("570.3,"));
    const auto back = parseSensorJson(text, "sensor.json");
    ASSERT_TRUE(back) << back.error().message() << '\n' << text;
    EXPECT_EQ(formatSensorJson(*back), text);
    EXPECT_EQ(back->intrinsics.fy, sensor->intrinsics.fy);
    EXPECT_EQ(back->mount.rollDeg, sensor->mount.rollDeg);
}

struct Refusal {
    const char* name;
    const char* from;  ///< Part of kWhole …
    const char* to;    ///< … replaced by this.
    const char* key;
    const char* cause;
};

class SensorJsonRefusalTest : public testing::TestWithParam<Refusal> {};

TEST_P(SensorJsonRefusalTest, SaysWhichKeyAndWhy) {
    std::string text = kWhole;
    const auto at = text.find(GetParam().from);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, std::string(GetParam().from).size(), GetParam().to);
    const auto sensor = parseSensorJson(text, "folder/sensor.json");
    ASSERT_FALSE(sensor);
    const Error& error = sensor.error();
    EXPECT_EQ(error.code, ErrorCode::invalidInput);
    EXPECT_EQ(error.file, "folder/sensor.json");
    EXPECT_EQ(error.key, GetParam().key);
    EXPECT_THAT(error.cause, HasSubstr(GetParam().cause));
    EXPECT_FALSE(error.mend.empty());
}

INSTANTIATE_TEST_SUITE_P(Table, SensorJsonRefusalTest,
                         testing::Values(Refusal{"missing", "\"fx\": 570.3, ", "", "fx", "missing"},
                                         Refusal{"unknown", "\"fps\"", "\"fsp\"", "fsp", "unknown"},
                                         Refusal{"unknownMount", "\"tilt_deg\"", "\"tilt\"", "mount.tilt", "unknown"},
                                         Refusal{"text", "640", "\"640\"", "width", "not a number"},
                                         Refusal{"zero", "570.3", "0", "fx", "it is 0"},
                                         Refusal{"inMillimetres", "570.3", "4.73", "fx", "178 degrees across"},
                                         Refusal{"ofTwiceTheResolution", "571.5", "1143", "fy", "24 degrees up"},
                                         Refusal{"centreOutside", "319.5", "640", "cx", "outside the picture"},
                                         Refusal{"centreAbove", "239.5", "-1", "cy", "outside the picture"},
                                         Refusal{"fraction", "640", "640.5", "width", "it is 640.5"},
                                         Refusal{"huge", "480", "1000000", "height", "it is 1000000"},
                                         Refusal{"beyondDouble", "15", "1e999", "", "not valid JSON"},
                                         Refusal{"negativeRate", "15", "-15", "fps", "it is -15"},
                                         Refusal{"noFlag", "true", "1", "independent", "neither true nor false"},
                                         Refusal{"mountText",
                                                 "{\"height_mm\": 1150, \"tilt_deg\": -2, \"roll_deg\": 0.3}", "3",
                                                 "mount", "not an object"},
                                         Refusal{"nullUnit", "0.125", "null", "depth_unit_mm", "not a number"}),
                         [](const auto& test) { return test.param.name; });

TEST(SensorJsonTest, ASyntaxErrorNamesItsLine) {
    const auto sensor = parseSensorJson("{\n \"width\": 640,\n \"height\" 480\n}", "sensor.json");
    ASSERT_FALSE(sensor);
    EXPECT_EQ(sensor.error().line, 3);
    EXPECT_FALSE(sensor.error().mend.empty());
}

TEST(SensorJsonTest, WhatIsNoObjectIsRefused) {
    for (const char* text : {"", "[]", "3", "null", "\"width\"", "\xFF\xFE"}) {
        EXPECT_FALSE(parseSensorJson(text, "sensor.json")) << text;
    }
}

TEST(SensorJsonTest, DeepNestingAndHugeFilesAreRefused) {
    EXPECT_FALSE(parseSensorJson(std::string(60000, '['), "sensor.json"));
    EXPECT_FALSE(parseSensorJson(std::string(1U << 20U, ' ') + "{}", "sensor.json"));
}

}  // namespace
}  // namespace cheval::hal

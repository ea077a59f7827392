#include "daemon/hands_run.h"

#include <fstream>

#include <gtest/gtest.h>

#include "hal/png/png.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

TEST(HandsRun, AFolderThatIsNoRecordingIsRefusedByName) {
    const test::TemporaryFolder folder;
    const Expected<HandsReport> report = readHands(folder.path().string());
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message().find("sensor.json"), std::string::npos) << report.error().message();
}

TEST(HandsRun, EveryPictureIsReadOnceInItsOrder) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.path() / "sensor.json")
        << R"({"width": 640, "height": 480, "fx": 570, "fy": 570, "cx": 319.5, "cy": 239.5, "depth_unit_mm": 1,)"
        << R"( "fps": 1, "independent": true})";
    hal::Image<std::uint16_t> picture;
    picture.resize(640, 480);
    for (const char* name : {"b.png", "a.png", "c.png"}) {
        ASSERT_TRUE(hal::writePng((folder.path() / name).string(), std::as_const(picture).view()).hasValue());
    }
    const Expected<HandsReport> report = readHands(folder.path().string());
    ASSERT_TRUE(report) << report.error().message();
    ASSERT_EQ(report->readings.size(), 3U);
    EXPECT_EQ(report->readings[0].name, "a.png");
    EXPECT_EQ(report->readings[2].name, "c.png");
    for (const HandReading& reading : report->readings) {
        EXPECT_EQ(reading.state, fitting::HandState::unknown);
    }
}

}  // namespace
}  // namespace cheval::daemon

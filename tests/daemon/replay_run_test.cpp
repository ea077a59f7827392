#include "daemon/replay_run.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/settings_table.h"
#include "hal/image.h"
#include "hal/png/png.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSensor = R"({"width": 640, "height": 480, "fx": 570.3, "fy": 570.3, "cx": 319.5, "cy": 239.5,
 "depth_unit_mm": 1, "fps": 15, "mount": {"height_mm": 1250, "tilt_deg": 0, "roll_deg": 0}})";

/// A recording of an empty room, and settings with small pictures.
class ReplayRunTest : public testing::Test {
  protected:
    ReplayRunTest() : settings_(config::defaultSettings()) {
        settings_.wardrobe.folder = CHEVAL_ASSETS;
        settings_.display.width = 135;
        settings_.display.height = 240;
    }
    void record(int frames, int width = 640, int height = 480) const {
        std::ofstream(folder_ / "sensor.json") << kSensor;
        const hal::Image<std::uint16_t> wall(width, height, 3000);
        for (int i = 0; i < frames; ++i)
            ASSERT_TRUE(hal::writePng((folder_ / ("depth-" + std::to_string(i) + ".png")).string(), wall.view()));
    }
    [[nodiscard]] Expected<ReplayReport> run(ReplayRunOptions options) const {
        options.source = options.source.empty() ? folder_.string() : options.source;
        return replayRecording(settings_, options);
    }
    [[nodiscard]] static std::string read(const fs::path& path) {
        std::stringstream text;
        text << std::ifstream(path).rdbuf();
        return text.str();
    }

    config::Settings settings_;
    test::TemporaryFolder temporary_;
    fs::path folder_ = temporary_.path();
};

TEST_F(ReplayRunTest, runsEveryTaskOnEveryFrameAndWritesOneRecordEach) {
    record(6);
    const Expected<ReplayReport> report =
        run({.tracks = (folder_ / "t.jsonl").string(), .frames = (folder_ / "out").string(), .every = 4});
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->frames, 6U);
    EXPECT_EQ(report->pictures, 2U);
    EXPECT_TRUE(fs::exists(folder_ / "out/frame-000000.png"));
    EXPECT_TRUE(fs::exists(folder_ / "out/frame-000004.png"));
    const std::string tracks = read(folder_ / "t.jsonl");
    EXPECT_EQ(std::count(tracks.begin(), tracks.end(), '\n'), 6 + 2);
    for (const TaskStatistics& row : report->tasks) {
        EXPECT_EQ(row.skips, 0U) << row.name;
        if (row.name == "track" || row.name == "hands" || row.name == "body") {
            EXPECT_EQ(row.runs, 6U) << row.name;
        }
    }
}

TEST_F(ReplayRunTest, drawsTheTrackingViewTwiceAsLargeAndWithoutARenderer) {
    record(6);
    const Expected<ReplayReport> report =
        run({.frames = (folder_ / "out").string(), .view = ReplayView::tracking, .every = 4});
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->pictures, 2U);
    EXPECT_EQ(report->renderer, "");
    hal::Image<hal::Rgba8> picture;
    ASSERT_TRUE(hal::readPng((folder_ / "out/frame-000004.png").string(), picture));
    EXPECT_EQ(picture.width, 1280);
    EXPECT_EQ(picture.height, 960);
    const hal::Rgba8 wall = picture.view().at(300, 300);
    EXPECT_EQ(wall.r, wall.b);
    EXPECT_GT(wall.r, 60);
}

TEST_F(ReplayRunTest, refusesOniFilesWithAClearWord) {
    const Expected<ReplayReport> report = run({.source = "visit.oni"});
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().cause, "there is no such recording");
    EXPECT_FALSE(report.error().mend.empty());
}

TEST_F(ReplayRunTest, refusesAnUnknownGarmentAndNamesTheKnown) {
    record(1);
    const Expected<ReplayReport> report = run({.outfit = "tshirt,trouser"});
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().mend, testing::HasSubstr("did you mean \"trousers\""));
    EXPECT_THAT(report.error().mend, testing::HasSubstr("Known are: tshirt, trousers"));
}

TEST_F(ReplayRunTest, refusesAFolderWithoutSensorJson) {
    const Expected<ReplayReport> report = run({});
    ASSERT_FALSE(report);
    EXPECT_FALSE(report.error().mend.empty());
}

TEST_F(ReplayRunTest, refusesPicturesOfAnotherSize) {
    record(2, 320, 240);
    const Expected<ReplayReport> report = run({});
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().message(), testing::HasSubstr("320"));
}

TEST_F(ReplayRunTest, refusesARecordingThatTrackingCannotRead) {
    record(2, 320, 240);
    std::ofstream(folder_ / "sensor.json") << R"({"width": 320, "height": 240, "fx": 285, "fy": 285, "cx": 159.5,
 "cy": 119.5, "depth_unit_mm": 1, "fps": 15, "mount": {"height_mm": 1250, "tilt_deg": 0, "roll_deg": 0}})";
    const Expected<ReplayReport> report = run({});
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().cause, testing::HasSubstr("320×240"));
    EXPECT_THAT(report.error().mend, testing::HasSubstr("640×480"));
    EXPECT_FALSE(report.error().why.empty());
}

TEST_F(ReplayRunTest, playsARecordingWithALongGapToItsEnd) {
    record(3);
    // Sixty pictures at fifteen a second are missing: four seconds without any.
    fs::rename(folder_ / "depth-2.png", folder_ / "depth-62.png");
    const Expected<ReplayReport> report = run({});
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->frames, 3U);
}

TEST_F(ReplayRunTest, refusesATracksFileThatCannotBeWritten) {
    record(1);
    EXPECT_FALSE(run({.tracks = "/nonexistent/t.jsonl"}));
}

}  // namespace
}  // namespace cheval::daemon

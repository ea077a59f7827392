#include "daemon/tracks_writer.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

namespace fs = std::filesystem;

class TracksWriterTest : public testing::Test {
  protected:
    [[nodiscard]] std::string path() const { return (folder_ / "t.jsonl").string(); }
    [[nodiscard]] std::vector<nlohmann::json> lines() const {
        std::ifstream stream(path());
        std::vector<nlohmann::json> all;
        for (std::string line; std::getline(stream, line);)
            all.push_back(nlohmann::json::parse(line));
        return all;
    }

    test::TemporaryFolder temporary_;
    fs::path folder_ = temporary_.path();
};

fitting::Skeleton person() {
    fitting::Skeleton skeleton;
    skeleton.userId = 3;
    for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
        skeleton.joints[i].position = {-0.1F * static_cast<float>(i), 1.0F, 2.0F};
        skeleton.joints[i].confidence = 0.5F;
    }
    return skeleton;
}

TEST_F(TracksWriterTest, writesSensorMillimetresFrameByFrameAsTheyCome) {
    Expected<std::unique_ptr<TracksWriter>> writer = TracksWriter::create(path());
    ASSERT_TRUE(writer);
    fitting::SensorPlacement placement;
    placement.translation = {0.0F, 1.25F, 0.0F};
    fitting::Hands hands;
    hands[fitting::Side::left].state = fitting::HandState::open;
    hands[fitting::Side::right].state = fitting::HandState::closed;
    ASSERT_TRUE((*writer)->writeFrame({.sourceIndex = 7}, person(), hands, placement));
    // Already there, before anything else is asked for.
    ASSERT_EQ(lines().size(), 1U);
    const nlohmann::json record = lines().front();
    EXPECT_EQ(record["frame"], 7);
    EXPECT_EQ(record["joints"].size(), fitting::kJointCount);
    EXPECT_EQ(record["joints"]["neck"], nlohmann::json({100.0, -250.0, 2000.0, 0.5}));
    EXPECT_EQ(record["hands"], nlohmann::json({{"left", "open"}, {"right", "closed"}}));
}

TEST_F(TracksWriterTest, writesNoJointsWithoutAPersonAndNeverNan) {
    Expected<std::unique_ptr<TracksWriter>> writer = TracksWriter::create(path());
    ASSERT_TRUE(writer);
    ASSERT_TRUE((*writer)->writeFrame({}, {}, {}, {}));
    fitting::Skeleton broken = person();
    broken[fitting::Joint::head].position.x() = std::numeric_limits<float>::quiet_NaN();
    ASSERT_TRUE((*writer)->writeFrame({}, broken, {}, {}));
    const auto records = lines();
    EXPECT_TRUE(records[0]["joints"].empty());
    EXPECT_EQ(records[0]["hands"]["left"], "unknown");
    EXPECT_EQ(records[1]["joints"].size(), fitting::kJointCount - 1);
}

TEST_F(TracksWriterTest, writesMeasurementsInCentimetresAndEventsOnce) {
    Expected<std::unique_ptr<TracksWriter>> writer = TracksWriter::create(path());
    ASSERT_TRUE(writer);
    fitting::Hands hands;
    hands.gestures[0] = {.kind = fitting::GestureKind::swipe,
                         .hand = fitting::Side::right,
                         .direction = fitting::SwipeDirection::left,
                         .startFrame = 70,
                         .endFrame = 78};
    hands.gestures[1] = {
        .kind = fitting::GestureKind::grab, .hand = fitting::Side::left, .startFrame = 80, .endFrame = 90};
    hands.gestures[2] = {
        .kind = fitting::GestureKind::hold, .hand = fitting::Side::left, .startFrame = 90, .endFrame = 126};
    hands.gestureCount = 3;
    (*writer)->addGestures(hands);
    fitting::Measurements measurements;
    measurements[fitting::Dimension::stature] = {.value = 1.712F, .valid = true};
    measurements[fitting::Dimension::chestGirth] = {.value = 0.9F, .valid = false};
    ASSERT_TRUE((*writer)->finish(&measurements));
    const auto records = lines();
    ASSERT_EQ(records.size(), 2U);
    EXPECT_EQ(records[0], nlohmann::json({{"measurements", {{"stature", 171.2}}}}));
    EXPECT_EQ(records[1]["events"].size(), 3U);
    EXPECT_EQ(
        records[1]["events"][0],
        nlohmann::json({{"type", "swipe"}, {"direction", "left"}, {"hand", "right"}, {"start", 70}, {"end", 78}}));
    EXPECT_EQ(records[1]["events"][1]["type"], "grab");
    EXPECT_FALSE(records[1]["events"][1].contains("direction"));
    EXPECT_EQ(records[1]["events"][2],
              nlohmann::json({{"type", "hold"}, {"hand", "left"}, {"start", 90}, {"end", 126}}));
}

TEST_F(TracksWriterTest, refusesAFileThatCannotBeWritten) {
    Expected<std::unique_ptr<TracksWriter>> writer = TracksWriter::create((folder_ / "no/such/t.jsonl").string());
    ASSERT_FALSE(writer);
    EXPECT_FALSE(writer.error().mend.empty());
    EXPECT_FALSE(writer.error().file.empty());
}

}  // namespace
}  // namespace cheval::daemon

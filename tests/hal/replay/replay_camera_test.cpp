#include "hal/replay/replay_camera.h"

#include <filesystem>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hal/replay/recording_folder.h"
#include "tests/support/allocation_counter.h"

namespace cheval::hal {
namespace {

using test::RecordingFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr Duration kLong = std::chrono::seconds(100);

std::string sensorJson(const std::string& more) {
    return R"({"width": 32, "height": 24, "fx": 28.5, "fy": 28.5, "cx": 15.5, "cy": 11.5, )" + more + "}";
}

class ReplayCameraTest : public testing::Test {
  protected:
    // Makes and opens; fails the test when it cannot.
    ReplayCamera* play(const ReplayOptions& options) {
        auto made = makeReplayCamera(options, clock_);
        if (!made) {
            ADD_FAILURE() << made.error().message();
            return nullptr;
        }
        camera_ = std::move(*made);
        const auto opened = camera_->open();
        EXPECT_TRUE(opened);
        return camera_.get();
    }
    ReplayCamera* play() { return play({.folder = folder_.path()}); }

    // The first pixels of all frames to come.
    std::vector<int> firstPixels() {
        std::vector<int> all;
        DepthFrame frame;
        while (camera_->waitFrame(kLong, frame) == FrameStatus::frame)
            all.push_back(frame.depth.at(0, 0));
        return all;
    }

    RecordingFolder folder_;
    VirtualClock clock_;
    std::unique_ptr<ReplayCamera> camera_;
};

TEST_F(ReplayCameraTest, PlaysInNaturalOrderAndEnds) {
    ASSERT_TRUE(folder_.recording(11));
    ASSERT_NE(play(), nullptr);
    EXPECT_THAT(firstPixels(), ElementsAre(1000, 2000, 3000, 4000, 5000, 6000, 7000, 8000, 9000, 10000, 11000));
    DepthFrame frame;
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::ended);
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::ended);
    EXPECT_THAT(camera_->warnings(), IsEmpty());
}

TEST_F(ReplayCameraTest, FramesComeAtTheRecordedRate) {
    ASSERT_TRUE(folder_.recording(4));
    clock_.advance(fromSeconds(5));
    ASSERT_NE(play(), nullptr);
    EXPECT_EQ(camera_->info().framesPerSecond, 15.0);
    DepthFrame frame;
    for (int i = 0; i < 4; ++i) {
        ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
        EXPECT_EQ(frame.sequence, static_cast<std::uint64_t>(i));
        EXPECT_EQ(frame.sourceIndex, static_cast<std::uint64_t>(i));
        EXPECT_EQ(frame.captureTime, TimePoint(fromSeconds(5) + fromSeconds(i / 15.0)));
        EXPECT_EQ(clock_.now(), frame.captureTime);
        EXPECT_EQ(frame.restart, i == 0);
        EXPECT_TRUE(frame.lastOfStill);
    }
}

TEST_F(ReplayCameraTest, TimesOutBeforeAFrameIsDue) {
    ASSERT_TRUE(folder_.recording(2));
    ASSERT_NE(play(), nullptr);
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(Duration::zero(), frame), FrameStatus::frame);
    EXPECT_EQ(camera_->waitFrame(std::chrono::milliseconds(40), frame), FrameStatus::timedOut);
    EXPECT_EQ(clock_.now(), TimePoint(std::chrono::milliseconds(40)));
    EXPECT_EQ(camera_->waitFrame(-kLong, frame), FrameStatus::timedOut);
    EXPECT_EQ(camera_->waitFrame(Duration::max(), frame), FrameStatus::frame);
}

TEST_F(ReplayCameraTest, AReaderThatIsLateGetsEveryFrameWithItsOwnTime) {
    ASSERT_TRUE(folder_.recording(5));
    ASSERT_NE(play(), nullptr);
    clock_.advance(fromSeconds(60));
    DepthFrame frame;
    for (int i = 0; i < 5; ++i) {
        ASSERT_EQ(camera_->waitFrame(Duration::zero(), frame), FrameStatus::frame);
        EXPECT_EQ(frame.captureTime, TimePoint(fromSeconds(i / 15.0)));
    }
    EXPECT_EQ(clock_.now(), TimePoint(fromSeconds(60)));
}

TEST_F(ReplayCameraTest, AGapInTheNumbersIsALossAndAWarning) {
    ASSERT_TRUE(folder_.recording(6));
    std::filesystem::remove(folder_.path("depth-2.png"));
    std::filesystem::remove(folder_.path("depth-3.png"));
    ASSERT_NE(play(), nullptr);
    std::vector<std::uint64_t> sequences;
    DepthFrame frame;
    while (camera_->waitFrame(kLong, frame) == FrameStatus::frame) {
        sequences.push_back(frame.sequence);
        EXPECT_EQ(frame.captureTime, TimePoint(fromSeconds(static_cast<double>(frame.sequence) / 15.0)));
    }
    EXPECT_THAT(sequences, ElementsAre(0, 1, 4, 5));
    EXPECT_THAT(camera_->warnings(), ElementsAre(HasSubstr("2 picture(s) missing")));
}

TEST_F(ReplayCameraTest, StillsAreRepeatedAndEachStartsAnew) {
    ASSERT_TRUE(folder_.recording(2, sensorJson(R"("fps": 1, "independent": true)")));
    ASSERT_NE(play({.folder = folder_.path(), .stillRepeats = 3}), nullptr);
    EXPECT_TRUE(camera_->info().independent);
    EXPECT_EQ(camera_->info().framesPerSecond, 30.0);
    DepthFrame frame;
    for (int i = 0; i < 6; ++i) {
        ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
        EXPECT_EQ(frame.sequence, static_cast<std::uint64_t>(i));
        EXPECT_EQ(frame.sourceIndex, static_cast<std::uint64_t>(i / 3));
        EXPECT_EQ(frame.depth.at(0, 0), 1000 * (i / 3 + 1));
        EXPECT_EQ(frame.restart, i % 3 == 0);
        EXPECT_EQ(frame.lastOfStill, i % 3 == 2);
        EXPECT_EQ(frame.captureTime, TimePoint(fromSeconds(i / 30.0)));
    }
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::ended);
}

TEST_F(ReplayCameraTest, ALoopGoesOnCountingAndStartsAnew) {
    ASSERT_TRUE(folder_.recording(2));
    ASSERT_NE(play({.folder = folder_.path(), .loop = true}), nullptr);
    DepthFrame frame;
    for (int i = 0; i < 6; ++i) {
        ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
        EXPECT_EQ(frame.sequence, static_cast<std::uint64_t>(i));
        EXPECT_EQ(frame.sourceIndex, static_cast<std::uint64_t>(i % 2));
        EXPECT_EQ(frame.restart, i % 2 == 0);
    }
}

TEST_F(ReplayCameraTest, UnitsBecomeMillimetresAndSaturate) {
    ASSERT_TRUE(folder_.text("sensor.json", sensorJson(R"("depth_unit_mm": 0.125, "fps": 15)")));
    ASSERT_TRUE(folder_.depth("depth-0.png", 8000));
    ASSERT_NE(play(), nullptr);
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    EXPECT_EQ(frame.depth.at(0, 0), 1000);
    EXPECT_EQ(frame.depth.at(3, 0), 1000);
    EXPECT_EQ(frame.depth.at(4, 0), 1001);  // 1000.5 is rounded away from zero.

    ASSERT_TRUE(folder_.text("sensor.json", sensorJson(R"("depth_unit_mm": 10, "fps": 15)")));
    ASSERT_TRUE(folder_.depth("depth-0.png", 6553));
    ASSERT_NE(play(), nullptr);
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    EXPECT_EQ(frame.depth.at(0, 0), 65530);
    EXPECT_EQ(frame.depth.at(1, 0), 65535);
}

TEST_F(ReplayCameraTest, ColourComesWithItsDepth) {
    ASSERT_TRUE(folder_.recording(3));
    ASSERT_TRUE(folder_.colour("color-0.png", {10, 20, 30}));
    ASSERT_TRUE(folder_.colour("colour-2.png", {40, 50, 60}));
    ASSERT_NE(play(), nullptr);
    EXPECT_TRUE(camera_->info().colour);
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    ASSERT_EQ(frame.colour.width, 32);
    ASSERT_EQ(frame.colour.height, 24);
    EXPECT_EQ(frame.colour.at(31, 23), (Rgb8{10, 20, 30}));
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    EXPECT_TRUE(frame.colour.empty());
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    EXPECT_EQ(frame.colour.at(0, 0), (Rgb8{40, 50, 60}));
    EXPECT_THAT(camera_->warnings(), ElementsAre("depth-1.png has no colour picture"));
}

TEST_F(ReplayCameraTest, ColourOfAnotherSizeIsLeftOutWithAWarning) {
    ASSERT_TRUE(folder_.recording(1));
    ASSERT_TRUE(folder_.colour("color-0.png", {1, 2, 3}, 64, 48));
    ASSERT_NE(play(), nullptr);
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    EXPECT_TRUE(frame.colour.empty());
    EXPECT_THAT(camera_->warnings(), ElementsAre(HasSubstr("played without colour")));
}

TEST_F(ReplayCameraTest, ReopeningPlaysTheSameAgain) {
    ASSERT_TRUE(folder_.recording(3));
    ASSERT_NE(play(), nullptr);
    const auto first = firstPixels();
    camera_->close();
    DepthFrame frame;
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::closed);
    ASSERT_TRUE(camera_->open());
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    EXPECT_TRUE(frame.restart);
    EXPECT_EQ(frame.sequence, 0U);
    camera_->close();
    ASSERT_TRUE(camera_->open());
    EXPECT_EQ(firstPixels(), first);
}

TEST_F(ReplayCameraTest, NothingOfOursIsAllocatedOnceItPlays) {
    // libspng takes memory for each picture; what is asserted is that the count does not grow with time.
    ASSERT_TRUE(folder_.recording(40));
    ASSERT_NE(play(), nullptr);
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    std::vector<std::byte> png;
    Image<std::uint16_t> image;
    ASSERT_TRUE(readBytes(folder_.path("depth-1.png"), 1U << 20U, png));
    ASSERT_TRUE(decodePng(png, image));
    const test::AllocationCounter libraryCounter;
    ASSERT_TRUE(inspectPng(png));
    ASSERT_TRUE(decodePng(png, image));
    const auto library = libraryCounter.count();
    for (int i = 1; i < 40; ++i) {
        const test::AllocationCounter counter;
        ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
        EXPECT_LE(counter.count(), library) << "frame " << i;
    }
}

struct BadPicture {
    const char* name;
    std::function<bool(const RecordingFolder&)> spoil;
    const char* cause;
};

// gtest prints parameters; a function has no better text than its name.
void PrintTo(const BadPicture& bad, std::ostream* out) {  // NOLINT(readability-identifier-naming)
    *out << bad.name;
}

class BadPictureTest : public testing::TestWithParam<BadPicture> {};

TEST_P(BadPictureTest, IsLeftOutWithAWarningAndThePlayGoesOn) {
    VirtualClock clock;
    const RecordingFolder folder;
    ASSERT_TRUE(folder.recording(4));
    ASSERT_TRUE(GetParam().spoil(folder));
    auto made = makeReplayCamera({.folder = folder.path()}, clock);
    ASSERT_TRUE(made) << made.error().message();
    ReplayCamera& camera = **made;
    ASSERT_TRUE(camera.open());
    std::vector<std::uint64_t> sequences;
    DepthFrame frame;
    while (camera.waitFrame(kLong, frame) == FrameStatus::frame) {
        sequences.push_back(frame.sequence);
        EXPECT_EQ(frame.depth.at(0, 0), 1000 * (static_cast<int>(frame.sequence) + 1));
    }
    EXPECT_THAT(sequences, ElementsAre(0, 1, 3));
    ASSERT_EQ(camera.warnings().size(), 1U);
    EXPECT_THAT(camera.warnings()[0], HasSubstr("depth-2.png"));
    EXPECT_THAT(camera.warnings()[0], HasSubstr(GetParam().cause));
    EXPECT_THAT(camera.warnings()[0], HasSubstr("left out"));
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadPictureTest,
    testing::Values(
        BadPicture{"truncated",
                   [](const RecordingFolder& f) {
                       std::filesystem::resize_file(f.path("depth-2.png"), 90);
                       return true;
                   },
                   "cannot be decoded"},
        BadPicture{"empty", [](const RecordingFolder& f) { return f.text("depth-2.png", ""); }, "cannot be decoded"},
        BadPicture{"text", [](const RecordingFolder& f) { return f.text("depth-2.png", "not a picture"); },
                   "cannot be decoded"},
        BadPicture{"colour",
                   [](const RecordingFolder& f) {
                       return f.colour("depth-2.png", {1, 2, 3});
                   },
                   "8 bits"},
        BadPicture{"otherSize", [](const RecordingFolder& f) { return f.depth("depth-2.png", 1, 64, 48); }, "64 by 48"},
        BadPicture{"huge", [](const RecordingFolder& f) { return f.depth("depth-2.png", 1, 9000, 2); }, "too large"}),
    [](const auto& test) { return test.param.name; });

TEST_F(ReplayCameraTest, WhenNoPictureCanBeUsedTheCameraIsLostInBoundedTime) {
    ASSERT_TRUE(folder_.recording(3));
    ASSERT_NE(play({.folder = folder_.path(), .loop = true}), nullptr);
    for (int i = 0; i < 3; ++i)
        ASSERT_TRUE(folder_.text("depth-" + std::to_string(i) + ".png", "gone"));
    DepthFrame frame;
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::lost);
    EXPECT_EQ(camera_->warnings().size(), 3U);
}

TEST_F(ReplayCameraTest, ARecordingThatVanishesIsLostAndReturns) {
    ASSERT_TRUE(folder_.recording(2));
    ASSERT_NE(play(), nullptr);
    std::filesystem::remove(folder_.path("depth-0.png"));
    std::filesystem::remove(folder_.path("depth-1.png"));
    DepthFrame frame;
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::lost);
    ASSERT_TRUE(folder_.recording(2));
    camera_->close();
    ASSERT_TRUE(camera_->open());
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
}

TEST_F(ReplayCameraTest, WarningsAreBounded) {
    ASSERT_TRUE(folder_.text("sensor.json", RecordingFolder::kSensorJson));
    for (int i = 0; i < 200; ++i)
        ASSERT_TRUE(folder_.depth("depth-" + std::to_string(i) + ".png", 1, 16 + (i == 0 ? 16 : 0), 24));
    ASSERT_NE(play(), nullptr);
    firstPixels();
    const auto warnings = camera_->warnings();
    ASSERT_EQ(warnings.size(), 65U);
    EXPECT_EQ(warnings.back(), "135 more warning(s)");
}

// What makes no camera at all, with what the message must say.
struct Refusal {
    const char* name;
    std::function<bool(const RecordingFolder&)> spoil;
    const char* file;  ///< Ends the error's file.
    const char* cause;
};

void PrintTo(const Refusal& refusal, std::ostream* out) {  // NOLINT(readability-identifier-naming)
    *out << refusal.name;
}

class ReplayRefusalTest : public testing::TestWithParam<Refusal> {};

TEST_P(ReplayRefusalTest, SaysCauseMendAndFile) {
    VirtualClock clock;
    const RecordingFolder folder;
    ASSERT_TRUE(folder.recording(2));
    ASSERT_TRUE(GetParam().spoil(folder));
    const auto made = makeReplayCamera({.folder = folder.path()}, clock);
    ASSERT_FALSE(made);
    const Error& error = made.error();
    EXPECT_THAT(error.file, testing::EndsWith(GetParam().file));
    EXPECT_THAT(error.cause, HasSubstr(GetParam().cause));
    EXPECT_FALSE(error.mend.empty()) << error.message();
    EXPECT_FALSE(error.why.empty()) << error.message();
}

INSTANTIATE_TEST_SUITE_P(
    Table, ReplayRefusalTest,
    testing::Values(
        Refusal{"noSensorJson", [](const RecordingFolder& f) { return std::filesystem::remove(f.path("sensor.json")); },
                "/sensor.json", "no sensor.json"},
        Refusal{"brokenSensorJson", [](const RecordingFolder& f) { return f.text("sensor.json", "{\"width\": "); },
                "/sensor.json", "not valid JSON"},
        Refusal{"unknownKey", [](const RecordingFolder& f) { return f.text("sensor.json", sensorJson("\"fsp\": 15")); },
                "/sensor.json", "unknown"},
        Refusal{"eightBits",
                [](const RecordingFolder& f) {
                    return f.colour("depth-0.png", {1, 2, 3});
                },
                "/depth-0.png", "8 bits"},
        Refusal{"otherSize", [](const RecordingFolder& f) { return f.depth("depth-0.png", 1, 64, 48); }, "/depth-0.png",
                "64 by 48"},
        Refusal{"noPicture", [](const RecordingFolder& f) { return f.text("depth-0.png", "text"); }, "/depth-0.png",
                "cannot be decoded"},
        Refusal{"empty",
                [](const RecordingFolder& f) {
                    return std::filesystem::remove(f.path("depth-0.png")) &&
                           std::filesystem::remove(f.path("depth-1.png"));
                },
                "", "no depth pictures"}),
    [](const auto& test) { return test.param.name; });

TEST(ReplayTest, AFolderThatDoesNotExistIsRefused) {
    VirtualClock clock;
    const auto made = makeReplayCamera({.folder = "no/such/folder"}, clock);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::notFound);
    EXPECT_EQ(made.error().file, "no/such/folder");
    EXPECT_FALSE(made.error().mend.empty());
}

}  // namespace
}  // namespace cheval::hal

#include "daemon/record_run.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/settings_table.h"
#include "daemon/room_options.h"
#include "hal/image.h"
#include "hal/png/png.h"
#include "hal/replay/recording.h"
#include "hal/replay/replay_camera.h"
#include "hal/sim/world.h"
#include "tests/daemon/fake_camera.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

namespace fs = std::filesystem;
using test::CameraScript;
using test::Does;
using test::FakeCamera;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

constexpr hal::Duration kLong = std::chrono::seconds(100);

class RecordRunTest : public testing::Test {
  protected:
    RecordRunTest() : settings_(config::defaultSettings()) {
        settings_.privacy.recording = true;
        settings_.simulation.noise = false;
    }

    [[nodiscard]] std::vector<std::string> names() const {
        auto all = hal::listFolder(folder_.string());
        if (!all) return {};
        std::sort(all->begin(), all->end(), hal::naturalLess);
        return *all;
    }

    config::Settings settings_;
    hal::SteadyClock clock_;
    cheval::test::TemporaryFolder temporary_;
    fs::path folder_ = temporary_.path() / "recording";
};

TEST_F(RecordRunTest, NothingIsWrittenUnlessTheSettingsAllowIt) {
    settings_.privacy.recording = false;
    settings_.privacy.recordingColour = true;  // Not enough by itself.
    const auto report = recordSensor(settings_, {.folder = folder_.string(), .frames = 1}, clock_);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().key, "privacy.recording");
    EXPECT_FALSE(report.error().cause.empty());
    EXPECT_FALSE(report.error().mend.empty());
    EXPECT_FALSE(report.error().why.empty());
    EXPECT_FALSE(fs::exists(folder_));

    CameraScript script{.steps = {Does::frame}};
    FakeCamera camera(script, clock_);
    ASSERT_FALSE(recordCamera(camera, settings_, {.folder = folder_.string(), .frames = 1}, clock_));
    EXPECT_EQ(script.opened, 0);
    EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(RecordRunTest, ARecordingOfTheSimulatedWorldPlaysBackAsItWasSeen) {
    settings_.privacy.recordingColour = true;
    const auto report = recordSensor(settings_, {.folder = folder_.string(), .frames = 6}, clock_);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_FALSE(report->fault.has_value());
    EXPECT_TRUE(report->colour);
    ASSERT_EQ(report->frames.written, 6U);

    // The files' numbers are the world's own.
    const auto world = hal::sim::makeWorld(worldOptions(settings_));
    const auto recording = hal::arrangeRecording(names(), false);
    ASSERT_EQ(recording.pictures.size(), 6U);
    for (const hal::RecordedPicture& picture : recording.pictures) {
        hal::Image<std::uint16_t> depth;
        hal::Image<hal::Rgb8> colour;
        const std::uint64_t number = std::stoull(picture.depth.substr(std::string("depth-").size()));
        hal::sim::renderFrame(*world, number, depth, colour);
        hal::Image<std::uint16_t> written;
        ASSERT_TRUE(hal::readPng((folder_ / picture.depth).string(), written));
        EXPECT_EQ(written.pixels, depth.pixels) << picture.depth;
        hal::Image<hal::Rgb8> writtenColour;
        ASSERT_TRUE(hal::readPng((folder_ / picture.colour).string(), writtenColour));
        EXPECT_EQ(writtenColour.pixels, colour.pixels) << picture.colour;
    }

    hal::VirtualClock replayClock;
    auto replay = hal::makeReplayCamera({.folder = folder_.string()}, replayClock);
    ASSERT_TRUE(replay) << replay.error().message();
    ASSERT_TRUE((*replay)->open());
    const hal::CameraInfo& played = (*replay)->info();
    const auto simulated = hal::sim::makeSimulatedCamera(world, replayClock);
    ASSERT_TRUE(simulated->open());
    EXPECT_EQ(played.intrinsics.fx, simulated->info().intrinsics.fx);
    EXPECT_EQ(played.intrinsics.cy, simulated->info().intrinsics.cy);
    EXPECT_EQ(played.framesPerSecond, simulated->info().framesPerSecond);
    EXPECT_EQ(played.mount.heightMm, simulated->info().mount.heightMm);
    EXPECT_EQ(played.mount.tiltDeg, simulated->info().mount.tiltDeg);
    hal::DepthFrame frame;
    std::uint64_t frames = 0;
    while ((*replay)->waitFrame(kLong, frame) == hal::FrameStatus::frame)
        ++frames;
    EXPECT_EQ(frames, 6U);
}

TEST_F(RecordRunTest, WithoutTheSecondConsentThereIsNoColour) {
    const auto report = recordSensor(settings_, {.folder = folder_.string(), .frames = 2}, clock_);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_FALSE(report->colour);
    EXPECT_EQ(report->frames.written, 2U);
    EXPECT_THAT(names(), testing::Each(testing::AnyOf(StartsWith("depth-"), "sensor.json")));
    EXPECT_EQ(names().size(), 3U);
}

TEST_F(RecordRunTest, TheMountInTheSettingsIsTheOneWrittenDown) {
    settings_.sensor.heightMm = 1777.0;
    settings_.sensor.tiltDeg = -12.0;
    ASSERT_TRUE(recordSensor(settings_, {.folder = folder_.string(), .frames = 1}, clock_));
    hal::VirtualClock replayClock;
    auto replay = hal::makeReplayCamera({.folder = folder_.string()}, replayClock);
    ASSERT_TRUE(replay) << replay.error().message();
    ASSERT_TRUE((*replay)->open());
    EXPECT_EQ((*replay)->info().mount.heightMm, 1777.0F);
    EXPECT_EQ((*replay)->info().mount.tiltDeg, -12.0F);
}

class RecordRunOfRecordingsTest : public RecordRunTest {
  protected:
    void makeSource(const std::string& more, const std::vector<std::string>& pictures) {
        fs::create_directories(source_);
        std::ofstream(source_ / "sensor.json")
            << R"({"width": 32, "height": 24, "fx": 28.5, "fy": 28.5, "cx": 15.5, "cy": 11.5)" << more << "}";
        std::uint16_t first = 1000;
        for (const std::string& name : pictures) {
            const hal::Image<std::uint16_t> wall(32, 24, first++);
            ASSERT_TRUE(hal::writePng((source_ / name).string(), wall.view()));
        }
        settings_.sensor.source = config::SensorSource::replay;
        settings_.sensor.folder = source_.string();
    }

    fs::path source_ = temporary_.path() / "source";
};

TEST_F(RecordRunOfRecordingsTest, ARecordingIsCopiedOnceAndWithItsGaps) {
    makeSource(R"(, "fps": 200)", {"depth-7.png", "depth-8.png", "depth-10.png"});
    const auto report = recordSensor(settings_, {.folder = folder_.string()}, clock_);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_FALSE(report->fault.has_value());
    EXPECT_EQ(report->frames.written, 3U);
    EXPECT_EQ(report->frames.dropped, 0U);
    EXPECT_EQ(report->missed, 1U);
    EXPECT_THAT(names(), ElementsAre("depth-000000.png", "depth-000001.png", "depth-000003.png", "sensor.json"));
}

TEST_F(RecordRunOfRecordingsTest, OfStillsEachIsRecordedOnce) {
    makeSource(R"(, "independent": true)", {"depth-a.png", "depth-b.png"});
    const auto report = recordSensor(settings_, {.folder = folder_.string()}, clock_);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->frames.written, 2U);
    hal::VirtualClock replayClock;
    auto replay = hal::makeReplayCamera({.folder = folder_.string()}, replayClock);
    ASSERT_TRUE(replay) << replay.error().message();
    ASSERT_TRUE((*replay)->open());
    EXPECT_TRUE((*replay)->info().independent);
    EXPECT_EQ((*replay)->pictureCount(), 2U);
}

class RecordRunFaultTest : public RecordRunTest {
  protected:
    Expected<RecordReport> record(CameraScript& script, RecordOptions options = {}) {
        options.folder = folder_.string();
        FakeCamera camera(script, virtual_);
        auto report = recordCamera(camera, settings_, options, virtual_);
        EXPECT_EQ(script.opened, script.closed) << "the sensor was not given back";
        return report;
    }
    hal::VirtualClock virtual_;
};

TEST_F(RecordRunFaultTest, ASensorThatIsHeldByTheMirrorIsExplained) {
    CameraScript script{.steps = {Does::refuseToOpen, Does::frame}};
    const auto report = record(script);
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().cause, HasSubstr("busy"));
    EXPECT_THAT(report.error().mend, HasSubstr("stop it first"));
    EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(RecordRunFaultTest, ALostSensorEndsItAndWhatWasWrittenStays) {
    CameraScript script{.steps = {Does::frame, Does::frame, Does::lose}};
    const auto report = record(script);
    ASSERT_TRUE(report) << report.error().message();
    ASSERT_TRUE(report->fault.has_value());
    EXPECT_THAT(report->fault->cause, HasSubstr("gone"));
    EXPECT_EQ(report->frames.written, 2U);
    EXPECT_THAT(names(), ElementsAre("depth-000001.png", "depth-000002.png", "sensor.json"));
}

TEST_F(RecordRunFaultTest, ASilentSensorEndsItAfterTheTimeInTheSettings) {
    settings_.sensor.lostAfterMs = 1500;
    CameraScript script{.steps = {Does::frame, Does::timeOut}};
    const auto report = record(script);
    ASSERT_TRUE(report) << report.error().message();
    ASSERT_TRUE(report->fault.has_value());
    EXPECT_THAT(report->fault->cause, HasSubstr("no frame"));
    EXPECT_EQ(report->frames.written, 1U);
    EXPECT_GT(hal::seconds(virtual_.now()), 1.5);
    EXPECT_LT(hal::seconds(virtual_.now()), 2.0);
}

TEST_F(RecordRunFaultTest, EndsAfterSoManySeconds) {
    CameraScript script{.steps = {Does::frame}};
    const auto report = record(script, {.seconds = 2.0});
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_FALSE(report->fault.has_value());
    EXPECT_EQ(report->frames.written + report->frames.dropped, 61U);
    EXPECT_GT(report->frames.written, 0U);
}

TEST_F(RecordRunFaultTest, EndsWhenItIsToldTo) {
    CameraScript script{.steps = {Does::frame}};
    int asked = 0;
    const auto report = record(script, {.stop = [&asked] { return ++asked > 3; }});
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_FALSE(report->fault.has_value());
    EXPECT_EQ(report->frames.written, 3U);
}

TEST_F(RecordRunFaultTest, AFolderWithSomethingInItIsRefused) {
    fs::create_directories(folder_ / "inner");
    CameraScript script{.steps = {Does::frame}};
    const auto report = record(script);
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().cause, HasSubstr("not empty"));
}

TEST(StopSignals, TurnASignalIntoAnAnswerAndLetTheNextOneThrough) {
    sigset_t blocked;
    {
        StopSignals signals;
        EXPECT_FALSE(signals.requested());
        ASSERT_EQ(std::raise(SIGINT), 0);
        EXPECT_TRUE(signals.requested());
        EXPECT_TRUE(signals.requested());
        ASSERT_EQ(pthread_sigmask(SIG_BLOCK, nullptr, &blocked), 0);
        EXPECT_EQ(sigismember(&blocked, SIGINT), 0);
    }
    ASSERT_EQ(pthread_sigmask(SIG_BLOCK, nullptr, &blocked), 0);
    EXPECT_EQ(sigismember(&blocked, SIGTERM), 0);
}

}  // namespace
}  // namespace cheval::daemon

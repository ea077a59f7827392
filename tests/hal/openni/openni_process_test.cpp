// The whole real way to a frame: our driver, the real OpenNI2, cheval-sensor, the frame ring.
#include <cmath>
#include <csignal>
#include <string>

#include <gtest/gtest.h>

#include "hal/child_process.h"
#include "hal/sensor_process/process_camera.h"
#include "hal/sim/world.h"
#include "tests/hal/replay/recording_folder.h"
#include "tests/support/sensor_world.h"

namespace cheval::hal {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::SensorWorld;

class OpenNiProcessTest : public testing::Test {
  protected:
    std::unique_ptr<ProcessCamera> make(const SensorWorld& world, std::vector<std::string> arguments = {}) {
        return makeProcessCamera({.program = CHEVAL_SENSOR,
                                  .arguments = std::move(arguments),
                                  .environment = world.environment(),
                                  .openWait = seconds(60)},
                                 clock_);
    }
    FrameStatus outcome(DepthCamera& camera, DepthFrame& frame, Duration limit = seconds(20)) {
        const TimePoint end = clock_.now() + limit;
        FrameStatus status = FrameStatus::timedOut;
        while (status == FrameStatus::timedOut && clock_.now() < end)
            status = camera.waitFrame(milliseconds(100), frame);
        return status;
    }
    FrameStatus outcomeAfterFrames(DepthCamera& camera, Duration limit = seconds(20)) {
        DepthFrame frame;
        const TimePoint end = clock_.now() + limit;
        FrameStatus status = FrameStatus::frame;
        while (status == FrameStatus::frame && clock_.now() < end)
            status = outcome(camera, frame, end - clock_.now());
        return status;
    }

    SteadyClock clock_;
};

TEST_F(OpenNiProcessTest, DeliversTheVeryPicturesOfTheWorld) {
    const SensorWorld world("sim:seed=5,noise=1");
    const auto camera = make(world);
    const auto opened = camera->open();
    ASSERT_TRUE(opened) << opened.error().message();
    const sim::WorldOptions options{.seed = 5};
    const auto same = sim::makeWorld(options);
    Image<std::uint16_t> depth;
    Image<Rgb8> colour;
    std::uint64_t last = 0;
    for (int i = 0; i < 5; ++i) {
        DepthFrame frame;
        ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
        EXPECT_TRUE(i == 0 || frame.sequence > last);
        last = frame.sequence;
        sim::renderFrame(*same, frame.sequence, depth, colour);
        ASSERT_EQ(frame.depth.width, depth.width);
        ASSERT_FALSE(frame.colour.empty());
        EXPECT_TRUE(std::equal(depth.pixels.begin(), depth.pixels.end(), frame.depth.data));
        EXPECT_TRUE(std::equal(colour.pixels.begin(), colour.pixels.end(), frame.colour.data));
        EXPECT_LE(frame.captureTime, clock_.now());
    }
    const CameraInfo& info = camera->info();
    EXPECT_NEAR(info.framesPerSecond, 30.0, 0.01);
    EXPECT_NEAR(info.intrinsics.fx, Intrinsics{}.fx, 0.5);
    EXPECT_NEAR(info.intrinsics.fy, Intrinsics{}.fy, 0.5);
    EXPECT_NE(info.name.find("Cheval"), std::string::npos);
}

TEST_F(OpenNiProcessTest, AnUnpluggedSensorIsLostAndItsReturnIsTold) {
    SensorWorld world("sim:seed=5,noise=0");
    const auto camera = make(world);
    ASSERT_TRUE(camera->open());
    for (int round = 0; round < 5; ++round) {
        DepthFrame frame;
        ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
        ASSERT_TRUE(world.tell("unplug"));
        ASSERT_EQ(outcomeAfterFrames(*camera), FrameStatus::lost);
        EXPECT_NE(camera->lossReason()->cause.find("unplugged"), std::string::npos);
        camera->close();
        const auto refused = camera->open();
        ASSERT_FALSE(refused);
        EXPECT_FALSE(refused.error().mend.empty());
        camera->takeArrival();
        ASSERT_TRUE(world.tell("plug"));
        const TimePoint end = clock_.now() + seconds(10);
        bool arrived = false;
        Interrupt never;
        while (!arrived && clock_.now() < end) {
            arrived = camera->takeArrival();
            clock_.waitUntil(clock_.now() + milliseconds(5), never);
        }
        EXPECT_TRUE(arrived);
        const auto opened = camera->open();
        ASSERT_TRUE(opened) << opened.error().message();
    }
    EXPECT_EQ(camera->starts(), 1U);
}

TEST_F(OpenNiProcessTest, AStallIsSilenceAndItsEndBringsFrames) {
    SensorWorld world("sim:seed=5,noise=0");
    const auto camera = make(world);
    ASSERT_TRUE(camera->open());
    DepthFrame frame;
    ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
    ASSERT_TRUE(world.tell("stall"));
    outcomeAfterFrames(*camera, seconds(1));
    EXPECT_EQ(camera->waitFrame(milliseconds(300), frame), FrameStatus::timedOut);
    ASSERT_TRUE(camera->restartStream());
    EXPECT_EQ(camera->waitFrame(milliseconds(300), frame), FrameStatus::timedOut);
    ASSERT_TRUE(world.tell("resume"));
    EXPECT_EQ(outcome(*camera, frame), FrameStatus::frame);
}

TEST_F(OpenNiProcessTest, NoiseAndLiesFromTheDeviceHarmNobody) {
    SensorWorld world("sim:seed=5,noise=0");
    const auto camera = make(world);
    ASSERT_TRUE(camera->open());
    DepthFrame frame;
    ASSERT_TRUE(world.tell("garbage"));
    for (int i = 0; i < 5; ++i)
        ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
    ASSERT_TRUE(world.tell("lie"));
    outcomeAfterFrames(*camera, seconds(1));
    EXPECT_EQ(camera->waitFrame(milliseconds(300), frame), FrameStatus::timedOut);
    ASSERT_TRUE(world.tell("sound"));
    EXPECT_EQ(outcome(*camera, frame), FrameStatus::frame);
    EXPECT_EQ(camera->starts(), 1U);
}

TEST_F(OpenNiProcessTest, ABusySensorIsRefusedInTheDriversWords) {
    SensorWorld world("sim:seed=5,noise=0");
    world.tell("busy");
    const auto camera = make(world);
    const auto refused = camera->open();
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().cause.find("already open"), std::string::npos) << refused.error().cause;
    ASSERT_TRUE(world.tell("free"));
    EXPECT_TRUE(camera->open());
}

TEST_F(OpenNiProcessTest, ASmallModeIsDoubledAndASmallerOneRefused) {
    SensorWorld world("sim:seed=5,noise=0");
    world.tell("mode 320x240");
    const auto camera = make(world);
    const auto opened = camera->open();
    ASSERT_TRUE(opened) << opened.error().message();
    DepthFrame frame;
    ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
    EXPECT_EQ(frame.depth.width, 640);
    EXPECT_EQ(frame.colour.width, 640);
    for (int y = 0; y < 480; y += 2) {
        for (int x = 0; x < 640; x += 2)
            ASSERT_EQ(frame.depth.at(x, y), frame.depth.at(x + 1, y + 1));
    }
    EXPECT_NEAR(camera->info().intrinsics.fx, Intrinsics{}.fx, 0.5);
    EXPECT_NE(camera->info().name.find("doubled"), std::string::npos);
    camera->close();
    world.tell("mode 160x120");
    const auto refused =
        makeProcessCamera({.program = CHEVAL_SENSOR, .environment = world.environment()}, clock_)->open();
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().mend.find("640×480"), std::string::npos);
}

TEST_F(OpenNiProcessTest, ACallThatNeverReturnsDoesNotOutliveTheCamera) {
    for (const char* call : {"hang open", "hang close", "hang read"}) {
        SensorWorld world("sim:seed=5,noise=0");
        auto camera = makeProcessCamera({.program = CHEVAL_SENSOR,
                                         .environment = world.environment(),
                                         .openWait = std::string(call) == "hang open" ? seconds(2) : seconds(60)},
                                        clock_);
        if (std::string(call) == "hang open") world.tell(call);
        const bool opened = camera->open().hasValue();
        EXPECT_EQ(opened, std::string(call) != "hang open");
        if (opened) world.tell(call);
        const pid_t process = camera->process();
        camera.reset();
        EXPECT_NE(::kill(process, 0), 0) << call;
    }
}

TEST_F(OpenNiProcessTest, AFolderOfPicturesComesAcrossToTheMillimetre) {
    test::RecordingFolder folder;
    ASSERT_TRUE(folder.recording(
        30, R"({"width": 640, "height": 480, "fx": 570, "fy": 570, "cx": 319.5, "cy": 239.5, "fps": 30})", 640, 480));
    const SensorWorld world("folder:" + folder.path());
    const auto camera = make(world);
    const auto opened = camera->open();
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_FALSE(camera->info().colour);
    EXPECT_NEAR(camera->info().intrinsics.fx, 570.0, 0.5);
    DepthFrame frame;
    ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
    EXPECT_TRUE(frame.colour.empty());
    EXPECT_EQ(frame.depth.at(0, 0), 1000 * (frame.sequence % 30 + 1));
    EXPECT_EQ(frame.depth.at(5, 2), static_cast<std::uint16_t>(frame.depth.at(0, 0) + 2 * 640 + 5));
}

TEST_F(OpenNiProcessTest, ARecordingPlaysEachFrameInOrderOnAnyClockAndEnds) {
    const test::TemporaryFolder folder;
    const std::string file = (folder.path() / "visit.oni").string();
    const SensorWorld world("sim:seed=5,noise=1,fps=30");
    {
        auto recorder = ChildProcess::start(
            {.program = CHEVAL_ONI_RECORDER, .arguments = {file, "8"}, .environment = world.environment()});
        ASSERT_TRUE(recorder);
        ASSERT_TRUE(recorder->waitEnd(seconds(200)));
        ASSERT_EQ(recorder->ending(), "exited with status 0");
    }
    std::vector<std::vector<std::uint16_t>> first;
    for (int pass = 0; pass < 2; ++pass) {
        VirtualClock clock;
        const auto camera = makeProcessCamera(
            {.program = CHEVAL_SENSOR, .arguments = {"--recording", file}, .environment = world.environment()}, clock);
        const auto opened = camera->open();
        ASSERT_TRUE(opened) << opened.error().message();
        EXPECT_TRUE(camera->info().colour);
        std::vector<std::vector<std::uint16_t>> pictures;
        FrameStatus status = FrameStatus::frame;
        TimePoint before{};
        while (true) {
            DepthFrame frame;
            status = camera->waitFrame(std::chrono::hours(1), frame);
            if (status != FrameStatus::frame) break;
            EXPECT_EQ(frame.sequence, pictures.size());
            EXPECT_EQ(frame.restart, pictures.empty());
            EXPECT_FALSE(frame.colour.empty());
            if (!pictures.empty()) {
                EXPECT_GT(frame.captureTime, before);
            }
            before = frame.captureTime;
            pictures.emplace_back(frame.depth.data, frame.depth.data + std::ptrdiff_t{640} * 480);
        }
        EXPECT_EQ(status, FrameStatus::ended);
        EXPECT_GE(pictures.size(), 6U);
        // Time was the recording's own.
        EXPECT_GE(hal::seconds(clock.now()), 0.15);
        if (pass == 0) first = pictures;
        EXPECT_EQ(pictures, first);
    }
    // They are the world's own pictures.
    const auto same = sim::makeWorld({.seed = 5});
    Image<std::uint16_t> depth;
    Image<Rgb8> colour;
    std::size_t found = 0;
    for (std::uint64_t frame = 0; frame < 60 && found < first.size(); ++frame) {
        sim::renderFrame(*same, frame, depth, colour);
        found += depth.pixels == first[found] ? 1 : 0;
    }
    EXPECT_EQ(found, first.size());
}

TEST_F(OpenNiProcessTest, ARecordingInALoopGoesOnInTimeAndNumber) {
    const test::TemporaryFolder folder;
    const std::string file = (folder.path() / "visit.oni").string();
    const SensorWorld world("sim:seed=5,noise=0,fps=30");
    auto recorder = ChildProcess::start(
        {.program = CHEVAL_ONI_RECORDER, .arguments = {file, "6"}, .environment = world.environment()});
    ASSERT_TRUE(recorder);
    ASSERT_TRUE(recorder->waitEnd(seconds(200)));
    VirtualClock clock;
    const auto camera = makeProcessCamera({.program = CHEVAL_SENSOR,
                                           .arguments = {"--recording", file},
                                           .environment = world.environment(),
                                           .loop = true},
                                          clock);
    ASSERT_TRUE(camera->open());
    int restarts = 0;
    TimePoint before{};
    for (std::uint64_t i = 0; i < 20; ++i) {
        DepthFrame frame;
        ASSERT_EQ(camera->waitFrame(std::chrono::hours(1), frame), FrameStatus::frame);
        EXPECT_EQ(frame.sequence, i);
        EXPECT_GE(frame.captureTime, before);
        before = frame.captureTime;
        restarts += frame.restart ? 1 : 0;
    }
    EXPECT_GE(restarts, 3);
}

TEST_F(OpenNiProcessTest, AFileThatIsNoRecordingIsRefusedByName) {
    const test::RecordingFolder folder;
    ASSERT_TRUE(folder.text("broken.oni", "this is no recording"));
    const SensorWorld world("sim:seed=5");
    for (const char* name : {"broken.oni", "absent.oni"}) {
        const auto refused = make(world, {"--recording", folder.path(name)})->open();
        ASSERT_FALSE(refused) << name;
        EXPECT_NE(refused.error().cause.find(name), std::string::npos) << refused.error().cause;
        EXPECT_FALSE(refused.error().mend.empty());
    }
}

TEST_F(OpenNiProcessTest, WithoutASensorItSaysSo) {
    const auto camera = makeProcessCamera(
        {.program = CHEVAL_SENSOR, .environment = {"CHEVAL_SIMULATED_SENSOR=", "LD_LIBRARY_PATH=" CHEVAL_OPENNI}},
        clock_);
    const auto refused = camera->open();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
    EXPECT_FALSE(refused.error().mend.empty());
}

}  // namespace
}  // namespace cheval::hal

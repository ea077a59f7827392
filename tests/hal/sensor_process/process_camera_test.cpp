#include "hal/sensor_process/process_camera.h"

#include <csignal>
#include <string>

#include <gtest/gtest.h>

#include "tests/conformance/process_use.h"

namespace cheval::hal {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ProcessCameraTest : public testing::Test {
  protected:
    std::unique_ptr<ProcessCamera> make(const std::string& deed, Duration openWait = seconds(60)) {
        return makeProcessCamera({.program = CHEVAL_TEST_SENSOR, .arguments = {deed}, .openWait = openWait}, clock_);
    }
    /// Waits through time-outs for something else; timedOut after half a minute.
    FrameStatus outcome(ProcessCamera& camera, DepthFrame& frame) {
        const TimePoint limit = clock_.now() + seconds(30);
        while (clock_.now() < limit) {
            const FrameStatus status = camera.waitFrame(milliseconds(100), frame);
            if (status != FrameStatus::timedOut) return status;
        }
        return FrameStatus::timedOut;
    }
    /// Frames until something else comes.
    FrameStatus outcomeAfterFrames(ProcessCamera& camera, int& frames) {
        DepthFrame frame;
        FrameStatus status = FrameStatus::frame;
        for (frames = 0; status == FrameStatus::frame && frames < 1000; ++frames)
            status = outcome(camera, frame);
        --frames;
        return status;
    }

    SteadyClock clock_;
};

TEST_F(ProcessCameraTest, DeliversTheFramesOfTheOtherProcess) {
    const auto camera = make("");
    const auto opened = camera->open();
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_GT(camera->process(), 0);
    EXPECT_TRUE(camera->info().colour);
    std::uint64_t last = 0;
    for (int i = 0; i < 10; ++i) {
        DepthFrame frame;
        ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
        EXPECT_EQ(frame.restart, i == 0);
        EXPECT_EQ(frame.depth.width, 640);
        EXPECT_EQ(frame.intrinsics.fx, camera->info().intrinsics.fx);
        EXPECT_TRUE(i == 0 || frame.sequence > last);
        last = frame.sequence;
        EXPECT_LE(frame.captureTime, clock_.now());
        EXPECT_GE(camera->handOver(), Duration::zero());
    }
}

TEST_F(ProcessCameraTest, KeepsTheProcessOverCloseAndOpen) {
    const auto camera = make("");
    ASSERT_TRUE(camera->open());
    const pid_t process = camera->process();
    for (int i = 0; i < 5; ++i) {
        camera->close();
        ASSERT_TRUE(camera->open());
        DepthFrame frame;
        ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
        EXPECT_TRUE(frame.restart);
    }
    EXPECT_EQ(camera->process(), process);
    EXPECT_EQ(camera->starts(), 1U);
}

TEST_F(ProcessCameraTest, AKilledProcessIsALossWithWordsAndIsStartedAgain) {
    const auto camera = make("");
    ASSERT_TRUE(camera->open());
    for (std::uint64_t round = 1; round <= 3; ++round) {
        DepthFrame frame;
        ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
        ASSERT_EQ(::kill(camera->process(), SIGKILL), 0);
        int frames = 0;
        ASSERT_EQ(outcomeAfterFrames(*camera, frames), FrameStatus::lost);
        ASSERT_TRUE(camera->lossReason());
        EXPECT_NE(camera->lossReason()->cause.find("signal 9"), std::string::npos) << camera->lossReason()->cause;
        EXPECT_EQ(camera->process(), -1);
        camera->close();
        ASSERT_TRUE(camera->open());
        EXPECT_EQ(camera->starts(), round + 1);
    }
}

struct Misdeed {
    const char* deed;
    const char* says;  ///< Part of the loss' cause.
};
class MisdeedTest : public ProcessCameraTest, public testing::WithParamInterface<Misdeed> {};

TEST_P(MisdeedTest, LosesTheCameraWithWords) {
    const auto camera = make(GetParam().deed);
    const auto opened = camera->open();
    ASSERT_TRUE(opened) << opened.error().message();
    int frames = 0;
    EXPECT_EQ(outcomeAfterFrames(*camera, frames), FrameStatus::lost);
    ASSERT_TRUE(camera->lossReason());
    EXPECT_NE(camera->lossReason()->cause.find(GetParam().says), std::string::npos) << camera->lossReason()->cause;
    EXPECT_FALSE(camera->lossReason()->mend.empty());
}

INSTANTIATE_TEST_SUITE_P(ProcessCamera, MisdeedTest,
                         testing::Values(Misdeed{"lie", "rules of the frame ring"},
                                         Misdeed{"other-size", "another size"}, Misdeed{"crash", "signal 6"},
                                         Misdeed{"lose", "gone"}),
                         [](const testing::TestParamInfo<Misdeed>& test) {
                             std::string name = test.param.deed;
                             std::erase(name, '-');
                             return name;
                         });

struct Refusal {
    const char* deed;
    const char* says;
};
class RefusalTest : public ProcessCameraTest, public testing::WithParamInterface<Refusal> {};

TEST_P(RefusalTest, IsNotOpenedAndSaysWhy) {
    const auto camera = make(GetParam().deed);
    const auto opened = camera->open();
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().cause.find(GetParam().says), std::string::npos) << opened.error().cause;
    EXPECT_FALSE(opened.error().mend.empty());
    EXPECT_FALSE(camera->isOpen());
}

INSTANTIATE_TEST_SUITE_P(ProcessCamera, RefusalTest,
                         testing::Values(Refusal{"refuse", "another process holds it"}, Refusal{"exit", "status 3"},
                                         Refusal{"impossible-size", "describes a picture of"},
                                         Refusal{"impossible-lens", "would see 176 degrees across"},
                                         Refusal{"chatter", "sensor process"}),
                         [](const testing::TestParamInfo<Refusal>& test) {
                             std::string name = test.param.deed;
                             std::erase(name, '-');
                             return name;
                         });

TEST_F(ProcessCameraTest, AHangingOpeningIsWaitedForInPartsAndEndsWithTheCamera) {
    pid_t process = -1;
    {
        const auto camera = make("hang-open", milliseconds(50));
        for (int i = 0; i < 3; ++i) {
            const auto opened = camera->open();
            ASSERT_FALSE(opened);
            EXPECT_EQ(opened.error().code, ErrorCode::timedOut);
        }
        EXPECT_EQ(camera->starts(), 1U);
        process = camera->process();
        EXPECT_EQ(::kill(process, 0), 0);
    }
    EXPECT_NE(::kill(process, 0), 0) << "a process that hangs outlived its camera";
}

TEST_F(ProcessCameraTest, AHangingReadIsSilence) {
    const auto camera = make("hang-read");
    ASSERT_TRUE(camera->open());
    int frames = 0;
    DepthFrame frame;
    while (camera->waitFrame(milliseconds(500), frame) == FrameStatus::frame)
        ++frames;
    EXPECT_EQ(camera->waitFrame(milliseconds(50), frame), FrameStatus::timedOut);
    EXPECT_LE(frames, 3);
}

TEST_F(ProcessCameraTest, AProcessThatDoesNotAnswerIsLost) {
    const auto camera = make("hang-read");
    ASSERT_TRUE(camera->open());
    DepthFrame frame;
    while (camera->waitFrame(milliseconds(500), frame) == FrameStatus::frame)
        continue;
    const pid_t process = camera->process();
    ASSERT_TRUE(camera->restartStream());
    EXPECT_EQ(outcome(*camera, frame), FrameStatus::lost);
    EXPECT_NE(camera->lossReason()->cause.find("did not answer"), std::string::npos);
    EXPECT_NE(::kill(process, 0), 0);
}

TEST_F(ProcessCameraTest, RestartingTheStreamBringsASilentOneBack) {
    const auto camera = make("silent-after-three");
    ASSERT_TRUE(camera->open());
    DepthFrame frame;
    while (camera->waitFrame(milliseconds(500), frame) == FrameStatus::frame)
        continue;
    ASSERT_TRUE(camera->restartStream());
    EXPECT_EQ(outcome(*camera, frame), FrameStatus::frame);
}

TEST_F(ProcessCameraTest, AMissingProgramIsNamed) {
    const auto camera = makeProcessCamera({.program = "/nowhere/cheval-sensor"}, clock_);
    const auto opened = camera->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::notFound);
    EXPECT_EQ(opened.error().file, "/nowhere/cheval-sensor");
}

TEST_F(ProcessCameraTest, NothingRemainsOfTenProcesses) {
    const auto use = [&] {
        const auto camera = make("");
        ASSERT_TRUE(camera->open());
        DepthFrame frame;
        ASSERT_EQ(outcome(*camera, frame), FrameStatus::frame);
        if (camera->starts() % 2 == 1) ::kill(camera->process(), SIGKILL);
    };
    use();
    const test::ProcessUse before;
    for (int i = 0; i < 10; ++i)
        use();
    const test::ProcessUse after;
    EXPECT_EQ(after.descriptors, before.descriptors);
    EXPECT_EQ(after.threads, before.threads);
}

}  // namespace
}  // namespace cheval::hal

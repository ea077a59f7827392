#include "daemon/camera_supervisor.h"

#include <atomic>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/daemon/fake_camera.h"
#include "tests/support/allocation_counter.h"

namespace cheval::daemon {
namespace {

using test::CameraScript;
using test::Does;
using test::FakeCamera;

class CameraSupervisorTest : public testing::Test {
  protected:
    CameraSupervisor make(const CameraSupervisorOptions& options = {}) {
        return {[this]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
                    ++made_;
                    if (missing_) return Error{.code = ErrorCode::notFound, .cause = "no such folder"};
                    return std::unique_ptr<hal::DepthCamera>(std::make_unique<FakeCamera>(script_, clock_));
                },
                options, clock_};
    }
    /// Turns until the state is reached; how long that took in seconds, or −1 after an hour.
    double secondsUntil(CameraSupervisor& supervisor, CameraState state) {
        const hal::TimePoint start = clock_.now();
        hal::DepthFrame frame;
        while (supervisor.state() != state) {
            if (clock_.now() - start > std::chrono::hours(1)) return -1.0;
            supervisor.next(frame);
        }
        return hal::seconds(clock_.now() - start);
    }

    hal::VirtualClock clock_;
    CameraScript script_;
    int made_ = 0;
    bool missing_ = false;
};

struct Chain {
    const char* name;
    std::deque<Does> script;
    std::vector<CameraState> states;
};
void PrintTo(const Chain& chain, std::ostream* stream) {
    *stream << chain.name;
}

class CameraChain : public CameraSupervisorTest, public testing::WithParamInterface<Chain> {};

TEST_P(CameraChain, isExactlyThis) {
    script_.steps = GetParam().script;
    CameraSupervisor supervisor = make();
    std::vector<CameraState> states = {supervisor.state()};
    hal::DepthFrame frame;
    for (int i = 0; i < 200 && states.size() < GetParam().states.size() + 1; ++i) {
        supervisor.next(frame);
        if (supervisor.state() != states.back()) states.push_back(supervisor.state());
    }
    if (states.size() > GetParam().states.size()) states.resize(GetParam().states.size());
    EXPECT_EQ(states, GetParam().states);
}

INSTANTIATE_TEST_SUITE_P(CameraSupervisor, CameraChain,
                         testing::Values(Chain{"streams", {Does::frame}, {CameraState::closed, CameraState::streaming}},
                                         Chain{"aLateFrameIsNoLoss",
                                               {Does::timeOut, Does::timeOut, Does::frame},
                                               {CameraState::closed, CameraState::waiting, CameraState::streaming}},
                                         Chain{"isLostAndReturns",
                                               {Does::frame, Does::lose, Does::frame},
                                               {CameraState::closed, CameraState::streaming, CameraState::lost,
                                                CameraState::streaming}},
                                         Chain{"stallsAndIsReopened",
                                               {Does::frame, Does::timeOut},
                                               {CameraState::closed, CameraState::streaming, CameraState::lost,
                                                CameraState::waiting, CameraState::lost, CameraState::waiting}},
                                         Chain{"doesNotOpenAtFirst",
                                               {Does::refuseToOpen, Does::refuseToOpen, Does::frame},
                                               {CameraState::closed, CameraState::lost, CameraState::streaming}},
                                         Chain{"ends",
                                               {Does::frame, Does::frame, Does::end},
                                               {CameraState::closed, CameraState::streaming, CameraState::ended}}),
                         [](const testing::TestParamInfo<Chain>& parameter) { return parameter.param.name; });

TEST_F(CameraSupervisorTest, givesUpOnAStalledStreamAfterTheSetTime) {
    script_.steps = {Does::frame, Does::timeOut};
    CameraSupervisor supervisor = make({.recovery = {.silence = std::chrono::milliseconds(700)}});
    secondsUntil(supervisor, CameraState::streaming);
    EXPECT_NEAR(secondsUntil(supervisor, CameraState::lost), 0.7, 0.101);
    ASSERT_TRUE(supervisor.fault());
    EXPECT_FALSE(supervisor.fault()->mend.empty());
    EXPECT_EQ(supervisor.recovery().rung(), RecoveryRung::restartStream);
}

TEST_F(CameraSupervisorTest, neverGivesUpOnARecordingForItsGaps) {
    script_.steps = {Does::frame, Does::timeOut};
    CameraSupervisor supervisor = make({.recovery = {.silence = std::nullopt}});
    secondsUntil(supervisor, CameraState::streaming);
    EXPECT_EQ(secondsUntil(supervisor, CameraState::lost), -1.0);
    EXPECT_FALSE(supervisor.fault());
}

TEST_F(CameraSupervisorTest, backsOffUpToABoundAndForgetsItWithAFrame) {
    missing_ = true;
    script_.steps = {Does::frame};
    CameraSupervisor supervisor = make();
    hal::DepthFrame frame;
    std::vector<double> tries;
    while (tries.size() < 10) {
        const int before = made_;
        supervisor.next(frame);
        if (made_ != before) tries.push_back(hal::seconds(clock_.now()));
    }
    for (std::size_t i = 1; i < tries.size(); ++i) {
        const double expected = std::min(0.5 * static_cast<double>(1U << (i - 1)), 30.0);
        EXPECT_NEAR(tries[i] - tries[i - 1], expected, 0.01) << i;
    }
    missing_ = false;
    secondsUntil(supervisor, CameraState::streaming);
    EXPECT_FALSE(supervisor.fault());
    // One frame is no health, and four seconds of them are.
    script_.steps = {Does::lose, Does::frame};
    secondsUntil(supervisor, CameraState::lost);
    EXPECT_GT(secondsUntil(supervisor, CameraState::streaming), 29.0);
    hal::DepthFrame last;
    for (const hal::TimePoint end = clock_.now() + std::chrono::seconds(4); clock_.now() < end;)
        supervisor.next(last);
    script_.steps = {Does::lose, Does::frame};
    secondsUntil(supervisor, CameraState::lost);
    EXPECT_NEAR(secondsUntil(supervisor, CameraState::streaming), 0.033, 0.01);
}

/// Hardware that says what it can do, and needs two calls for it.
class FakeHardware final : public RecoveryHardware {
  public:
    [[nodiscard]] bool available(RecoveryRung rung) const override { return rung == RecoveryRung::resetUsb; }
    Expected<void> perform(RecoveryRung rung) override {
        performed.push_back(rung);
        if (performed.size() % 2 == 1) return Error{.code = ErrorCode::timedOut, .cause = "still resetting"};
        return {};
    }
    bool takeArrival() override { return std::exchange(arrived, false); }
    [[nodiscard]] std::uint32_t restartsBefore() const override { return 0; }
    void healthy() override { ++health; }

    std::vector<RecoveryRung> performed;
    bool arrived = false;
    int health = 0;
};

TEST_F(CameraSupervisorTest, saysWhyWhenTheFirstFrameNeverComes) {
    script_.steps = {Does::timeOut};
    CameraSupervisor supervisor = make();
    EXPECT_NEAR(secondsUntil(supervisor, CameraState::lost), 3.0, 0.2);
    ASSERT_TRUE(supervisor.fault());
    EXPECT_NE(supervisor.fault()->cause.find("sends no frames"), std::string::npos);
}

TEST_F(CameraSupervisorTest, takesTheHardwaresRungsAndOpensANewCameraAfterThem) {
    FakeHardware hardware;
    CameraSupervisorOptions options{.hardware = &hardware};
    options.recovery.highest = RecoveryRung::powerCycle;
    options.recovery.available = [&](RecoveryRung rung) { return hardware.available(rung); };
    script_.steps = {Does::frame, Does::timeOut};
    CameraSupervisor supervisor = make(options);
    secondsUntil(supervisor, CameraState::streaming);
    const hal::TimePoint start = clock_.now();
    hal::DepthFrame frame;
    while (hardware.performed.size() < 2 && clock_.now() - start < std::chrono::minutes(5))
        supervisor.next(frame);
    ASSERT_EQ(hardware.performed, (std::vector{RecoveryRung::resetUsb, RecoveryRung::resetUsb}));
    const int before = made_;
    script_.steps = {Does::frame};
    for (int i = 0; i < 200; ++i)
        supervisor.next(frame);
    EXPECT_LE(made_ - before, 1);
    EXPECT_EQ(supervisor.state(), CameraState::streaming);
    EXPECT_GT(hardware.health, 0);
    EXPECT_EQ(supervisor.recovery().counts()[static_cast<std::size_t>(RecoveryRung::resetUsb)], 1U);
}

TEST_F(CameraSupervisorTest, opensAtOnceWhatWasPluggedIn) {
    FakeHardware hardware;
    CameraSupervisorOptions options{.hardware = &hardware};
    missing_ = true;
    script_.steps = {Does::frame};
    CameraSupervisor supervisor = make(options);
    hal::DepthFrame frame;
    while (clock_.now() < hal::TimePoint(std::chrono::minutes(2)))
        supervisor.next(frame);
    missing_ = false;
    hardware.arrived = true;
    EXPECT_LT(secondsUntil(supervisor, CameraState::streaming), 0.2);
    EXPECT_FALSE(supervisor.resumed());
}

TEST_F(CameraSupervisorTest, saysWhichFrameIsTheFirstAfterAnOutage) {
    script_.steps = {Does::frame, Does::frame, Does::lose, Does::frame, Does::frame};
    CameraSupervisor supervisor = make();
    std::string seen;
    hal::DepthFrame frame;
    while (seen.size() < 5) {
        if (supervisor.next(frame) == CameraNext::frame) seen += supervisor.resumed() ? 'r' : '.';
    }
    EXPECT_EQ(seen, "..r..");
}

TEST_F(CameraSupervisorTest, marksTheFirstFrameOfEveryOpening) {
    script_.steps = {Does::frame, Does::frame, Does::lose, Does::frame};
    CameraSupervisor supervisor = make();
    std::string restarts;
    hal::DepthFrame frame;
    while (restarts.size() < 5) {
        if (supervisor.next(frame) == CameraNext::frame) restarts += frame.restart ? 'r' : '.';
    }
    EXPECT_EQ(restarts, "r.r..");
    EXPECT_EQ(supervisor.openings(), 2U);
}

TEST_F(CameraSupervisorTest, anEndedRecordingIsNotReopenedAndNeverWaitsLong) {
    script_.steps = {Does::frame, Does::end};
    CameraSupervisor supervisor = make();
    secondsUntil(supervisor, CameraState::ended);
    hal::DepthFrame frame;
    for (int i = 0; i < 100; ++i) {
        const hal::TimePoint before = clock_.now();
        EXPECT_EQ(supervisor.next(frame), CameraNext::none);
        EXPECT_LE(clock_.now() - before, std::chrono::milliseconds(100));
    }
    EXPECT_EQ(script_.opened, 1);
    ASSERT_TRUE(supervisor.fault());
    EXPECT_NE(supervisor.fault()->cause.find("is over"), std::string::npos);
}

TEST_F(CameraSupervisorTest, aHealthyStreamTakesNoMemory) {
    script_.steps = {Does::frame};
    CameraSupervisor supervisor = make();
    hal::DepthFrame frame;
    supervisor.next(frame);
    const cheval::test::AllocationCounter counter;
    for (int i = 0; i < 100; ++i)
        supervisor.next(frame);
    EXPECT_EQ(counter.count(), 0U);
}

TEST(CameraSupervisor, stopEndsAWaitFromAnotherThread) {
    hal::SteadyClock clock;
    CameraScript script{.steps = {Does::timeOut}};
    CameraSupervisor supervisor(
        [&]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
            return std::unique_ptr<hal::DepthCamera>(std::make_unique<FakeCamera>(script, clock));
        },
        {.recovery = {.silence = std::chrono::hours(2)}, .longestWait = std::chrono::hours(1)}, clock);
    std::atomic<bool> stopped{false};
    std::thread loop([&] {
        hal::DepthFrame frame;
        while (supervisor.next(frame) != CameraNext::stopped) {
        }
        stopped = true;
    });
    supervisor.stop();
    loop.join();
    EXPECT_TRUE(stopped);
    hal::DepthFrame frame;
    EXPECT_EQ(supervisor.next(frame), CameraNext::stopped);
}

}  // namespace
}  // namespace cheval::daemon

#include "daemon/service_manager.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cheval::daemon {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr hal::Duration kWatchdog = seconds(10);

MirrorStatus wearing() {
    MirrorStatus status;
    status.state = SessionState::wearing;
    status.outfit.assign("T-shirt");
    status.camera = CameraState::streaming;
    status.turns = 1;
    status.drawTurns = 1;
    return status;
}

/// What the service manager hears, and when it loses patience.
class ServiceManagerTest : public testing::Test {
  protected:
    void send(const std::string& message) {
        messages.push_back(message);
        if (message.find("WATCHDOG=1\n") != std::string::npos) fed = clock.now();
    }
    /// Reports for this long, as often as the daemon does, with the two threads counting on where they are alive.
    /// Returns when the watchdog ends it, if it does.
    std::optional<hal::TimePoint> run(hal::Duration time, bool loopLives, bool rendererLives) {
        const hal::TimePoint end = clock.now() + time;
        while (clock.now() < end) {
            if (loopLives) status.turns += 3;
            if (rendererLives) status.drawTurns += 2;
            manager.report(status, "");
            clock.advance(manager.pause());
            if (clock.now() - fed > kWatchdog) return clock.now();
        }
        return std::nullopt;
    }

    hal::VirtualClock clock;
    hal::TimePoint fed{};
    std::vector<std::string> messages;
    MirrorStatus status = wearing();
    ServiceManager manager{clock, kWatchdog, [this](const std::string& message) { send(message); }};
};

TEST_F(ServiceManagerTest, FeedsForAsLongAsBothThreadsLive) {
    EXPECT_EQ(run(std::chrono::hours(24), true, true), std::nullopt);
}

TEST_F(ServiceManagerTest, LetsAMirrorWhoseLoopHangsBeEnded) {
    run(seconds(60), true, true);
    const hal::TimePoint hung = clock.now();
    const std::optional<hal::TimePoint> ended = run(seconds(60), false, true);
    ASSERT_TRUE(ended);
    EXPECT_LE(*ended - hung, kWatchdog + seconds(1));
}

TEST_F(ServiceManagerTest, LetsAMirrorWhoseRendererHangsBeEnded) {
    run(seconds(60), true, true);
    const hal::TimePoint hung = clock.now();
    const std::optional<hal::TimePoint> ended = run(seconds(60), true, false);
    ASSERT_TRUE(ended);
    EXPECT_LE(*ended - hung, kWatchdog + seconds(1));
}

TEST_F(ServiceManagerTest, DoesNotFeedForTheSakeOfBeingAlive) {
    run(seconds(5), true, true);
    messages.clear();
    run(seconds(5), false, false);
    for (const std::string& message : messages)
        EXPECT_THAT(message, Not(HasSubstr("WATCHDOG")));
}

TEST_F(ServiceManagerTest, FeedsAMirrorThatCountsFromZeroAgain) {
    run(seconds(60), true, true);
    status.turns = 0;
    status.drawTurns = 0;
    EXPECT_EQ(run(seconds(60), true, true), std::nullopt);
}

TEST_F(ServiceManagerTest, NeverFeedsWithoutAWatchdog) {
    ServiceManager unwatched(clock, {}, [this](const std::string& message) { send(message); });
    for (int i = 0; i < 10; ++i) {
        ++status.turns;
        ++status.drawTurns;
        unwatched.report(status, "");
        clock.advance(unwatched.pause());
    }
    EXPECT_THAT(messages, ElementsAre("READY=1\nSTATUS=wearing: T-shirt, sensor ok\n"));
}

TEST_F(ServiceManagerTest, ReportsOftenEnoughForAShortWatchdog) {
    ServiceManager hurried(clock, milliseconds(400), [](const std::string&) {});
    hurried.report(status, "");
    EXPECT_LE(hurried.pause(), milliseconds(100));
    EXPECT_EQ(manager.pause(), milliseconds(50)) << "somebody waits for READY";
    manager.report(status, "");
    EXPECT_EQ(manager.pause(), milliseconds(500));
}

TEST_F(ServiceManagerTest, IsReadyWithTheFirstPictureAndNotBefore) {
    status.drawTurns = 0;
    manager.report(status, "");
    EXPECT_THAT(messages, ElementsAre("STATUS=wearing: T-shirt, sensor ok\n"));
    status.drawTurns = 1;
    manager.report(status, "");
    ASSERT_EQ(messages.size(), 2U);
    EXPECT_THAT(messages.back(), StartsWith("READY=1\n"));
    run(seconds(60), true, true);
    int ready = 0;
    for (const std::string& message : messages)
        ready += message.find("READY=1") != std::string::npos ? 1 : 0;
    EXPECT_EQ(ready, 1);
}

TEST_F(ServiceManagerTest, SaysWhenItReloadsAndWhenThatIsOver) {
    clock.advance(milliseconds(1234));
    manager.report(status, "");
    messages.clear();
    manager.reloading();
    EXPECT_THAT(messages, ElementsAre("RELOADING=1\nMONOTONIC_USEC=1234000\nWATCHDOG_USEC=60000000\n"));
    messages.clear();
    status.drawTurns = 0;
    manager.report(status, "");
    EXPECT_THAT(messages, ElementsAre());
    status.drawTurns = 1;
    manager.report(status, "");
    EXPECT_THAT(messages, ElementsAre(StartsWith("READY=1\nWATCHDOG_USEC=10000000\n")));
    messages.clear();
    run(seconds(5), true, true);
    for (const std::string& message : messages)
        EXPECT_THAT(message, Not(HasSubstr("WATCHDOG_USEC"))) << "once";
}

TEST_F(ServiceManagerTest, NeverShortensAWatchdogNorMakesOneForAReload) {
    for (const hal::Duration limit : {hal::Duration{}, hal::Duration(std::chrono::minutes(5))}) {
        ServiceManager other(clock, limit, [this](const std::string& message) { send(message); });
        other.reloading();
        other.report(status, "");
    }
    for (const std::string& message : messages)
        EXPECT_THAT(message, Not(HasSubstr("WATCHDOG_USEC")));
}

TEST_F(ServiceManagerTest, TellsAStatusWhenItChangesAndAtMostTwiceASecond) {
    ServiceManager unwatched(clock, {}, [this](const std::string& message) { send(message); });
    unwatched.report(status, "");
    messages.clear();
    for (int i = 0; i < 100; ++i) {
        status.outfit.assign(i % 2 == 0 ? "Trousers" : "Shorts");
        clock.advance(milliseconds(40));
        unwatched.report(status, "");
    }
    EXPECT_GE(messages.size(), 3U);
    EXPECT_LE(messages.size(), 8U) << "four seconds";
    clock.advance(seconds(1));
    unwatched.report(status, "");
    const std::size_t told = messages.size();
    clock.advance(seconds(60));
    unwatched.report(status, "");
    EXPECT_EQ(messages.size(), told) << "nothing has changed";
}

TEST_F(ServiceManagerTest, SaysThatItStopsAndWhyItCannotStart) {
    manager.stopping();
    manager.failed({.code = ErrorCode::unavailable, .cause = "there is no display", .mend = "plug one in"});
    EXPECT_THAT(messages, ElementsAre("STOPPING=1\n",
                                      "STATUS=the mirror cannot be lit: there is no display. Mend: plug one in\n"));
}

TEST(ServiceStatus, SaysWhyThereAreNoFrames) {
    MirrorStatus status = wearing();
    status.state = SessionState::idle;
    status.camera = CameraState::lost;
    status.fault.assign("the sensor is unplugged");
    EXPECT_EQ(serviceStatus(status, ""), "nobody is there, sensor lost: the sensor is unplugged");
}

TEST(ServiceStatus, SaysThatThePictureIsPlainerAndWhatIsWrongWithTheSettings) {
    MirrorStatus status = wearing();
    status.degradeLevel = 2;
    status.degradeName = "half size";
    EXPECT_EQ(serviceStatus(status, "cheval.toml:3: loop.fsp: there is no such setting"),
              "wearing: T-shirt, sensor ok, plainer: half size; cheval.toml:3: loop.fsp: there is no such setting");
}

TEST(ServiceStatus, StaysOneLineWhateverATextHolds) {
    EXPECT_EQ(serviceStatus(wearing(), "bad\nREADY=1\x7f"), "wearing: T-shirt, sensor ok; bad READY=1 ");
}

}  // namespace
}  // namespace cheval::daemon

#include "daemon/host_hardware.h"

#include <atomic>
#include <csignal>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/hal/gpiod/fake_lines.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

/// The process that is under test must not be ended by what it tells itself.
class HostHardwareTest : public testing::Test {
  protected:
    void SetUp() override {
        sigset_t term;
        sigemptyset(&term);
        sigaddset(&term, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &term, &before_);
    }
    void TearDown() override {
        sigset_t term;
        sigemptyset(&term);
        sigaddset(&term, SIGTERM);
        const timespec none{};
        ended_ = sigtimedwait(&term, nullptr, &none) == SIGTERM;
        EXPECT_EQ(ended_, mustEnd_);
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    HostHardwareOptions options() {
        return {
            .resetProgram = "/nowhere/cheval-usb-reset", .runtimeFolder = folder_.path().string(), .supervised = true};
    }
    std::string counted() {
        std::ifstream file(folder_.path() / "sensor-restarts");
        std::string text;
        file >> text;
        return text;
    }

    cheval::test::TemporaryFolder folder_;
    hal::VirtualClock clock_;
    sigset_t before_{};
    bool ended_ = false;
    bool mustEnd_ = false;
};

TEST_F(HostHardwareTest, countsRestartsOverProcessesAndForgetsThemWithHealth) {
    mustEnd_ = true;
    for (std::uint32_t life = 0; life < 3; ++life) {
        HostHardware hardware(options(), clock_);
        EXPECT_EQ(hardware.restartsBefore(), life);
        EXPECT_EQ(hardware.end(), ServiceEnd::stopped);
        const Expected<void> begun = hardware.perform(RecoveryRung::restartDaemon);
        ASSERT_FALSE(begun);
        EXPECT_EQ(begun.error().code, ErrorCode::timedOut) << "it is over with the process alone";
        EXPECT_EQ(hardware.end(), ServiceEnd::restart);
        EXPECT_EQ(counted(), std::to_string(life + 1));
    }
    HostHardware hardware(options(), clock_);
    EXPECT_EQ(hardware.restartsBefore(), 3U);
    EXPECT_FALSE(rebootIsDue(options()));
    hardware.healthy();
    EXPECT_EQ(hardware.restartsBefore(), 0U);
    EXPECT_EQ(counted(), "");
}

TEST_F(HostHardwareTest, aRebootIsDueUntilTheRuntimeFolderIsGone) {
    mustEnd_ = true;
    HostHardware hardware(options(), clock_);
    EXPECT_FALSE(rebootIsDue(options()));
    ASSERT_FALSE(hardware.perform(RecoveryRung::reboot));
    EXPECT_EQ(hardware.end(), ServiceEnd::reboot);
    EXPECT_TRUE(rebootIsDue(options()));
    HostHardwareOptions alone = options();
    alone.supervised = false;
    EXPECT_FALSE(rebootIsDue(alone)) << "by hand it must start";
}

TEST_F(HostHardwareTest, withoutASensorOnTheBusNothingDearIsDone) {
    const HostHardware hardware(options(), clock_);
    for (const RecoveryRung rung :
         {RecoveryRung::resetUsb, RecoveryRung::powerCycle, RecoveryRung::restartDaemon, RecoveryRung::reboot})
        EXPECT_FALSE(hardware.available(rung)) << name(rung);
    EXPECT_TRUE(hardware.available(RecoveryRung::recycle));
}

TEST_F(HostHardwareTest, aCountThatCannotBeWrittenRestartsNothing) {
    HostHardwareOptions nowhere = options();
    nowhere.runtimeFolder = (folder_.path() / "not" / "there").string();
    HostHardware hardware(nowhere, clock_);
    const Expected<void> refused = hardware.perform(RecoveryRung::restartDaemon);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().code, ErrorCode::timedOut);
    EXPECT_EQ(hardware.end(), ServiceEnd::stopped);
}

TEST_F(HostHardwareTest, switchesTheSensorsPowerWhereALineIsWired) {
    auto chip = std::make_shared<hal::test::FakeChip>();
    HostHardwareOptions wired = options();
    wired.power = {.line = {.line = "POWER"}, .off = std::chrono::seconds(2)};
    HostHardware hardware(wired, clock_, std::make_unique<hal::test::FakeLines>(chip, clock_));
    EXPECT_TRUE(hardware.available(RecoveryRung::powerCycle));
    Expected<void> done = hardware.perform(RecoveryRung::powerCycle);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::timedOut);
    clock_.advance(std::chrono::seconds(2));
    EXPECT_TRUE(hardware.perform(RecoveryRung::powerCycle));
    EXPECT_EQ(chip->driven["POWER"].size(), 3U);
}

TEST_F(HostHardwareTest, aMissingResetProgramIsAnErrorThatNamesIt) {
    HostHardware hardware(options(), clock_);
    const Expected<void> refused = hardware.perform(RecoveryRung::resetUsb);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().file, "/nowhere/cheval-usb-reset");
}

}  // namespace
}  // namespace cheval::daemon

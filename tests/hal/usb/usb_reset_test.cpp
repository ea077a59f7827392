#include "hal/usb/usb_reset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "hal/clock.h"
#include "tests/hal/usb/mock_usb.h"

namespace cheval::hal {
namespace {

using test::MockDevice;
using test::MockReset;
using test::MockUsb;
using testing::HasSubstr;

constexpr Duration kLong = std::chrono::seconds(60);  // Reached only where the reset does not end.

UsbResetOptions options(const std::string& portPath = "", Duration limit = kLong) {
    return {.program = CHEVAL_USB_RESET, .portPath = portPath, .limit = limit};
}

class UsbResetTest : public testing::Test {
  protected:
    void TearDown() override {
        // Nobody is left behind: neither running nor unburied. One that was given up on may need a moment to be
        // scheduled.
        const SteadyClock clock;
        const TimePoint limit = clock.now() + kLong;
        while (::waitid(P_ALL, 0, nullptr, WEXITED | WNOHANG | WNOWAIT) != -1 && clock.now() < limit)
            ChildProcess::reapAbandoned();
        EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
    }

    MockUsb usb_;
    const MockDevice device_{.portPath = "1-2", .address = 5};
};

TEST_F(UsbResetTest, ResetsTheOnlySensor) {
    usb_.plugIn(device_);
    usb_.answerResets(device_, MockReset::done);
    const auto outcome = resetSensor(options());
    ASSERT_TRUE(outcome) << outcome.error().message();
    EXPECT_EQ(*outcome, UsbResetOutcome::reset);
    EXPECT_EQ(usb_.resets(), 1);
}

TEST_F(UsbResetTest, ADeviceThatComesBackAsAnotherIsASuccess) {
    usb_.plugIn(device_);
    usb_.answerResets(device_, MockReset::gone);
    const auto outcome = resetSensor(options("1-2"));
    ASSERT_TRUE(outcome) << outcome.error().message();
    EXPECT_EQ(*outcome, UsbResetOutcome::reEnumerating);
    EXPECT_EQ(usb_.resets(), 1);
}

TEST_F(UsbResetTest, ResetsTheOneAtThePortAmongSeveral) {
    const MockDevice other{.portPath = "1-3", .address = 6, .vendor = 0x2bc5, .product = 0x0601};
    usb_.plugIn(device_);
    usb_.plugIn(other);
    usb_.answerResets(other, MockReset::done);
    const auto ambiguous = resetSensor(options());
    ASSERT_FALSE(ambiguous);
    EXPECT_EQ(ambiguous.error().code, ErrorCode::invalidInput);
    EXPECT_EQ(usb_.resets(), 0);

    const auto outcome = resetSensor(options("1-3"));
    ASSERT_TRUE(outcome) << outcome.error().message();
    EXPECT_EQ(usb_.resets(), 1);
}

TEST_F(UsbResetTest, LeavesWhatIsNoSensorAlone) {
    const MockDevice mouse{.portPath = "1-2", .address = 5, .vendor = 0x046d, .product = 0xc077};
    usb_.plugIn(mouse);
    usb_.answerResets(mouse, MockReset::done);
    const auto outcome = resetSensor(options("1-2"));
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, ErrorCode::notFound);
    EXPECT_THAT(outcome.error().cause, HasSubstr("1-2"));
    EXPECT_EQ(usb_.resets(), 0);
}

TEST_F(UsbResetTest, ARefusalIsAnErrorWithAMend) {
    usb_.plugIn(device_);
    usb_.answerResets(device_, MockReset::refused);
    const auto outcome = resetSensor(options());
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, ErrorCode::unavailable);
    EXPECT_FALSE(outcome.error().mend.empty());
}

TEST_F(UsbResetTest, IsGivenUpOnWhenTheDeviceHoldsIt) {
    usb_.plugIn(device_);
    usb_.answerResets(device_, MockReset::hangs);
    Expected<UsbReset> reset = UsbReset::start(options("", kLong));
    ASSERT_TRUE(reset) << reset.error().message();
    SteadyClock clock;
    Interrupt never;
    const TimePoint limit = clock.now() + kLong;
    while (usb_.resets() == 0 && clock.now() < limit)
        clock.waitUntil(clock.now() + std::chrono::milliseconds(1), never);
    ASSERT_EQ(usb_.resets(), 1);
    // The caller is not held meanwhile.
    EXPECT_FALSE(reset->outcome().has_value());
}

TEST_F(UsbResetTest, BeyondItsLimitItHasFailed) {
    usb_.plugIn(device_);
    usb_.answerResets(device_, MockReset::hangs);
    Expected<UsbReset> reset = UsbReset::start(options("", std::chrono::milliseconds(300)));
    ASSERT_TRUE(reset) << reset.error().message();
    const auto outcome = reset->outcome(kLong);
    ASSERT_TRUE(outcome.has_value());
    ASSERT_FALSE(*outcome);
    EXPECT_EQ((*outcome).error().code, ErrorCode::timedOut);
    // Asked again, it says the same.
    const auto again = reset->outcome();
    ASSERT_TRUE(again.has_value());
    EXPECT_EQ((*again).error().code, ErrorCode::timedOut);
    // What was given up on does not stand in the way of the next.
    const auto next = resetSensor(options("1-7"));
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().code, ErrorCode::notFound);
}

TEST_F(UsbResetTest, AProgramThatIsNotThereIsAnError) {
    const auto outcome = resetSensor({.program = "no-such-folder/cheval-usb-reset"});
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, ErrorCode::notFound);
    EXPECT_EQ(outcome.error().file, "no-such-folder/cheval-usb-reset");
}

TEST_F(UsbResetTest, AProgramThatSpeaksAnotherLanguageIsAnError) {
    const auto outcome = resetSensor({.program = "/bin/false"});
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().code, ErrorCode::internal);
}

}  // namespace
}  // namespace cheval::hal

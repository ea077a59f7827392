#include "hal/usb/usb_watcher.h"

#include <cstdlib>
#include <memory>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "hal/clock.h"
#include "tests/hal/usb/mock_usb.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/temporary_folder.h"

namespace cheval::hal {
namespace {

using test::MockDevice;
using test::MockUsb;

constexpr Duration kLimit = std::chrono::seconds(30);  // Reached only where the event does not come.

class UsbWatcherTest : public testing::Test {
  protected:
    std::unique_ptr<UsbWatcher> watch() {
        Expected<std::unique_ptr<UsbWatcher>> watcher = UsbWatcher::start();
        if (watcher) return std::move(*watcher);
        ADD_FAILURE() << watcher.error().message();
        return nullptr;
    }

    // The next event, once libusb has gathered it.
    bool next(UsbWatcher& watcher, UsbEvent& event) {
        const TimePoint limit = clock_.now() + kLimit;
        while (!watcher.take(event)) {
            const Expected<void> polled = watcher.poll();
            if (!polled || clock_.now() > limit) return false;
            clock_.waitUntil(clock_.now() + std::chrono::milliseconds(1), never_);
        }
        return true;
    }

    MockUsb usb_;
    SteadyClock clock_;
    Interrupt never_;
};

TEST_F(UsbWatcherTest, ReportsASensorThatComesAndGoes) {
    const auto watcher = watch();
    ASSERT_NE(watcher, nullptr);
    const MockDevice device{.portPath = "1-2", .address = 5};
    UsbEvent event;
    for (std::uint64_t round = 1; round <= 20; ++round) {
        usb_.plugIn(device);
        ASSERT_TRUE(next(*watcher, event)) << "round " << round;
        EXPECT_EQ(event.change, UsbChange::arrived);
        EXPECT_EQ(event.sensor.vendor, 0x1d27);
        EXPECT_EQ(event.sensor.product, 0x0609);
        EXPECT_EQ(event.sensor.bus, 1);
        EXPECT_EQ(event.sensor.address, 5);
        EXPECT_EQ(event.sensor.portPath, "1-2");
        EXPECT_EQ(event.sensor.driver, "PS1080");
        usb_.pullOut(device);
        ASSERT_TRUE(next(*watcher, event)) << "round " << round;
        EXPECT_EQ(event.change, UsbChange::left);
        EXPECT_EQ(event.sensor.portPath, "1-2");
        EXPECT_EQ(watcher->counts().arrived, round);
        EXPECT_EQ(watcher->counts().left, round);
    }
    EXPECT_EQ(watcher->counts().dropped, 0U);
}

TEST_F(UsbWatcherTest, ASensorThatWasThereBeforeIsListedAndItsLeavingReported) {
    const MockDevice device{.portPath = "1-4", .address = 9, .vendor = 0x2bc5, .product = 0x0401};
    usb_.plugIn(device);
    const auto watcher = watch();
    ASSERT_NE(watcher, nullptr);
    const auto sensors = watcher->sensors();
    ASSERT_TRUE(sensors);
    ASSERT_EQ((*sensors).size(), 1U);
    EXPECT_EQ((*sensors)[0].portPath, "1-4");
    EXPECT_EQ((*sensors)[0].name, "Orbbec Astra");
    EXPECT_EQ((*sensors)[0].megabitsPerSecond, 480.0);
    UsbEvent event;
    ASSERT_TRUE(watcher->poll());
    EXPECT_FALSE(watcher->take(event));

    usb_.pullOut(device);
    ASSERT_TRUE(next(*watcher, event));
    EXPECT_EQ(event.change, UsbChange::left);
    EXPECT_EQ(event.sensor.portPath, "1-4");
    const auto none = watcher->sensors();
    ASSERT_TRUE(none);
    EXPECT_TRUE((*none).empty());
}

TEST_F(UsbWatcherTest, PassesOverWhatIsNoSensorAndNamesThePortBehindAHub) {
    usb_.plugIn({.portPath = "1-1", .address = 3, .vendor = 0x1a40, .product = 0x0101});  // A hub.
    const auto watcher = watch();
    ASSERT_NE(watcher, nullptr);
    usb_.plugIn({.portPath = "1-3", .address = 4, .vendor = 0x046d, .product = 0xc077});  // A mouse.
    usb_.plugIn({.portPath = "1-1.4", .address = 6, .vendor = 0x045e, .product = 0x02ae});
    UsbEvent event;
    ASSERT_TRUE(next(*watcher, event));
    EXPECT_EQ(event.sensor.portPath, "1-1.4");
    EXPECT_EQ(event.sensor.vendor, 0x045e);
    EXPECT_EQ(watcher->counts().arrived, 1U);
}

TEST_F(UsbWatcherTest, WhatNobodyTakesIsDroppedFromTheFrontAndCounted) {
    const auto watcher = watch();
    ASSERT_NE(watcher, nullptr);
    const MockDevice device{.portPath = "1-2", .address = 5};
    constexpr std::uint64_t kEvents = UsbWatcher::kMostWaiting + 4;
    const TimePoint limit = clock_.now() + kLimit;
    const auto seen = [&] { return watcher->counts().arrived + watcher->counts().left; };
    for (std::uint64_t i = 0; i < kEvents; ++i) {
        i % 2 == 0 ? usb_.plugIn(device) : usb_.pullOut(device);
        while (seen() == i && clock_.now() < limit) {
            ASSERT_TRUE(watcher->poll());
            clock_.waitUntil(clock_.now() + std::chrono::milliseconds(1), never_);
        }
    }
    ASSERT_EQ(seen(), kEvents);
    EXPECT_EQ(watcher->counts().dropped, 4U);
    UsbEvent event;
    for (std::size_t i = 0; i < UsbWatcher::kMostWaiting; ++i) {
        ASSERT_TRUE(watcher->take(event));
        EXPECT_EQ(event.change, i % 2 == 0 ? UsbChange::arrived : UsbChange::left) << i;
    }
    EXPECT_FALSE(watcher->take(event));
}

TEST_F(UsbWatcherTest, TakesNoMemoryWhileNothingHappens) {
    usb_.plugIn({});
    const auto watcher = watch();
    ASSERT_NE(watcher, nullptr);
    ASSERT_TRUE(watcher->poll());  // The first may still prepare itself.
    UsbEvent event;
    const test::AllocationCounter counter;
    for (int i = 0; i < 1000; ++i) {
        (void)watcher->poll();
        EXPECT_FALSE(watcher->take(event));
    }
    EXPECT_EQ(counter.count(), 0U);
}

TEST_F(UsbWatcherTest, CanBeStartedAgain) {
    for (int round = 0; round < 3; ++round) {
        const auto watcher = watch();
        ASSERT_NE(watcher, nullptr);
        const MockDevice device{.portPath = "1-2", .address = 5 + round};
        usb_.plugIn(device);
        UsbEvent event;
        ASSERT_TRUE(next(*watcher, event));
        EXPECT_EQ(event.sensor.address, 5 + round);
        usb_.pullOut(device);
        ASSERT_TRUE(next(*watcher, event));
    }
}

// Where the program sees an empty folder in place of the machine's: no sysfs and no device nodes.
class UsbWatcherWithoutUsb : public testing::Test {
  protected:
    void SetUp() override { ASSERT_EQ(::setenv("UMOCKDEV_DIR", nothing_.path().c_str(), 1), 0); }
    void TearDown() override { ::unsetenv("UMOCKDEV_DIR"); }

    const test::TemporaryFolder nothing_;
};

TEST_F(UsbWatcherWithoutUsb, SeesNoSensorAndGoesOn) {
    const auto watcher = UsbWatcher::start();
    ASSERT_TRUE(watcher) << watcher.error().message();
    EXPECT_TRUE((*watcher)->poll());
    const auto sensors = (*watcher)->sensors();
    ASSERT_TRUE(sensors);
    EXPECT_TRUE((*sensors).empty());
    UsbEvent event;
    EXPECT_FALSE((*watcher)->take(event));
}

TEST_F(UsbWatcherWithoutUsb, WhereUdevCannotBeHeardTheErrorSaysWhatToDo) {
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    rlimit none = before;
    none.rlim_cur = 3;
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
    const auto watcher = UsbWatcher::start();
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
    ASSERT_FALSE(watcher);
    EXPECT_FALSE(watcher.error().cause.empty());
    EXPECT_FALSE(watcher.error().mend.empty());
}

}  // namespace
}  // namespace cheval::hal

#include <algorithm>
#include <array>
#include <cstring>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "hal/sim/world.h"
#include "tests/sim/sim_fixtures.h"
#include "tests/support/allocation_counter.h"

namespace cheval::hal::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kPeriod = fromSeconds(1.0 / 30.0);

class SimulatedCameraTest : public testing::Test {
  protected:
    std::shared_ptr<World> world_ = makeWorld(WorldOptions{});
    VirtualClock clock_;
    std::unique_ptr<DepthCamera> camera_ = makeSimulatedCamera(world_, clock_);
    DepthFrame frame_;
};

TEST_F(SimulatedCameraTest, DeliversEveryFrameOnTimeOnAVirtualClock) {
    ASSERT_TRUE(camera_->open());
    EXPECT_TRUE(camera_->info().colour);
    EXPECT_TRUE(camera_->info().mount.known);
    for (std::uint64_t n = 0; n < 40; ++n) {
        ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
        EXPECT_EQ(frame_.sequence, n);
        EXPECT_EQ(frame_.sourceIndex, n);
        EXPECT_EQ(frame_.restart, n == 0);
        EXPECT_EQ(frame_.captureTime, TimePoint(fromSeconds(world_->timeOf(n))));
        EXPECT_GE(clock_.now(), frame_.captureTime);
        EXPECT_EQ(frame_.depth.width, 640);
        EXPECT_EQ(frame_.colour.height, 480);
        // A slow caller on a clock that only moves with it.
        clock_.advance(milliseconds(50));
    }
}

TEST_F(SimulatedCameraTest, DeliversWhatRenderFrameRenders) {
    ASSERT_TRUE(camera_->open());
    for (int n = 0; n <= 70; ++n)
        ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    Image<std::uint16_t> depth;
    Image<Rgb8> colour;
    renderFrame(*world_, 70, depth, colour);
    EXPECT_EQ(std::memcmp(depth.pixels.data(), frame_.depth.data, depth.pixels.size() * sizeof(std::uint16_t)), 0);
    EXPECT_EQ(std::memcmp(colour.pixels.data(), frame_.colour.data, colour.pixels.size() * sizeof(Rgb8)), 0);
}

TEST_F(SimulatedCameraTest, TimesOutWhenTheNextFrameIsNotYetDue) {
    ASSERT_TRUE(camera_->open());
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    EXPECT_EQ(camera_->waitFrame(milliseconds(5), frame_), FrameStatus::timedOut);
    EXPECT_EQ(clock_.now(), TimePoint(milliseconds(5)));
    EXPECT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    EXPECT_EQ(frame_.sequence, 1U);
}

TEST_F(SimulatedCameraTest, GoesOnAtTheWorldsTimeWhenReopened) {
    ASSERT_TRUE(camera_->open());
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    camera_->close();
    clock_.advance(seconds(3600));
    ASSERT_TRUE(camera_->open());
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    EXPECT_EQ(frame_.sequence, 3600U * 30U);
    EXPECT_TRUE(frame_.restart);
}

TEST_F(SimulatedCameraTest, NeverRepeatsAFrameWhenReopenedAtOnce) {
    std::uint64_t last = 0;
    for (int i = 0; i < 100; ++i) {
        ASSERT_TRUE(camera_->open());
        ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
        if (i > 0) {
            EXPECT_GT(frame_.sequence, last);
        }
        last = frame_.sequence;
        camera_->close();
    }
}

TEST_F(SimulatedCameraTest, IsLostUntilTheFaultEnds) {
    ASSERT_TRUE(camera_->open());
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    world_->setFault(CameraFault::lost);
    EXPECT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::lost);
    camera_->close();
    const Expected<void> refused = camera_->open();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
    EXPECT_FALSE(refused.error().mend.empty());
    world_->setFault(CameraFault::none);
    ASSERT_TRUE(camera_->open());
    EXPECT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    EXPECT_TRUE(frame_.restart);
}

TEST_F(SimulatedCameraTest, TimesOutWhileStalledAndSkipsWhatWasNotSent) {
    ASSERT_TRUE(camera_->open());
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    world_->setFault(CameraFault::stalled);
    for (int i = 0; i < 3; ++i) {
        const TimePoint before = clock_.now();
        EXPECT_EQ(camera_->waitFrame(milliseconds(200), frame_), FrameStatus::timedOut);
        EXPECT_EQ(clock_.now() - before, milliseconds(200));
    }
    world_->setFault(CameraFault::none);
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    EXPECT_EQ(frame_.sequence, 18U);
}

TEST_F(SimulatedCameraTest, SendsNoiseWhenAskedForGarbage) {
    ASSERT_TRUE(camera_->open());
    world_->setFault(CameraFault::garbage);
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    std::size_t far = 0;
    for (int x = 0; x < 640; ++x)
        far += frame_.depth.at(x, 100) > 6000 ? 1U : 0U;
    EXPECT_GT(far, 500U);
    world_->setFault(CameraFault::none);
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    for (int x = 0; x < 640; ++x)
        ASSERT_LE(frame_.depth.at(x, 100), 6000);
}

TEST_F(SimulatedCameraTest, SendsLateFramesWithTheTimeOfTheirCapture) {
    ASSERT_TRUE(camera_->open());
    world_->setLateness(milliseconds(80));
    world_->setFault(CameraFault::late);
    for (std::uint64_t n = 0; n < 5; ++n) {
        ASSERT_EQ(camera_->waitFrame(milliseconds(200), frame_), FrameStatus::frame);
        EXPECT_EQ(clock_.now() - frame_.captureTime, milliseconds(80));
    }
}

TEST_F(SimulatedCameraTest, TakesNoMemoryPerFrame) {
    ASSERT_TRUE(camera_->open());
    ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    const cheval::test::AllocationCounter counter;
    for (int n = 0; n < 60; ++n)
        ASSERT_EQ(camera_->waitFrame(milliseconds(100), frame_), FrameStatus::frame);
    EXPECT_EQ(counter.count(), 0U);
}

/// A clock that runs by itself: every look at it finds it later.
class RunningClock final : public Clock {
  public:
    [[nodiscard]] TimePoint now() const override { return now_; }
    bool waitUntil(TimePoint deadline, Interrupt& interrupt) override {
        if (interrupt.raised()) return false;
        now_ = std::max(now_, deadline);
        return true;
    }
    void run(Duration duration) { now_ += duration; }

  private:
    TimePoint now_{};
};

TEST(SimulatedCameraOnARunningClock, SkipsFramesForALateCaller) {
    const std::shared_ptr<World> world = makeWorld(WorldOptions{});
    RunningClock clock;
    const std::unique_ptr<DepthCamera> camera = makeSimulatedCamera(world, clock);
    DepthFrame frame;
    ASSERT_TRUE(camera->open());
    ASSERT_EQ(camera->waitFrame(milliseconds(100), frame), FrameStatus::frame);
    clock.run(10 * kPeriod + milliseconds(1));
    ASSERT_EQ(camera->waitFrame(milliseconds(100), frame), FrameStatus::frame);
    EXPECT_EQ(frame.sequence, 10U);
    ASSERT_EQ(camera->waitFrame(milliseconds(100), frame), FrameStatus::frame);
    EXPECT_EQ(frame.sequence, 11U);
}

TEST(SimulatedCameraOnARunningClock, EndsAWaitWhenClosedByAnotherThread) {
    const std::shared_ptr<World> world = makeWorld(WorldOptions{});
    SteadyClock clock;
    const std::unique_ptr<DepthCamera> camera = makeSimulatedCamera(world, clock);
    ASSERT_TRUE(camera->open());
    world->setFault(CameraFault::stalled);
    FrameStatus status = FrameStatus::frame;
    std::thread waiter([&] {
        DepthFrame frame;
        status = camera->waitFrame(std::chrono::hours(1), frame);
    });
    camera->close();
    waiter.join();
    EXPECT_EQ(status, FrameStatus::closed);
}

class SimulatedButtonsTest : public testing::Test {
  protected:
    std::shared_ptr<World> world_ = makeWorld(WorldOptions{});
    VirtualClock clock_;
    std::unique_ptr<Buttons> buttons_ = makeSimulatedButtons(world_, clock_);
    std::array<ButtonEvent, 100> events_;
};

TEST_F(SimulatedButtonsTest, PressesNextTwiceAVisitWhileTheShopperIsThere) {
    std::vector<ButtonEvent> presses;
    for (int step = 0; step < 480; ++step) {
        const Expected<std::size_t> count = buttons_->poll(events_);
        ASSERT_TRUE(count);
        for (std::size_t i = 0; i < *count; ++i) {
            EXPECT_EQ(events_[i].button, Button::next);
            if (events_[i].action == ButtonAction::pressed) presses.push_back(events_[i]);
        }
        clock_.advance(milliseconds(100));
    }
    ASSERT_EQ(presses.size(), 4U);
    for (const ButtonEvent& press : presses) {
        EXPECT_TRUE(truthAt(*world_, hal::seconds(press.time)).present);
    }
}

TEST_F(SimulatedButtonsTest, DeliversWhatDoesNotFitWithTheNextCall) {
    ASSERT_TRUE(buttons_->poll(events_));
    clock_.advance(seconds(48));
    EXPECT_EQ(*buttons_->poll(std::span(events_).first(3)), 3U);
    EXPECT_EQ(*buttons_->poll(events_), 5U);
    EXPECT_EQ(buttons_->dropped(), 0U);
}

TEST_F(SimulatedButtonsTest, DropsTheOldestBeyondSixtyFour) {
    ASSERT_TRUE(buttons_->poll(events_));
    clock_.advance(seconds(24 * 20));
    EXPECT_EQ(*buttons_->poll(events_), 64U);
    EXPECT_EQ(buttons_->dropped(), 16U);
    EXPECT_GT(events_[0].time, TimePoint(seconds(24 * 4)));
}

}  // namespace
}  // namespace cheval::hal::sim

// What every display does, whatever it is.
#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "hal/headless/headless_display.h"
#include "hal/preview/preview_server.h"
#include "tests/conformance/process_use.h"
#include "tests/hal/replay/recording_folder.h"

namespace cheval::test {
namespace {

using hal::Display;
using hal::DisplayBuffer;
using hal::DisplayMode;
using hal::Duration;
using hal::Rgba8;
using hal::TimePoint;

constexpr DisplayMode kMode{.width = 27, .height = 48, .refreshHz = 30};

// A display and whatever it lives on.
class DisplayRig {
  public:
    virtual ~DisplayRig() = default;
    DisplayRig(const DisplayRig&) = delete;
    DisplayRig& operator=(const DisplayRig&) = delete;
    virtual Display* display() = 0;

  protected:
    DisplayRig() = default;
};

class HeadlessRig final : public DisplayRig {
  public:
    explicit HeadlessRig(bool writes)
        : display_(hal::makeHeadlessDisplay(
              {.mode = kMode, .folder = writes ? folder_.path("pictures") : "", .every = 50})) {}
    Display* display() override { return display_.get(); }

  private:
    RecordingFolder folder_;
    std::unique_ptr<Display> display_;
};

class PreviewRig final : public DisplayRig {
  public:
    PreviewRig() {
        auto started = hal::startPreview({.mode = kMode, .port = 0}, clock_);
        if (started) server_ = std::move(*started);
    }
    Display* display() override { return server_ ? &server_->display() : nullptr; }

  private:
    hal::VirtualClock clock_;
    std::unique_ptr<hal::PreviewServer> server_;
};

struct DisplayBackEnd {
    std::string name;
    std::function<std::unique_ptr<DisplayRig>()> rig;
};

void PrintTo(const DisplayBackEnd& backEnd, std::ostream* out) {  // NOLINT(readability-identifier-naming)
    *out << backEnd.name;
}

class DisplayConformanceTest : public testing::TestWithParam<DisplayBackEnd> {
  protected:
    void SetUp() override {
        rig_ = GetParam().rig();
        display_ = rig_->display();
        ASSERT_NE(display_, nullptr);
    }

    Expected<void> show() {
        auto buffer = display_->lend(Duration::zero());
        if (!buffer) return buffer.error();
        for (int y = 0; y < buffer->pixels.height; ++y) {
            std::fill_n(buffer->pixels.row(y), buffer->pixels.width, Rgba8{1, 2, 3, 255});
        }
        return display_->present(*buffer, TimePoint{});
    }

    std::unique_ptr<DisplayRig> rig_;
    Display* display_ = nullptr;
};

TEST_P(DisplayConformanceTest, LendsBuffersOfItsMode) {
    const auto mode = display_->open();
    ASSERT_TRUE(mode);
    EXPECT_EQ(mode->width, kMode.width);
    EXPECT_EQ(mode->height, kMode.height);
    EXPECT_GT(mode->refreshHz, 0.0);
    const auto buffer = display_->lend(Duration::zero());
    ASSERT_TRUE(buffer);
    EXPECT_EQ(buffer->pixels.width, kMode.width);
    EXPECT_EQ(buffer->pixels.height, kMode.height);
    EXPECT_GE(buffer->pixels.stride, kMode.width);
}

TEST_P(DisplayConformanceTest, CountsWhatIsPresentedWhetherOrNotAnybodyLooks) {
    ASSERT_TRUE(display_->open());
    for (int i = 0; i < 200; ++i)
        ASSERT_TRUE(show());
    EXPECT_EQ(display_->statistics().presented, 200U);
    EXPECT_LE(display_->statistics().dropped, 200U);
    EXPECT_TRUE(display_->statistics().connected);
}

TEST_P(DisplayConformanceTest, LendsOneBufferAtATime) {
    ASSERT_TRUE(display_->open());
    const auto first = display_->lend(Duration::zero());
    ASSERT_TRUE(first);
    EXPECT_FALSE(display_->lend(Duration::zero()));
    EXPECT_TRUE(display_->present(*first, TimePoint{}));
    EXPECT_TRUE(display_->lend(Duration::zero()));
}

TEST_P(DisplayConformanceTest, RefusesWhatIsNotOnLoan) {
    ASSERT_TRUE(display_->open());
    EXPECT_FALSE(display_->present(DisplayBuffer{}, TimePoint{}));
    const auto buffer = display_->lend(Duration::zero());
    ASSERT_TRUE(buffer);
    DisplayBuffer unknown = *buffer;
    unknown.slot += 1000;
    const auto refused = display_->present(unknown, TimePoint{});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::invalidInput);
    EXPECT_TRUE(display_->present(*buffer, TimePoint{}));
    EXPECT_FALSE(display_->present(*buffer, TimePoint{}));
    EXPECT_EQ(display_->statistics().presented, 1U);
}

TEST_P(DisplayConformanceTest, ALoanEndsWhenTheDisplayIsClosed) {
    ASSERT_TRUE(display_->open());
    const auto before = display_->lend(Duration::zero());
    ASSERT_TRUE(before);
    display_->close();
    EXPECT_FALSE(display_->present(*before, TimePoint{}));
    ASSERT_TRUE(display_->open());
    EXPECT_FALSE(display_->present(*before, TimePoint{}));
    const auto after = display_->lend(Duration::zero());
    ASSERT_TRUE(after);
    EXPECT_FALSE(display_->present(*before, TimePoint{}));
    EXPECT_TRUE(display_->present(*after, TimePoint{}));
}

TEST_P(DisplayConformanceTest, AClosedDisplayLendsNothing) {
    EXPECT_FALSE(display_->lend(Duration::zero()));
    display_->close();
    ASSERT_TRUE(display_->open());
    display_->close();
    display_->close();
    EXPECT_FALSE(display_->lend(Duration::zero()));
    EXPECT_FALSE(display_->statistics().connected);
}

TEST_P(DisplayConformanceTest, OpeningAnOpenDisplayIsAnErrorAndHarmless) {
    ASSERT_TRUE(display_->open());
    EXPECT_FALSE(display_->open());
    EXPECT_TRUE(show());
}

TEST_P(DisplayConformanceTest, StatisticsMayBeReadByAnotherThread) {
    ASSERT_TRUE(display_->open());
    std::atomic<bool> done{false};
    std::atomic<bool> backwards{false};
    std::thread reader([&] {
        std::uint64_t last = 0;
        while (!done) {
            const auto statistics = display_->statistics();
            if (statistics.presented < last) backwards = true;
            last = statistics.presented;
        }
    });
    for (int i = 0; i < 500; ++i)
        EXPECT_TRUE(show());
    done = true;
    reader.join();
    EXPECT_FALSE(backwards);
}

TEST_P(DisplayConformanceTest, OpensAHundredTimesWithoutGrowthAndCountsAnew) {
    const auto use = [&] {
        ASSERT_TRUE(display_->open());
        EXPECT_EQ(display_->statistics().presented, 0U);
        EXPECT_TRUE(show());
        EXPECT_TRUE(show());
        EXPECT_EQ(display_->statistics().presented, 2U);
        display_->close();
    };
    for (int i = 0; i < 3; ++i)
        use();
    // A server's own threads may still be starting: they are counted when there have been as many for a while.
    hal::SteadyClock clock;
    hal::Interrupt never;
    std::ptrdiff_t threads = 0;
    for (int i = 0; i < 50 && threads != ProcessUse().threads; ++i) {
        threads = ProcessUse().threads;
        clock.waitUntil(clock.now() + std::chrono::milliseconds(200), never);
    }
    const ProcessUse before;
    for (int i = 0; i < 100; ++i)
        use();
    const ProcessUse after;
    EXPECT_EQ(after.descriptors, before.descriptors);
    EXPECT_EQ(after.threads, before.threads);
    EXPECT_LE(after.heapBytes, before.heapBytes + kHeapSlack);
}

INSTANTIATE_TEST_SUITE_P(
    All, DisplayConformanceTest,
    testing::Values(DisplayBackEnd{"headless", [] { return std::make_unique<HeadlessRig>(false); }},
                    DisplayBackEnd{"headlessWithFiles", [] { return std::make_unique<HeadlessRig>(true); }},
                    DisplayBackEnd{"preview", [] { return std::make_unique<PreviewRig>(); }}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cheval::test

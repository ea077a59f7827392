// What all buttons do, whatever they are.
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <httplib.h>
#undef _res  // A macro of resolv.h, and a name in Eigen.

#include "hal/gpiod/gpiod_buttons.h"
#include "hal/preview/preview_server.h"
#include "hal/sim/world.h"
#include "tests/hal/gpiod/fake_lines.h"

namespace cheval::test {
namespace {

using hal::ButtonEvent;
using hal::Buttons;

constexpr std::size_t kBound = 64;  // As hal/buttons.h says.

class ButtonsRig {
  public:
    virtual ~ButtonsRig() = default;
    ButtonsRig(const ButtonsRig&) = delete;
    ButtonsRig& operator=(const ButtonsRig&) = delete;
    virtual Buttons* buttons() = 0;
    /// Makes at least `count` events happen and returns how many.
    virtual std::size_t happen(std::size_t count) = 0;

  protected:
    ButtonsRig() = default;
};

// Pressed as a browser presses them.
class PreviewRig final : public ButtonsRig {
  public:
    PreviewRig() {
        auto started = hal::startPreview({.mode = {.width = 8, .height = 8}, .port = 0}, clock_);
        if (started) server_ = std::move(*started);
    }
    Buttons* buttons() override { return server_ ? &server_->buttons() : nullptr; }
    std::size_t happen(std::size_t count) override {
        const std::string address = server_->address();
        std::size_t pressed = 0;
        for (std::size_t i = 0; i < count; ++i) {
            clock_.advance(std::chrono::milliseconds(10));
            const auto answer = httplib::Client(address.substr(0, address.size() - 1)).Post("/button/next");
            pressed += answer && answer->status == 204 ? 1U : 0U;
        }
        return pressed;
    }

  private:
    hal::VirtualClock clock_;
    std::unique_ptr<hal::PreviewServer> server_;
};

// Pressed by the script, so that making events happen means letting visits pass.
class SimulatedRig final : public ButtonsRig {
  public:
    SimulatedRig() {
        std::array<ButtonEvent, kBound> events;
        hal::VirtualClock clock;
        const auto probe = hal::sim::makeSimulatedButtons(hal::sim::makeWorld(options_), clock);
        if (!probe->poll(events)) return;
        clock.advance(visit());
        perVisit_ = *probe->poll(events);
        static_cast<void>(buttons_->poll(std::span<ButtonEvent>{}));
    }
    Buttons* buttons() override { return buttons_.get(); }
    std::size_t happen(std::size_t count) override {
        std::size_t happened = 0;
        for (; perVisit_ > 0 && happened < count; happened += perVisit_)
            clock_.advance(visit());
        return happened;
    }

  private:
    [[nodiscard]] hal::Duration visit() const {
        return hal::fromSeconds(options_.visitSeconds + options_.pauseSeconds);
    }

    hal::sim::WorldOptions options_;
    hal::VirtualClock clock_;
    std::unique_ptr<Buttons> buttons_ = hal::sim::makeSimulatedButtons(hal::sim::makeWorld(options_), clock_);
    std::size_t perVisit_ = 0;
};

// Pressed by edges on lines of a chip that is not there.
class GpiodRig final : public ButtonsRig {
  public:
    GpiodRig() { static_cast<void>(buttons_->poll(std::span<ButtonEvent>{})); }
    Buttons* buttons() override { return buttons_.get(); }
    std::size_t happen(std::size_t count) override {
        // Each a press or a release, held for longer than bounce.
        for (std::size_t i = 0; i < count; ++i) {
            clock_.advance(std::chrono::milliseconds(30));
            level_ = !level_;
            chip_->edge("NEXT", level_, clock_.now());
        }
        clock_.advance(std::chrono::milliseconds(30));
        return count;
    }

  private:
    hal::VirtualClock clock_;
    std::shared_ptr<hal::test::FakeChip> chip_ = std::make_shared<hal::test::FakeChip>();
    bool level_ = false;
    std::unique_ptr<Buttons> buttons_ =
        hal::makeGpiodButtons({.wirings = {{.button = hal::Button::next, .line = {.line = "NEXT"}}}},
                              std::make_unique<hal::test::FakeLines>(chip_, clock_), clock_);
};

struct ButtonsBackEnd {
    std::string name;
    std::function<std::unique_ptr<ButtonsRig>()> rig;
};

void PrintTo(const ButtonsBackEnd& backEnd, std::ostream* out) {  // NOLINT(readability-identifier-naming)
    *out << backEnd.name;
}

class ButtonsConformanceTest : public testing::TestWithParam<ButtonsBackEnd> {
  protected:
    void SetUp() override {
        rig_ = GetParam().rig();
        buttons_ = rig_->buttons();
        ASSERT_NE(buttons_, nullptr);
    }

    std::vector<ButtonEvent> poll(std::size_t atATime) {
        std::vector<ButtonEvent> all;
        std::vector<ButtonEvent> some(atATime);
        for (auto got = buttons_->poll(some); got && *got > 0; got = buttons_->poll(some)) {
            EXPECT_LE(*got, atATime);
            all.insert(all.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(*got));
        }
        return all;
    }

    static void expectInOrder(const std::vector<ButtonEvent>& events) {
        for (std::size_t i = 1; i < events.size(); ++i)
            EXPECT_LT(events[i - 1].time, events[i].time) << "event " << i;
    }

    std::unique_ptr<ButtonsRig> rig_;
    Buttons* buttons_ = nullptr;
};

TEST_P(ButtonsConformanceTest, NothingPressedIsNothing) {
    std::array<ButtonEvent, 4> events;
    const auto got = buttons_->poll(events);
    ASSERT_TRUE(got);
    EXPECT_EQ(*got, 0U);
    EXPECT_EQ(buttons_->dropped(), 0U);
}

TEST_P(ButtonsConformanceTest, EventsComeOldestFirstEachOnce) {
    const std::size_t happened = rig_->happen(12);
    ASSERT_GE(happened, 12U);
    const auto events = poll(5);
    EXPECT_EQ(events.size(), happened);
    expectInOrder(events);
    EXPECT_EQ(buttons_->dropped(), 0U);
}

TEST_P(ButtonsConformanceTest, WhatDoesNotFitIsDeliveredByTheNextCall) {
    const std::size_t happened = rig_->happen(3);
    EXPECT_EQ(*buttons_->poll(std::span<ButtonEvent>{}), 0U);
    EXPECT_EQ(poll(1).size(), happened);
}

TEST_P(ButtonsConformanceTest, NoMoreThanTheBoundWaitsAndTheNewestStay) {
    const std::size_t happened = rig_->happen(kBound + 20);
    const auto events = poll(2 * kBound);
    ASSERT_EQ(events.size(), kBound);
    expectInOrder(events);
    EXPECT_EQ(buttons_->dropped(), happened - kBound);
    const std::size_t later = rig_->happen(1);
    const auto newer = poll(2 * kBound);
    ASSERT_EQ(newer.size(), later);
    EXPECT_GT(newer.front().time, events.back().time);
    EXPECT_EQ(buttons_->dropped(), happened - kBound);
}

INSTANTIATE_TEST_SUITE_P(All, ButtonsConformanceTest,
                         testing::Values(ButtonsBackEnd{"preview", [] { return std::make_unique<PreviewRig>(); }},
                                         ButtonsBackEnd{"gpiod", [] { return std::make_unique<GpiodRig>(); }},
                                         ButtonsBackEnd{"simulated", [] { return std::make_unique<SimulatedRig>(); }}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cheval::test

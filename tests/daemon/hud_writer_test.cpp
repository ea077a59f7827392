#include "daemon/hud_writer.h"

#include <array>
#include <chrono>
#include <span>
#include <string>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::daemon {
namespace {

using fitting::Dimension;

/// Somebody who is dressed, measured and advised.
class HudWriterTest : public testing::Test {
  protected:
    HudWriterTest() {
        advice_ = {.certainty = fitting::AdviceCertainty::certain,
                   .reason = fitting::AdviceReason::none,
                   .size = fitting::SizeName("M")};
        measurements_[Dimension::stature] = {.value = 1.724F, .uncertainty = 0.006F, .valid = true};
        measurements_[Dimension::chestGirth] = {.value = 0.9424F, .uncertainty = 0.0118F, .valid = true};
        measurements_[Dimension::hipGirth] = {.value = 1.02F, .uncertainty = 0.01F, .valid = false};
        for (int i = 0; i < 60 && !session_.dressed(); ++i)
            step();
        EXPECT_TRUE(session_.dressed());
    }
    void step(std::span<const hal::ButtonEvent> buttons = {}, std::uint32_t user = 1) {
        time_ += std::chrono::milliseconds(33);
        session_.update({.time = time_, .userId = user, .jointsSeen = true, .measured = true, .buttons = buttons});
    }
    void openService() {
        const std::array press = {
            hal::ButtonEvent{.button = hal::Button::service, .action = hal::ButtonAction::pressed}};
        step(press);
        ASSERT_TRUE(session_.serviceScreen());
    }
    const render::HudState& write(std::string_view notice = {}) {
        writeHud({.session = &session_,
                  .wardrobe = &wardrobe_,
                  .advice = &advice_,
                  .measurements = &measurements_,
                  .notice = notice},
                 hud_);
        return hud_;
    }
    static std::string everything(const render::HudState& hud) {
        return std::string(hud.prompt.view()) + "\n" + std::string(hud.advice.view()) + "\n" +
               std::string(hud.service.view());
    }

    Wardrobe wardrobe_;
    Session session_{SessionOptions{.outfitCount = 1}};
    fitting::SizeAdvice advice_;
    fitting::Measurements measurements_;
    render::HudState hud_;
    hal::TimePoint time_{};
};

TEST_F(HudWriterTest, tellsTheSizeOfWhoIsDressed) {
    EXPECT_EQ(write().advice.view(), "Your size: M");
    for (int i = 0; i < 60; ++i)
        step({}, 0);
    ASSERT_FALSE(session_.dressed());
    EXPECT_EQ(write().advice.view(), "");
}

TEST_F(HudWriterTest, tellsLengthsAndGirthsOnTheServiceScreenAlone) {
    EXPECT_THAT(everything(write("a garment is refused")),
                testing::Not(testing::ContainsRegex("94|172|girth|stature|cm")));
    openService();
    EXPECT_EQ(write().service.view(), "All is well.\nstature 172.4 ± 0.6 cm, chest girth 94.2 ± 1.2 cm");
    EXPECT_EQ(write("a garment is refused").service.view(),
              "a garment is refused\nstature 172.4 ± 0.6 cm, chest girth 94.2 ± 1.2 cm");
    measurements_ = {};
    EXPECT_EQ(write().service.view(), "All is well.");
}

TEST_F(HudWriterTest, cutsWhatIsTooLongAndTakesNoHeapMemory) {
    openService();
    for (fitting::Measurement& measurement : measurements_.dimensions)
        measurement = {.value = 1e30F, .uncertainty = 1e30F, .valid = true};
    const std::string notice(600, 'x');
    const test::AllocationCounter counter;
    write(notice);
    EXPECT_EQ(counter.count(), 0U);
    EXPECT_LE(hud_.service.length, hud_.service.bytes.size());
}

}  // namespace
}  // namespace cheval::daemon

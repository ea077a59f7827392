#include "daemon/mirror.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/settings_table.h"
#include "daemon/hud_writer.h"
#include "daemon/room_options.h"
#include "hal/headless/headless_display.h"
#include "hal/sim/world.h"
#include "tests/daemon/fake_camera.h"
#include "tests/support/allocation_counter.h"

namespace cheval::daemon {
namespace {

using test::CameraScript;
using test::Does;
using test::FakeCamera;

/// Small pictures: what is tested here is not their beauty.
config::Settings smallSettings() {
    config::Settings settings = config::defaultSettings();
    settings.display.width = 270;
    settings.display.height = 480;
    settings.wardrobe.folder = CHEVAL_ASSETS;
    return settings;
}

/// Buttons that a test presses.
class TestButtons final : public hal::Buttons {
  public:
    void press(hal::Button button) {
        waiting_ = {.button = button, .action = hal::ButtonAction::pressed};
        full_ = true;
    }
    void setBroken(bool broken) { broken_ = broken; }

  protected:
    Expected<std::size_t> doPoll(std::span<hal::ButtonEvent> events) override {
        // As GPIO buttons do: what was pressed is told before what is wrong.
        if (full_ && !events.empty()) {
            events[0] = waiting_;
            full_ = false;
            return std::size_t{1};
        }
        if (broken_) return Error{.code = ErrorCode::unavailable, .cause = "the chip is gone", .mend = "plug it in"};
        return std::size_t{0};
    }

  private:
    hal::ButtonEvent waiting_;
    bool full_ = false;
    bool broken_ = false;
};

/// A mirror in one thread, on virtual time.
class MirrorTest : public testing::Test {
  public:
    ~MirrorTest() override {
        mirror_.reset();
        display_->close();
    }

  protected:
    explicit MirrorTest(config::Settings settings = smallSettings())
        : settings_(std::move(settings)), display_(hal::makeHeadlessDisplay({.mode = displayMode(settings_)})) {
        EXPECT_TRUE(display_->open());
    }

    Mirror& light(CameraFactory camera) {
        wardrobe_ = loadWardrobe(wardrobeOptions(settings_));
        Expected<std::unique_ptr<Mirror>> made =
            Mirror::create(settings_, {.camera = std::move(camera),
                                       .buttons = {&buttons_},
                                       .commands = &commands_,
                                       .display = display_.get(),
                                       .mode = displayMode(settings_),
                                       .clock = &clock_,
                                       .admission = &still_,
                                       .cost = &steady_,
                                       .wardrobe = &wardrobe_,
                                       .observer = [this](const FramePacket& packet, hal::ImageView<const hal::Rgba8>) {
                                           screens_.push_back(packet.hud.screen);
                                           service_ = packet.hud.service.view();
                                           prompt_ = packet.hud.prompt.view();
                                           advice_ = packet.hud.advice.view();
                                       }});
        EXPECT_TRUE(made);
        mirror_ = std::move(*made);
        return *mirror_;
    }
    Mirror& lightSimulation() {
        return light([this]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
            return hal::sim::makeSimulatedCamera(hal::sim::makeWorld(worldOptions(settings_)), clock_);
        });
    }
    Mirror& lightScript() {
        return light([this]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
            return std::unique_ptr<hal::DepthCamera>(std::make_unique<FakeCamera>(script_, clock_));
        });
    }
    static bool never(const hal::DepthFrame&) { return false; }

    config::Settings settings_;
    hal::VirtualClock clock_;
    hal::VirtualClock still_;
    hal::SteadyClock steady_;
    std::unique_ptr<hal::Display> display_;
    TestButtons buttons_;
    RemoteCommands commands_;
    Wardrobe wardrobe_;
    CameraScript script_;
    std::unique_ptr<Mirror> mirror_;
    std::vector<render::Screen> screens_;
    std::string service_;
    std::string prompt_;
    std::string advice_;
};

TEST_F(MirrorTest, dressesTheSimulatedShopperAndChangesOnAButton) {
    Mirror& mirror = lightSimulation();
    while (mirror.status().state != SessionState::wearing && hal::seconds(clock_.now()) < 10.0)
        ASSERT_TRUE(mirror.step(never));
    ASSERT_EQ(mirror.status().state, SessionState::wearing);
    EXPECT_EQ(mirror.status().outfit.view(), wardrobe_.outfits[0].name);
    buttons_.press(hal::Button::next);
    ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().outfit.view(), wardrobe_.outfits[1].name);
    EXPECT_FALSE(mirror.status().avatarView);
    buttons_.press(hal::Button::view);
    ASSERT_TRUE(mirror.step(never));
    EXPECT_TRUE(mirror.status().avatarView);
}

TEST_F(MirrorTest, saysSomethingOfTheSizeToWhoIsDressedAndToNobodyElse) {
    Mirror& mirror = lightSimulation();
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(advice_, "");
    while (mirror.status().state != SessionState::wearing && hal::seconds(clock_.now()) < 10.0)
        ASSERT_TRUE(mirror.step(never));
    ASSERT_EQ(mirror.status().state, SessionState::wearing);
    ASSERT_TRUE(mirror.step());
    // What exactly is the estimator's business; that it is a sentence of ours is this one's.
    EXPECT_THAT(advice_,
                testing::AnyOf(testing::StartsWith("Size: I cannot tell: "), testing::StartsWith("Your size: "),
                               testing::StartsWith("Between "), testing::HasSubstr("our sizes")));
    EXPECT_THAT(service_, testing::Not(testing::HasSubstr(" cm")));
}

class MirrorWithABadSizeTable : public MirrorTest {
  protected:
    MirrorWithABadSizeTable()
        : MirrorTest([] {
              config::Settings settings = smallSettings();
              settings.fitting.sizesFolder = "/nonexistent";
              return settings;
          }()) {}
};

TEST_F(MirrorWithABadSizeTable, dressesAllTheSameAndWithholdsTheAdvice) {
    Mirror& mirror = lightSimulation();
    ASSERT_EQ(wardrobe_.refusals.size(), 1U);
    EXPECT_THAT(serviceText(wardrobe_.refusals.front()), testing::HasSubstr("size tables"));
    while (mirror.status().state != SessionState::wearing && hal::seconds(clock_.now()) < 10.0)
        ASSERT_TRUE(mirror.step(never));
    ASSERT_EQ(mirror.status().state, SessionState::wearing);
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(advice_, "");
}

TEST_F(MirrorTest, doesWhatOtherProgramsAskForInItsNextFrame) {
    Mirror& mirror = lightSimulation();
    ASSERT_TRUE(commands_.push({.kind = RemoteCommand::Kind::choose, .outfit = 2}));
    ASSERT_TRUE(commands_.push({.kind = RemoteCommand::Kind::avatarView}));
    ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().outfitIndex, 2U);
    EXPECT_EQ(mirror.status().outfit.view(), wardrobe_.outfits[2].name);
    EXPECT_TRUE(mirror.status().avatarView);
    ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().outfitIndex, 2U) << "a wish is granted once";
}

TEST_F(MirrorTest, saysWhyItsButtonsCannotBeReadUntilTheyCan) {
    Mirror& mirror = lightSimulation();
    ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().buttonsFault.view(), "");
    buttons_.setBroken(true);
    ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().buttonsFault.view(), "the chip is gone. Mend: plug it in");
    // One of several works on.
    buttons_.press(hal::Button::next);
    ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().outfitIndex, 1U);
    EXPECT_EQ(mirror.status().buttonsFault.view(), "the chip is gone. Mend: plug it in") << "a press mends nothing";
    buttons_.setBroken(false);
    ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().buttonsFault.view(), "");
    EXPECT_EQ(mirror.status().turns, 4U);
}

TEST_F(MirrorTest, takesNoHeapMemoryInTheLoopOnceItRuns) {
    Mirror& mirror = lightSimulation();
    // Every outfit has been worn and both views shown before the count begins.
    const std::function<bool(const hal::DepthFrame&)> draw = never;
    while (mirror.status().state != SessionState::wearing && hal::seconds(clock_.now()) < 10.0)
        ASSERT_TRUE(mirror.step(draw));
    ASSERT_EQ(mirror.status().state, SessionState::wearing);
    std::uint64_t allocations = 0;
    int frames = 0;
    for (; frames < 240; ++frames) {
        if (frames % 20 == 0) buttons_.press(hal::Button::next);
        if (frames % 20 == 10) {
            ASSERT_TRUE(commands_.push({.kind = RemoteCommand::Kind::choose, .outfit = 2}));
        }
        // The simulated camera draws a world; what it takes is not the mirror's. Here the whole step is counted, camera
        // included, and held to none.
        const cheval::test::AllocationCounter counter;
        const Expected<StepResult> step = mirror.step(draw);
        allocations += counter.count();
        ASSERT_TRUE(step);
    }
    EXPECT_EQ(allocations, 0U) << "in " << frames
                               << " frames; run with CHEVAL_TRAP_ALLOCATIONS=1 under a debugger to see where";
}

TEST_F(MirrorTest, staysLitAndSaysWhyWhenTheCameraIsLost) {
    script_.steps = {Does::frame, Does::frame, Does::frame, Does::lose};
    script_.steps.insert(script_.steps.end(), 8, Does::refuseToOpen);
    script_.steps.push_back(Does::frame);
    Mirror& mirror = lightScript();
    while (hal::seconds(clock_.now()) < 50.0)
        ASSERT_TRUE(mirror.step());
    // Shoppers are asked for patience first.
    EXPECT_THAT(screens_, testing::Each(render::Screen::attract));
    EXPECT_THAT(prompt_, testing::HasSubstr("One moment"));
    EXPECT_GT(mirror.status().fault.length, 0U);
    while (mirror.camera().openings() < 2 && hal::seconds(clock_.now()) < 200.0)
        ASSERT_TRUE(mirror.step());
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(mirror.camera().openings(), 2U);
    EXPECT_THAT(screens_, testing::Contains(render::Screen::service));
    EXPECT_EQ(screens_.back(), render::Screen::attract);
    // At least five pictures a second all the while: the screen never froze.
    EXPECT_GT(static_cast<double>(screens_.size()), 5.0 * hal::seconds(clock_.now()));
}

TEST_F(MirrorTest, goesOnWithTheSameShopperInTheSameClothesAfterAShortOutage) {
    const auto world = hal::sim::makeWorld(worldOptions(settings_));
    Mirror& mirror = light(
        [&]() -> Expected<std::unique_ptr<hal::DepthCamera>> { return hal::sim::makeSimulatedCamera(world, clock_); });
    while (mirror.status().state != SessionState::wearing && hal::seconds(clock_.now()) < 10.0)
        ASSERT_TRUE(mirror.step(never));
    buttons_.press(hal::Button::next);
    for (int i = 0; i < 30; ++i)
        ASSERT_TRUE(mirror.step(never));
    const int measured = mirror.chain().measurements()->frames;
    ASSERT_GT(measured, 0);

    world->setFault(hal::sim::CameraFault::lost);
    const hal::TimePoint lost = clock_.now();
    while (clock_.now() - lost < std::chrono::milliseconds(700))
        ASSERT_TRUE(mirror.step());
    EXPECT_THAT(screens_, testing::Not(testing::Contains(render::Screen::service)));
    EXPECT_GT(mirror.status().fault.length, 0U);
    world->setFault(hal::sim::CameraFault::none);
    const hal::TimePoint back = clock_.now();
    while (mirror.status().camera != CameraState::streaming && clock_.now() - back < std::chrono::seconds(40))
        ASSERT_TRUE(mirror.step(never));
    EXPECT_LT(clock_.now() - back, std::chrono::seconds(2));
    EXPECT_EQ(mirror.status().state, SessionState::wearing);
    EXPECT_EQ(mirror.status().outfit.view(), wardrobe_.outfits[1].name);
    EXPECT_EQ(mirror.status().visits, 1U);
    EXPECT_GE(mirror.chain().measurements()->frames, measured) << "the shopper is measured anew";
}

TEST_F(MirrorTest, staysLitWhenThereIsNoCameraAtAll) {
    Mirror& mirror = light([]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
        return Error{
            .code = ErrorCode::notFound, .cause = "there is no sensor.json", .mend = "write one", .file = "/x"};
    });
    for (int i = 0; i < 50; ++i)
        ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.size(), 50U);
    EXPECT_EQ(screens_.back(), render::Screen::service);
    EXPECT_THAT(service_, testing::HasSubstr("there is no sensor.json"));
    EXPECT_THAT(service_, testing::HasSubstr("write one"));
    const MirrorStatus status = mirror.status();
    EXPECT_EQ(status.frames, 0U);
    EXPECT_EQ(status.turns, 50U) << "the loop lives without a camera";
    EXPECT_EQ(status.drawTurns, 50U);
}

TEST_F(MirrorTest, knowsHowManyFramesItsSensorTakes) {
    script_ = {.steps = {Does::frame}, .period = std::chrono::milliseconds(200)};
    Mirror& mirror = lightScript();
    // A picture in 0.2 s; the loop waits for half of that at most.
    while (mirror.status().frames < 9)
        ASSERT_TRUE(mirror.step(never));
    EXPECT_EQ(mirror.status().sensorFramesPerSecond, 0.0);
    while (mirror.status().frames < 20)
        ASSERT_TRUE(mirror.step(never));
    EXPECT_NEAR(mirror.status().sensorFramesPerSecond, 5.0, 0.1);
}

TEST_F(MirrorTest, staysLitWhenTheRecordingEnds) {
    script_.steps = {Does::frame, Does::frame, Does::end};
    Mirror& mirror = lightScript();
    StepResult last = StepResult::frame;
    for (int i = 0; i < 20; ++i) {
        const Expected<StepResult> step = mirror.step();
        ASSERT_TRUE(step);
        last = *step;
    }
    EXPECT_EQ(last, StepResult::ended);
    EXPECT_EQ(screens_.size(), 20U);
    EXPECT_EQ(screens_.back(), render::Screen::service);
    EXPECT_THAT(service_, testing::HasSubstr("is over"));
}

TEST_F(MirrorTest, saysOnTheScreenWhichPicturesTrackingReads) {
    script_ = {.steps = {Does::frame}, .width = 320, .height = 240, .colourWidth = 320};
    Mirror& mirror = lightScript();
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::service);
    EXPECT_THAT(service_, testing::HasSubstr("320×240"));
    EXPECT_THAT(service_, testing::HasSubstr("640×480"));
}

/// Lends buffers full of an old picture and keeps what it is shown.
class KeepingDisplay final : public hal::Display {
  public:
    explicit KeepingDisplay(const hal::DisplayMode& mode)
        : mode_(mode), picture_(mode.width, mode.height, hal::Rgba8{.r = 255, .g = 0, .b = 255}) {}
    Expected<hal::DisplayMode> open() override { return mode_; }
    void close() override {}
    Expected<hal::DisplayBuffer> lend(hal::Duration) override { return hal::DisplayBuffer{.pixels = picture_.view()}; }
    Expected<void> present(const hal::DisplayBuffer&, hal::TimePoint) override {
        ++shown_;
        return {};
    }
    [[nodiscard]] hal::DisplayStatistics statistics() const override { return {.presented = shown_}; }
    [[nodiscard]] const hal::Image<hal::Rgba8>& picture() const { return picture_; }

  private:
    hal::DisplayMode mode_;
    hal::Image<hal::Rgba8> picture_;
    std::uint64_t shown_ = 0;
};

TEST_F(MirrorTest, showsNothingOldWhenAPictureCannotBeDrawn) {
    auto keeping = std::make_unique<KeepingDisplay>(displayMode(settings_));
    const KeepingDisplay& display = *keeping;
    display_ = std::move(keeping);
    // Colour of another size than depth, which no renderer can lay over it.
    script_ = {.steps = {Does::frame}, .colourWidth = 320};
    EXPECT_FALSE(lightScript().step());
    EXPECT_NE(mirror_->status().displayFault.view(), "");
    EXPECT_EQ(display.statistics().presented, 1U);
    for (const hal::Rgba8 pixel : display.picture().pixels)
        ASSERT_LT(std::max({pixel.r, pixel.g, pixel.b}), 64);
}

TEST_F(MirrorTest, opensTheServiceScreenForANewNoticeAndClosesItAgain) {
    script_.steps = {Does::frame};
    Mirror& mirror = lightScript();
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::attract);
    mirror.setNotice("tshirt.glb is refused");
    const hal::TimePoint told = clock_.now();
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::service);
    EXPECT_EQ(service_, "tshirt.glb is refused");
    while (hal::seconds(clock_.now() - told) < 7.5)
        ASSERT_TRUE(mirror.step(never));
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::service);
    while (hal::seconds(clock_.now() - told) < 8.5)
        ASSERT_TRUE(mirror.step(never));
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::attract);
    // It can be read again at any time.
    buttons_.press(hal::Button::service);
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::service);
    EXPECT_EQ(service_, "tshirt.glb is refused");
}

TEST_F(MirrorTest, doesNotShowANoticeToAShopperWhoIsBeingDressed) {
    Mirror& mirror = lightSimulation();
    while (mirror.status().state != SessionState::wearing && hal::seconds(clock_.now()) < 10.0)
        ASSERT_TRUE(mirror.step(never));
    ASSERT_EQ(mirror.status().state, SessionState::wearing);
    mirror.setNotice("tshirt.glb is refused");
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::wearing);
}

TEST(ServiceText, namesTheFileWithoutItsFolders) {
    EXPECT_EQ(serviceText({.cause = "it is cut short",
                           .mend = "bake it again",
                           .file = "/a/long/way/down/to/the/wardrobe/tshirt.glb",
                           .line = 3}),
              "tshirt.glb:3: it is cut short. Mend: bake it again");
}

class MirrorWithABadWardrobe : public MirrorTest {
  protected:
    MirrorWithABadWardrobe()
        : MirrorTest([] {
              config::Settings settings = smallSettings();
              settings.wardrobe.garments = {"tshirt", "no-such-garment"};
              settings.wardrobe.outfits = {"tshirt", "no-such-garment"};
              return settings;
          }()) {}
};

TEST_F(MirrorWithABadWardrobe, refusesTheBadGarmentAndKeepsTheOthers) {
    script_.steps = {Does::frame};
    Mirror& mirror = lightScript();
    ASSERT_FALSE(wardrobe_.refusals.empty());
    EXPECT_THAT(wardrobe_.refusals.front().file, testing::HasSubstr("no-such-garment.glb"));
    ASSERT_EQ(wardrobe_.outfits.size(), 1U);
    EXPECT_EQ(wardrobe_.outfits[0].id, "tshirt");
    ASSERT_TRUE(mirror.step());
    EXPECT_EQ(screens_.back(), render::Screen::attract);
}

class MirrorWithoutAssets : public MirrorTest {
  protected:
    MirrorWithoutAssets()
        : MirrorTest([] {
              config::Settings settings = smallSettings();
              settings.wardrobe.folder = "/nonexistent";
              return settings;
          }()) {}
};

TEST_F(MirrorWithoutAssets, staysLitWithoutAMannequin) {
    Mirror& mirror = lightSimulation();
    EXPECT_FALSE(wardrobe_.body);
    for (int i = 0; i < 60; ++i)
        ASSERT_TRUE(mirror.step(i % 20 == 0 ? std::function<bool(const hal::DepthFrame&)>() : never));
    EXPECT_NE(mirror.status().state, SessionState::wearing);
    EXPECT_FALSE(screens_.empty());
}

TEST_F(MirrorTest, runsAsTwoThreadsAndStops) {
    hal::SteadyClock clock;
    wardrobe_ = loadWardrobe(wardrobeOptions(settings_));
    CameraScript script{.steps = {Does::frame}};
    std::atomic<int> shown{0};
    hal::Interrupt enough;
    Expected<std::unique_ptr<Mirror>> mirror = Mirror::create(
        settings_, {.camera = [&]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
                        return std::unique_ptr<hal::DepthCamera>(std::make_unique<FakeCamera>(script, clock));
                    },
                    .display = display_.get(),
                    .mode = displayMode(settings_),
                    .clock = &clock,
                    .cost = &clock,
                    .wardrobe = &wardrobe_,
                    .observer =
                        [&](const FramePacket&, hal::ImageView<const hal::Rgba8>) {
                            if (++shown == 5) enough.raise();
                        }});
    ASSERT_TRUE(mirror);
    ASSERT_TRUE((*mirror)->start());
    EXPECT_FALSE(clock.waitUntil(clock.now() + std::chrono::minutes(2), enough)) << "five pictures within two minutes";
    (*mirror)->setNotice("seen by the loop at its next turn");
    (*mirror)->stop();
    EXPECT_GE((*mirror)->status().pictures, 5U);
    EXPECT_FALSE((*mirror)->rendererDescription().empty());
    EXPECT_GT((*mirror)->statistics().size(), PictureMaker::tasks().size());
}

/// Lends nothing, and says so when it has been asked for the fifth time.
class AbsentDisplay final : public hal::Display {
  public:
    explicit AbsentDisplay(ErrorCode code) : code_(code) {}
    Expected<hal::DisplayMode> open() override { return hal::DisplayMode{}; }
    void close() override {}
    Expected<hal::DisplayBuffer> lend(hal::Duration) override {
        if (++asked_ == 5) enough_.raise();
        return Error{.code = code_, .cause = "there is no picture to be had"};
    }
    Expected<void> present(const hal::DisplayBuffer&, hal::TimePoint) override { return {}; }
    [[nodiscard]] hal::DisplayStatistics statistics() const override { return {}; }
    [[nodiscard]] hal::Interrupt& enough() { return enough_; }

  private:
    ErrorCode code_;
    int asked_ = 0;
    hal::Interrupt enough_;
};

/// What the watchdog is told after five pictures failed in this way.
MirrorStatus afterFailedPictures(ErrorCode code) {
    const config::Settings settings = smallSettings();
    const Wardrobe wardrobe = loadWardrobe(wardrobeOptions(settings));
    CameraScript script{.steps = {Does::frame}};
    hal::SteadyClock clock;
    AbsentDisplay display(code);
    Expected<std::unique_ptr<Mirror>> mirror = Mirror::create(
        settings, {.camera = [&]() -> Expected<std::unique_ptr<hal::DepthCamera>> {
                       return std::unique_ptr<hal::DepthCamera>(std::make_unique<FakeCamera>(script, clock));
                   },
                   .display = &display,
                   .mode = displayMode(settings),
                   .clock = &clock,
                   .cost = &clock,
                   .wardrobe = &wardrobe});
    EXPECT_TRUE(mirror);
    EXPECT_TRUE((*mirror)->start());
    EXPECT_FALSE(clock.waitUntil(clock.now() + std::chrono::minutes(2), display.enough()));
    (*mirror)->stop();
    return (*mirror)->status();
}

TEST(MirrorProgress, countsARendererWhoseScreenIsAwayAsAlive) {
    const MirrorStatus status = afterFailedPictures(ErrorCode::unavailable);
    EXPECT_EQ(status.pictures, 0U);
    EXPECT_GE(status.drawTurns, 5U);
}

TEST(MirrorProgress, doesNotCountARendererThatCannotDraw) {
    const MirrorStatus status = afterFailedPictures(ErrorCode::internal);
    EXPECT_GE(status.turns, 1U);
    EXPECT_EQ(status.drawTurns, 0U);
}

}  // namespace
}  // namespace cheval::daemon

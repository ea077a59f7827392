#include "daemon/room_options.h"

#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include "config/loader.h"
#include "config/settings_table.h"

namespace cheval::daemon {
namespace {

auto values(const fitting::GestureOptions& options) {
    return std::make_tuple(options.swipeStartSpeed, options.swipeEndSpeed, options.swipePeakSpeed,
                           options.swipeDistance, options.swipeSteepest, options.swipeLongest, options.grabOpenBefore,
                           options.grabClosedLeast, options.grabClosedLongest, options.grabLowest, options.raiseHold,
                           options.raiseRest, options.holdTime, options.holdMovement, options.holdAway,
                           options.holdRest, options.walkingSpeed);
}

TEST(RoomOptions, TheSettingsDefaultsAreTheGesturesOwn) {
    EXPECT_EQ(values(trackerOptions(config::defaultSettings(), {}).gestures), values(fitting::GestureOptions{}));
}

TEST(RoomOptions, EachGestureSettingReachesTheTracker) {
    const config::LoadedSettings loaded = config::loadSettingsText(
        "[gestures]\nswipe_start_speed = 0.5\nswipe_end_speed = 0.125\nswipe_peak_speed = 0.75\n"
        "swipe_distance = 0.25\nswipe_steepest = 1.5\nswipe_longest_s = 2\ngrab_open_before_s = 0.375\n"
        "grab_closed_least_s = 0.625\ngrab_closed_longest_s = 4\ngrab_lowest = -0.25\nraise_hold_s = "
        "0.875\nraise_rest_s = 1.25\n"
        "hold_s = 2.5\nhold_movement = 0.0625\nhold_away = 0.1875\nhold_rest_s = 3.5\nwalking_speed = 1.75\n",
        "a.toml");
    ASSERT_TRUE(loaded.good()) << loaded.problems.front().message();
    EXPECT_EQ(values(trackerOptions(loaded.settings, {}).gestures), values({.swipeStartSpeed = 0.5F,
                                                                            .swipeEndSpeed = 0.125F,
                                                                            .swipePeakSpeed = 0.75F,
                                                                            .swipeDistance = 0.25F,
                                                                            .swipeSteepest = 1.5F,
                                                                            .swipeLongest = 2.0F,
                                                                            .grabOpenBefore = 0.375F,
                                                                            .grabClosedLeast = 0.625F,
                                                                            .grabClosedLongest = 4.0F,
                                                                            .grabLowest = -0.25F,
                                                                            .raiseHold = 0.875F,
                                                                            .raiseRest = 1.25F,
                                                                            .holdTime = 2.5F,
                                                                            .holdMovement = 0.0625F,
                                                                            .holdAway = 0.1875F,
                                                                            .holdRest = 3.5F,
                                                                            .walkingSpeed = 1.75F}));
}

TEST(RoomOptions, AHoldMeansWhatTheSettingsSay) {
    config::Settings settings = config::defaultSettings();
    EXPECT_TRUE(sessionOptions(settings, Wardrobe{}).holdChangesView);
    settings.session.hold = config::HoldMeaning::nothing;
    EXPECT_FALSE(sessionOptions(settings, Wardrobe{}).holdChangesView);
}

TEST(RoomOptions, TheSizesAreThoseThatTheSettingsName) {
    config::Settings settings = config::defaultSettings();
    EXPECT_EQ(wardrobeOptions(settings).sizesFor, fitting::SizesFor::women);
    EXPECT_EQ(wardrobeOptions(settings).sizesFolder, shippedSizesFolder());
    for (const auto& [text, people] : {std::pair("women", std::optional(fitting::SizesFor::women)),
                                       std::pair("men", std::optional(fitting::SizesFor::men)),
                                       std::pair("none", std::optional<fitting::SizesFor>())}) {
        const config::LoadedSettings loaded = config::loadSettingsText(
            "[fitting]\nsizes = \"" + std::string(text) + "\"\nsizes_folder = \"charts\"\n", "/etc/cheval/cheval.toml");
        ASSERT_TRUE(loaded.good()) << loaded.problems.front().message();
        EXPECT_EQ(wardrobeOptions(loaded.settings).sizesFor, people);
        EXPECT_EQ(wardrobeOptions(loaded.settings).sizesFolder, "/etc/cheval/charts");
    }
    EXPECT_FALSE(config::loadSettingsText("[fitting]\nsizes = \"children\"\n", "a.toml").good());
}

}  // namespace
}  // namespace cheval::daemon

#include "hal/headless/headless_display.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "hal/png/png.h"
#include "tests/hal/replay/recording_folder.h"

namespace cheval::hal {
namespace {

constexpr DisplayMode kMode{.width = 24, .height = 40, .refreshHz = 30};

std::vector<std::string> namesIn(const std::string& folder) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

Expected<void> show(Display& display, Rgba8 colour) {
    auto buffer = display.lend(Duration::zero());
    if (!buffer) return buffer.error();
    for (int y = 0; y < buffer->pixels.height; ++y) {
        std::fill_n(buffer->pixels.row(y), buffer->pixels.width, colour);
    }
    return display.present(*buffer, TimePoint{});
}

TEST(HeadlessDisplayTest, WritesEveryNthPictureAsItWasDrawn) {
    const test::RecordingFolder folder;
    const std::string pictures = folder.path("deep/pictures");
    const auto display = makeHeadlessDisplay({.mode = kMode, .folder = pictures, .every = 2});
    ASSERT_TRUE(display->open());
    for (std::uint8_t i = 0; i < 5; ++i)
        ASSERT_TRUE(show(*display, {i, 2, 3, 255}));
    EXPECT_EQ(namesIn(pictures),
              (std::vector<std::string>{"frame-000000.png", "frame-000002.png", "frame-000004.png"}));
    Image<Rgba8> picture;
    ASSERT_TRUE(readPng(pictures + "/frame-000004.png", picture));
    EXPECT_EQ(picture.pixels, std::vector<Rgba8>(24 * 40, Rgba8{4, 2, 3, 255}));
    EXPECT_EQ(display->statistics().presented, 5U);
    EXPECT_EQ(display->statistics().dropped, 0U);
}

TEST(HeadlessDisplayTest, WithoutAFolderItOnlyCounts) {
    const auto display = makeHeadlessDisplay({.mode = kMode, .folder = {}, .every = 1});
    ASSERT_TRUE(display->open());
    ASSERT_TRUE(show(*display, {}));
    EXPECT_EQ(display->statistics().presented, 1U);
}

TEST(HeadlessDisplayTest, AFolderThatCannotBeMadeIsRefused) {
    const test::RecordingFolder folder;
    ASSERT_TRUE(folder.text("file", "x"));
    const auto display = makeHeadlessDisplay({.mode = kMode, .folder = folder.path("file/pictures"), .every = 1});
    const auto opened = display->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().file, folder.path("file/pictures"));
    EXPECT_FALSE(opened.error().mend.empty());
}

TEST(HeadlessDisplayTest, AFileThatCannotBeWrittenIsReportedAndTheShowGoesOn) {
    const test::RecordingFolder folder;
    const auto display = makeHeadlessDisplay({.mode = kMode, .folder = folder.path("pictures"), .every = 1});
    ASSERT_TRUE(display->open());
    std::filesystem::remove_all(folder.path("pictures"));
    EXPECT_FALSE(show(*display, {}));
    EXPECT_EQ(display->statistics().dropped, 1U);
    std::filesystem::create_directory(folder.path("pictures"));
    EXPECT_TRUE(show(*display, {}));
    EXPECT_EQ(display->statistics().presented, 2U);
}

TEST(HeadlessDisplayTest, AModeWithoutPixelsIsRefused) {
    for (const DisplayMode mode : {DisplayMode{.width = 0, .height = 10}, DisplayMode{.width = 10, .height = -1},
                                   DisplayMode{.width = 100000, .height = 10}}) {
        EXPECT_FALSE(makeHeadlessDisplay({.mode = mode, .folder = {}, .every = 1})->open());
    }
}

}  // namespace
}  // namespace cheval::hal

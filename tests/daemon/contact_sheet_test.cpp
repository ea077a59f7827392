#include "daemon/contact_sheet.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::daemon {
namespace {

/// Colours that no text and no paper has, one a picture.
hal::Rgba8 colourOf(std::size_t i) {
    return {static_cast<std::uint8_t>(10 + 20 * i), 255, static_cast<std::uint8_t>(250 - 20 * i), 255};
}

struct Box {
    int left, top, right, bottom;
};

/// The smallest box around the pixels of a colour; empty (right < left) where there are none.
Box boxOf(const hal::Image<hal::Rgba8>& sheet, hal::Rgba8 colour) {
    Box box{sheet.width, sheet.height, -1, -1};
    for (int y = 0; y < sheet.height; ++y) {
        for (int x = 0; x < sheet.width; ++x) {
            if (sheet.view().at(x, y) == colour) {
                box = {std::min(box.left, x), std::min(box.top, y), std::max(box.right, x), std::max(box.bottom, y)};
            }
        }
    }
    return box;
}

class ContactSheet : public ::testing::Test {
  protected:
    std::vector<SheetPicture> pictures(std::size_t count, int width, int height) {
        for (std::size_t i = 0; i < count; ++i) {
            images_.emplace_back(width, height, colourOf(i));
        }
        std::vector<SheetPicture> result;
        for (const auto& image : images_) {
            result.push_back({.picture = image.view(), .heading = "1.0 s", .caption = "wearing"});
        }
        return result;
    }

    std::vector<hal::Image<hal::Rgba8>> images_;
};

TEST_F(ContactSheet, ShowsEveryPictureWholeInReadingOrder) {
    const auto sheet = drawContactSheet(pictures(5, 80, 120), {.title = "T", .subtitle = "S", .columns = 3});
    ASSERT_TRUE(sheet.hasValue()) << sheet.error().message();
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < 5; ++i) {
        boxes.push_back(boxOf(*sheet, colourOf(i)));
        EXPECT_EQ(boxes[i].right - boxes[i].left + 1, 80) << i;
        EXPECT_EQ(boxes[i].bottom - boxes[i].top + 1, 120) << i;
    }
    EXPECT_LT(boxes[0].right, boxes[1].left);
    EXPECT_LT(boxes[1].right, boxes[2].left);
    EXPECT_EQ(boxes[0].top, boxes[2].top);
    EXPECT_LT(boxes[0].bottom, boxes[3].top);
    EXPECT_EQ(boxes[0].left, boxes[3].left);
    EXPECT_LT(boxes[2].right, sheet->width);
    EXPECT_LT(boxes[4].bottom, sheet->height);
}

TEST_F(ContactSheet, IsNoWiderThanItsPicturesNeed) {
    const auto sheet = drawContactSheet(pictures(2, 80, 120), {.title = "T", .subtitle = "S", .columns = 6});
    ASSERT_TRUE(sheet.hasValue());
    EXPECT_LT(sheet->width, 3 * 80 + 60);
}

TEST_F(ContactSheet, WritesTheTextsWhereTheyAre) {
    auto shown = pictures(1, 200, 100);
    const auto with = drawContactSheet(shown, {.title = "A title", .subtitle = "and more", .columns = 1});
    shown[0].caption = "";
    const auto without = drawContactSheet(shown, {.title = "A title", .subtitle = "and more", .columns = 1});
    ASSERT_TRUE(with.hasValue() && without.hasValue());
    // What differs is the caption's ink: below the picture, within its width.
    Box ink{with->width, with->height, -1, -1};
    for (int y = 0; y < with->height; ++y) {
        for (int x = 0; x < with->width; ++x) {
            if (with->view().at(x, y) != without->view().at(x, y)) {
                ink = {std::min(ink.left, x), std::min(ink.top, y), std::max(ink.right, x), std::max(ink.bottom, y)};
            }
        }
    }
    const Box picture = boxOf(*with, colourOf(0));
    EXPECT_GT(ink.right - ink.left, 20);
    EXPECT_GT(ink.top, picture.bottom);
    EXPECT_GT(ink.left, picture.left);
    EXPECT_LE(ink.right, picture.right);
}

TEST_F(ContactSheet, CutsACaptionThatIsTooLongAtItsPicturesEdge) {
    auto shown = pictures(2, 150, 100);
    shown[0].caption = std::string(500, 'W');
    const auto cut = drawContactSheet(shown, {.title = "", .subtitle = "", .columns = 2});
    shown[0].caption = "";
    const auto none = drawContactSheet(shown, {.title = "", .subtitle = "", .columns = 2});
    ASSERT_TRUE(cut.hasValue() && none.hasValue());
    const Box first = boxOf(*cut, colourOf(0));
    int rightmost = -1;
    for (int y = 0; y < cut->height; ++y) {
        for (int x = 0; x < cut->width; ++x) {
            rightmost = cut->view().at(x, y) != none->view().at(x, y) ? std::max(rightmost, x) : rightmost;
        }
    }
    EXPECT_GT(rightmost, first.left);
    EXPECT_LE(rightmost, first.right);
}

TEST_F(ContactSheet, TakesTextsThatAreNotUtf8) {
    auto shown = pictures(1, 100, 100);
    shown[0].caption = "caf\xC3";
    EXPECT_TRUE(drawContactSheet(shown, {.title = "\xFF", .subtitle = "", .columns = 1}).hasValue());
}

TEST_F(ContactSheet, RefusesWhatCannotBeASheet) {
    EXPECT_EQ(drawContactSheet({}, {}).error().code, ErrorCode::invalidInput);
    EXPECT_EQ(drawContactSheet({SheetPicture{}}, {}).error().code, ErrorCode::invalidInput);
    EXPECT_EQ(drawContactSheet(pictures(1, 10, 10), {.title = "", .subtitle = "", .columns = 0}).error().code,
              ErrorCode::invalidInput);
    images_.clear();
    EXPECT_EQ(drawContactSheet(pictures(12, 4000, 10), {.title = "", .subtitle = "", .columns = 12}).error().code,
              ErrorCode::invalidInput);
}

}  // namespace
}  // namespace cheval::daemon

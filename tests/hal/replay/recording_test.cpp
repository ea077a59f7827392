#include "hal/replay/recording.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cheval::hal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> depthNames(const Recording& recording) {
    std::vector<std::string> names;
    for (const RecordedPicture& picture : recording.pictures)
        names.push_back(picture.depth);
    return names;
}

std::vector<std::uint64_t> ticks(const Recording& recording) {
    std::vector<std::uint64_t> all;
    for (const RecordedPicture& picture : recording.pictures)
        all.push_back(picture.tick);
    return all;
}

TEST(NaturalOrderTest, ComparesNumbersAsNumbers) {
    std::vector<std::string> names{"depth-10", "depth-9", "depth-1028894671", "depth-82823944",
                                   "depth-",   "a",       "depth-9-2",        "depth-9-10"};
    std::sort(names.begin(), names.end(), naturalLess);
    EXPECT_THAT(names, ElementsAre("a", "depth-", "depth-9", "depth-9-2", "depth-9-10", "depth-10", "depth-82823944",
                                   "depth-1028894671"));
}

TEST(NaturalOrderTest, NumbersMayBeLongerThanAnyInteger) {
    EXPECT_TRUE(naturalLess("99999999999999999999999", "100000000000000000000000"));
    EXPECT_FALSE(naturalLess("100000000000000000000000", "99999999999999999999999"));
}

TEST(NaturalOrderTest, IsATotalOrderEvenWithLeadingZeros) {
    const std::vector<std::string> names{"", "0", "00", "01", "1", "1a", "01a", "a1", "a01", "a1b2", "a01b1"};
    for (const auto& a : names) {
        EXPECT_FALSE(naturalLess(a, a));
        for (const auto& b : names) {
            if (a != b) {
                EXPECT_NE(naturalLess(a, b), naturalLess(b, a)) << a << " and " << b;
            }
            for (const auto& c : names) {
                if (naturalLess(a, b) && naturalLess(b, c)) {
                    EXPECT_TRUE(naturalLess(a, c)) << a << ' ' << b << ' ' << c;
                }
            }
        }
    }
}

TEST(RecordingTest, OnlyDepthIsDepth) {
    const Recording recording = arrangeRecording({"mask-0000.png", "sensor.json", "depth-0001.png", "color-0000.png",
                                                  "colour-0001.png", "depth-0000.png", "other.png", "README.md"},
                                                 false);
    EXPECT_THAT(depthNames(recording), ElementsAre("depth-0000.png", "depth-0001.png"));
    EXPECT_EQ(recording.pictures[0].colour, "color-0000.png");
    EXPECT_EQ(recording.pictures[1].colour, "colour-0001.png");
    EXPECT_THAT(recording.warnings, IsEmpty());
}

TEST(RecordingTest, WithoutDepthNamesEveryOtherPictureIsDepth) {
    const Recording recording = arrangeRecording(
        {"20210326-231615-000.png", "20210326-230536-030.png", "mask-1.png", "color-1.png", "LICENSE"}, true);
    EXPECT_THAT(depthNames(recording), ElementsAre("20210326-230536-030.png", "20210326-231615-000.png"));
    EXPECT_THAT(recording.warnings, IsEmpty());
}

TEST(RecordingTest, AGapInTheNumbersIsAWarningAndAGapInTime) {
    const Recording recording = arrangeRecording({"depth-3.png", "depth-4.png", "depth-7.png", "depth-8.png"}, false);
    EXPECT_THAT(ticks(recording), ElementsAre(0, 1, 4, 5));
    ASSERT_EQ(recording.warnings.size(), 1U);
    EXPECT_THAT(recording.warnings[0], HasSubstr("2 picture(s) missing between depth-4.png and depth-7.png"));
}

TEST(RecordingTest, EverySecondFrameIsNoGap) {
    const Recording recording = arrangeRecording({"depth-0.png", "depth-2.png", "depth-4.png"}, false);
    EXPECT_THAT(ticks(recording), ElementsAre(0, 1, 2));
    EXPECT_THAT(recording.warnings, IsEmpty());
}

TEST(RecordingTest, TimeStampsAreNamesAndNotFrameNumbers) {
    const Recording recording =
        arrangeRecording({"depth-82823944.png", "depth-1028894671.png", "depth-1038901490.png"}, false);
    EXPECT_THAT(ticks(recording), ElementsAre(0, 1, 2));
    EXPECT_THAT(recording.warnings, IsEmpty());
}

TEST(RecordingTest, StillsHaveNoGaps) {
    const Recording recording = arrangeRecording({"depth-1.png", "depth-2.png", "depth-5.png"}, true);
    EXPECT_THAT(ticks(recording), ElementsAre(0, 1, 2));
    EXPECT_THAT(recording.warnings, IsEmpty());
}

TEST(RecordingTest, MissingColourIsAWarning) {
    const Recording recording = arrangeRecording({"depth-1.png", "depth-2.png", "color-1.png"}, false);
    ASSERT_EQ(recording.warnings.size(), 1U);
    EXPECT_EQ(recording.warnings[0], "depth-2.png has no colour picture");
}

TEST(RecordingTest, AFolderThatDoesNotExistIsNamed) {
    const auto names = listFolder("no/such/folder");
    ASSERT_FALSE(names);
    EXPECT_EQ(names.error().code, ErrorCode::notFound);
    EXPECT_EQ(names.error().file, "no/such/folder");
}

}  // namespace
}  // namespace cheval::hal

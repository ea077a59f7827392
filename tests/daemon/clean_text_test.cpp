#include "daemon/clean_text.h"

#include <string>

#include <gtest/gtest.h>

namespace cheval::daemon {
namespace {

using namespace std::string_literals;

TEST(CleanText, LeavesTextOfPeopleAsItIs) {
    for (const std::string& text : {""s, "T-shirt + Trousers"s, "Größe … 大 👕"s, "\xC2\xA0"s, "\xF4\x8F\xBF\xBF"s})
        EXPECT_EQ(cleanText(text), text);
}

TEST(CleanText, ReplacesWhatABusRefusesOrATerminalObeys) {
    const std::string mark = "\xEF\xBF\xBD";
    EXPECT_EQ(cleanText("a\nb\x1B[2J"), "a" + mark + "b" + mark + "[2J");
    EXPECT_EQ(cleanText("a\0b"s), "a" + mark + "b");
    EXPECT_EQ(cleanText("\x7F"), mark);
    EXPECT_EQ(cleanText("\xC2\x9B"), mark) << "CSI in C1";
    EXPECT_EQ(cleanText("\xFF"), mark);
    EXPECT_EQ(cleanText("caf\xE9"), "caf" + mark) << "cut at the end";
    EXPECT_EQ(cleanText("\xC0\xAF"), mark + mark) << "overlong";
    EXPECT_EQ(cleanText("\xE0\x80\xAF"), mark + mark + mark) << "overlong";
    EXPECT_EQ(cleanText("\xED\xA0\x80"), mark + mark + mark) << "surrogate";
    EXPECT_EQ(cleanText("\xF4\x90\x80\x80"), mark + mark + mark + mark) << "beyond Unicode";
}

}  // namespace
}  // namespace cheval::daemon

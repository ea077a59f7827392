#include "config/anthropometry.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

using namespace cheval;
using namespace cheval::config;

namespace {

constexpr const char* kSound = R"(source = "a survey"
date = "2012"
unit = "m"
dimensions = ["stature", "waist"]
[women]
mean = [1.63, 0.80]
standard_deviation = [0.06, 0.09]
correlation = [[0.2]]
[men]
mean = [1.76, 0.92]
standard_deviation = [0.07, 0.11]
correlation = [[0.3]]
)";

Expected<Anthropometry> load(const std::string& text) {
    const test::TemporaryFolder folder;
    const std::string path = (folder.path() / "people.toml").string();
    std::ofstream(path) << text;
    return loadAnthropometry(path);
}

std::string with(const std::string& from, const std::string& to) {
    std::string text = kSound;
    text.replace(text.find(from), from.size(), to);
    return text;
}

}  // namespace

TEST(Anthropometry, ReadsTheShippedTable) {
    const auto table = loadAnthropometry(CHEVAL_ANTHROPOMETRY);
    ASSERT_TRUE(table) << table.error().message();
    EXPECT_EQ(table->dimensions.size(), 14U);
    EXPECT_NEAR(table->women.mean[0], 1.63, 0.02);
    EXPECT_NEAR(table->men.mean[0], 1.76, 0.02);
    EXPECT_EQ(table->men.correlation.size(), 13U);
    EXPECT_FALSE(table->source.empty());
}

TEST(Anthropometry, ReadsWhatIsWritten) {
    const auto table = load(kSound);
    ASSERT_TRUE(table) << table.error().message();
    EXPECT_DOUBLE_EQ(table->women.standardDeviation[1], 0.09);
    EXPECT_DOUBLE_EQ(table->men.correlation[0][0], 0.3);
}

TEST(Anthropometry, RefusesWithLineAndKey) {
    struct Case {
        const char *from, *to, *key;
        int line;
    };
    for (const Case& c :
         {Case{"unit = \"m\"", "unit = \"cm\"", "unit", 3}, Case{"source = \"a survey\"", "source = 7", "source", 1},
          Case{"[\"stature\", \"waist\"]", "[\"stature\", 2]", "dimensions", 4},
          Case{"[1.63, 0.80]", "[1.63]", "women.mean", 6}, Case{"[1.63, 0.80]", "[1.63, nan]", "women.mean", 6},
          Case{"[0.07, 0.11]", "[0.07, 0.0]", "men.standard_deviation", 11},
          Case{"[[0.3]]", "[[1.3]]", "men.correlation[0]", 12}, Case{"[[0.3]]", "[]", "men.correlation[0]", 0},
          Case{"[men]", "[women]", "", 9}}) {
        const auto table = load(with(c.from, c.to));
        ASSERT_FALSE(table) << c.to;
        EXPECT_EQ(table.error().key, c.key) << c.to;
        if (c.line > 0) {
            EXPECT_EQ(table.error().line, c.line) << c.to;
        }
        EXPECT_FALSE(table.error().file.empty());
        EXPECT_FALSE(table.error().cause.empty());
    }
    EXPECT_FALSE(loadAnthropometry("/nowhere/people.toml"));
}

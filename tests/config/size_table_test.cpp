#include "config/size_table.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace cheval::config {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHead = R"(system = "EN 13402-3 letters"
region = "Europe"
for = "women"
source = "a test"
date = 2026-01-31
unit = "cm"
)";
constexpr std::string_view kChest = R"(chest_girth = [
    { size = "S", over = 82, to = 90 },
    { size = "M", over = 90, to = 98 },
]
)";

/// The good table with `from` in place of `to`.
std::string changed(std::string_view from, std::string_view to) {
    std::string text = std::string(kHead) + std::string(kChest);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(SizeTable, isReadInMetres) {
    const auto table = parseSizeTable(changed("Europe", "Europe"), "women.toml");
    ASSERT_TRUE(table.hasValue()) << table.error().message();
    EXPECT_EQ(table->system, "EN 13402-3 letters");
    EXPECT_EQ(table->region, "Europe");
    EXPECT_EQ(table->source, "a test");
    EXPECT_EQ(table->date, "2026-01-31");
    EXPECT_EQ(table->sizesFor, SizesFor::women);
    EXPECT_THAT(table->sizes, testing::ElementsAre("S", "M"));
    EXPECT_DOUBLE_EQ(table->bands[0][0].over, 0.82);
    EXPECT_DOUBLE_EQ(table->bands[0][1].to, 0.98);
    EXPECT_TRUE(table->bands[1].empty());
}

TEST(SizeTable, knowsItsUnits) {
    for (const auto& [unit, to, metres] :
         {std::tuple("mm", "902.5", 0.9025), std::tuple("cm", "90.25", 0.9025), std::tuple("in", "35.5", 0.9017)}) {
        std::string text(kHead);
        text.replace(text.find("cm"), 2, unit);
        const std::string over = std::string(unit) == "mm" ? "825" : std::string(unit) == "cm" ? "82.5" : "32.5";
        text.append("chest_girth = [ { size = \"S\", over = ")
            .append(over)
            .append(", to = ")
            .append(to)
            .append(" } ]\n");
        const auto table = parseSizeTable(text, "women.toml");
        ASSERT_TRUE(table.hasValue()) << table.error().message();
        EXPECT_NEAR(table->bands[0][0].to, metres, 1e-9);
    }
}

TEST(SizeTable, takesNumbersAndOwnNamesAsSizes) {
    const auto numbers = parseSizeTable(
        "system = \"numbers\"\n" + std::string(kHead.substr(kHead.find('\n') + 1)) +
            "hip_girth = [ { size = \"36\", over = 90, to = 94 }, { size = \"38\", over = 94, to = 97.5 } ]\n",
        "women.toml");
    ASSERT_TRUE(numbers.hasValue()) << numbers.error().message();
    EXPECT_THAT(numbers->sizes, testing::ElementsAre("36", "38"));
    const auto own =
        parseSizeTable("system = \"own\"\n" + std::string(kHead.substr(kHead.find('\n') + 1)) +
                           "hip_girth = [ { size = \"small\", over = 90, to = 94 }, { size = \"big\", over = 94, to = "
                           "110 } ]\n",
                       "women.toml");
    ASSERT_TRUE(own.hasValue()) << own.error().message();
}

struct BadTable {
    const char* name;
    std::string text;
    int line;
    const char* key;
    const char* cause;  ///< Part of it.
    const char* mend;   ///< Part of it.
};

void PrintTo(const BadTable& bad, std::ostream* stream) {
    *stream << bad.name;
}

class BadSizeTable : public testing::TestWithParam<BadTable> {};

TEST_P(BadSizeTable, isRefusedWithFileLineKeyCauseAndMend) {
    const BadTable& bad = GetParam();
    const auto table = parseSizeTable(bad.text, "sizes/women.toml");
    ASSERT_FALSE(table.hasValue());
    const Error& error = table.error();
    EXPECT_EQ(error.code, ErrorCode::invalidInput);
    EXPECT_EQ(error.file, "sizes/women.toml");
    EXPECT_EQ(error.line, bad.line) << error.message();
    EXPECT_EQ(error.key, bad.key);
    EXPECT_THAT(error.cause, testing::HasSubstr(bad.cause));
    EXPECT_THAT(error.mend, testing::HasSubstr(bad.mend));
    EXPECT_FALSE(error.why.empty());
}

INSTANTIATE_TEST_SUITE_P(
    SizeTable, BadSizeTable,
    testing::Values(
        BadTable{"empty", "", 0, "system", "missing", "system = "},
        BadTable{"notToml", "system = \n", 1, "", "", "correct the line"},
        BadTable{"keyTwice", changed("region", "system = \"own\"\nregion"), 2, "", "", "correct the line"},
        BadTable{"noDimension", std::string(kHead), 0, "", "no sizes", "chest_girth"},
        BadTable{"emptyDimension", std::string(kHead) + "chest_girth = []\n", 7, "chest_girth", "no list", "size = "},
        BadTable{"dimensionIsNumber", std::string(kHead) + "chest_girth = 90\n", 7, "chest_girth", "no list", "size"},
        BadTable{"unknownSystem", changed("EN 13402-3 letters", "EN 13402-3 leters"), 1, "system", "not one of",
                 "\"EN 13402-3 letters\""},
        BadTable{"systemIsNumber", changed("\"EN 13402-3 letters\"", "3"), 1, "system", "must be a text", "system ="},
        BadTable{"noSource", changed("source = \"a test\"\n", ""), 0, "source", "missing", "source ="},
        BadTable{"emptySource", changed("a test", ""), 4, "source", "empty", "1 to 200 bytes"},
        BadTable{"longSource", changed("a test", std::string(201, 'x')), 4, "source", "too long", "1 to 200 bytes"},
        BadTable{"noDate", changed("date = 2026-01-31\n", ""), 0, "date", "missing", "date = 2026"},
        BadTable{"dateIsText", changed("2026-01-31", "\"lately\""), 5, "date", "no date", "date = 2026"},
        BadTable{"dateOfAnotherCentury", changed("2026", "0026"), 5, "date", "century", "date = 2026"},
        BadTable{"noRegion", changed("region = \"Europe\"\n", ""), 0, "region", "missing", "region ="},
        BadTable{"forNobody", changed("women", "woman"), 3, "for", "not one of", "\"women\""},
        BadTable{"noUnit", changed("unit = \"cm\"\n", ""), 0, "unit", "missing", "unit ="},
        BadTable{"unknownUnit", changed("\"cm\"", "\"m\""), 6, "unit", "not one of", "\"mm\""},
        BadTable{"wrongUnit", changed("\"cm\"", "\"mm\""), 8, "chest_girth", "no girth", "500 mm to 2200 mm"},
        BadTable{"inchesAsCentimetres", std::string(kHead) + "chest_girth = [{size = \"S\", over = 32, to = 35}]\n", 7,
                 "chest_girth", "no girth", "correct the unit"},
        BadTable{"notFinite", changed("90 }", "inf }"), 8, "chest_girth", "\"to\" of \"S\" is no girth", "50 cm to"},
        BadTable{"notANumber", changed("over = 90", "over = nan"), 9, "chest_girth", "\"over\" of \"M\"", "50 cm to"},
        BadTable{"negative", changed("over = 82", "over = -82"), 8, "chest_girth", "no girth", "50 cm to"},
        BadTable{"girthIsText", changed("over = 82", "over = \"82\""), 8, "chest_girth", "no girth", "a number"},
        BadTable{"unknownDimension", changed("chest_girth", "bust_girth"), 7, "bust_girth", "no such dimension",
                 "_girth\"?"},
        BadTable{"unknownKey", changed("unit", "units"), 0, "unit", "missing", "unit ="},
        BadTable{"unknownKeyBeside", changed("region", "colour = 1\nregion"), 2, "colour", "no such dimension or key",
                 "did you mean"},
        BadTable{"bandWithoutSize", changed("size = \"S\", ", ""), 8, "chest_girth", "not written", "size = "},
        BadTable{"bandWithMore", changed("to = 90", "to = 90, ease = 4"), 8, "chest_girth", "not written", "size = "},
        BadTable{"bandIsNumber", std::string(kHead) + "chest_girth = [82, 90]\n", 7, "chest_girth", "not written",
                 "size = "},
        BadTable{"upsideDown", changed("over = 82, to = 90", "over = 90, to = 82"), 8, "chest_girth", "does not rise",
                 "lower girth as over"},
        BadTable{"nothingBetween", changed("over = 82", "over = 90"), 8, "chest_girth", "does not rise", "as over"},
        BadTable{"gap", changed("over = 90", "over = 91"), 9, "chest_girth", "gap below the band of \"M\"",
                 "over = 90 cm"},
        BadTable{"overlap", changed("over = 90", "over = 89"), 9, "chest_girth", "overlaps that of \"M\"",
                 "over = 90 cm"},
        BadTable{"descending", changed("over = 90, to = 98", "over = 74, to = 82"), 9, "chest_girth", "overlaps",
                 "over = 90 cm"},
        BadTable{"sizeTwice", changed("\"M\"", "\"S\""), 9, "chest_girth", "\"S\" is there twice", "once"},
        BadTable{"noLetter", changed("\"M\"", "\"m\""), 9, "chest_girth", "no letter code", "\"M\""},
        BadTable{"lettersOutOfOrder", changed("\"M\"", "\"XS\""), 9, "chest_girth", "\"XS\" comes after \"S\"",
                 "in the order"},
        BadTable{"longName", changed("\"M\"", "\"Mediumish\""), 9, "chest_girth", "name of a size", "1 to 7"},
        BadTable{"nameThatIsNotPlain", changed("\"M\"", "\"\\u0007\""), 9, "chest_girth", "name of a size", "1 to 7"},
        BadTable{"numbersThatFall",
                 "system = \"numbers\"\n" + std::string(kHead.substr(kHead.find('\n') + 1)) +
                     "hip_girth = [ { size = \"38\", over = 90, to = 94 }, { size = \"36\", over = 94, to = 98 } ]\n",
                 7, "hip_girth", "not more than the one before", "rise"},
        BadTable{"otherSizesInOneDimension",
                 changed("chest_girth", "hip_girth = [{ size = \"S\", over = 90, to = 98 }]\nchest_girth"), 7,
                 "hip_girth", "\"M\" has no band", "same sizes"},
        BadTable{"sizesInAnotherOrder",
                 changed("chest_girth",
                         "hip_girth = [{ size = \"M\", over = 90, to = 98 }, { size = \"S\", over = 98, "
                         "to = 106 }]\nchest_girth"),
                 7, "hip_girth", "\"M\" is not the size that comes here", "same order"}),
    [](const auto& parameters) { return parameters.param.name; });

TEST(SizeTable, isRefusedWhenItHasTooManySizes) {
    std::string text(kHead);
    text.replace(text.find("EN 13402-3 letters"), 18, "numbers");
    text += "chest_girth = [\n";
    for (int i = 0; i <= static_cast<int>(kMaximumSizesInTable); ++i)
        text += "{ size = \"" + std::to_string(30 + i) + "\", over = " + std::to_string(60 + i) +
                ", to = " + std::to_string(61 + i) + " },\n";
    const auto table = parseSizeTable(text + "]\n", "women.toml");
    ASSERT_FALSE(table.hasValue());
    EXPECT_THAT(table.error().cause, testing::HasSubstr("1 to 16 sizes"));
}

/// A folder of tables that is gone after the test.
class SizeFolder : public testing::Test {
  protected:
    void write(const std::string& name, const std::string& text) const { std::ofstream(path() / name) << text; }
    [[nodiscard]] fs::path path() const { return folder_.path(); }
    [[nodiscard]] SizeTables load() const { return loadSizeTables(path().string()); }

  private:
    test::TemporaryFolder folder_;
};

TEST_F(SizeFolder, keepsTheGoodTableBesideABadOne) {
    write("men.toml", changed("women", "men"));
    write("women.toml", changed("over = 90", "over = 91"));
    write("notes.txt", "no table");
    const SizeTables loaded = load();
    ASSERT_EQ(loaded.tables.size(), 1U);
    EXPECT_EQ(loaded.tables.front().sizesFor, SizesFor::men);
    ASSERT_EQ(loaded.refusals.size(), 1U);
    EXPECT_THAT(loaded.refusals.front().file, testing::EndsWith("women.toml"));
    EXPECT_EQ(loaded.refusals.front().line, 9);
}

TEST_F(SizeFolder, refusesASecondTableForTheSamePeople) {
    write("a.toml", changed("women", "women"));
    write("b.toml", changed("women", "women"));
    const SizeTables loaded = load();
    EXPECT_EQ(loaded.tables.size(), 1U);
    ASSERT_EQ(loaded.refusals.size(), 1U);
    EXPECT_EQ(loaded.refusals.front().key, "for");
    EXPECT_THAT(loaded.refusals.front().file, testing::EndsWith("b.toml"));
}

TEST_F(SizeFolder, refusesWhatIsNotThereOrCannotBeRead) {
    for (const SizeTables& loaded : {load(), loadSizeTables((path() / "absent").string())}) {
        EXPECT_TRUE(loaded.tables.empty());
        ASSERT_EQ(loaded.refusals.size(), 1U);
        EXPECT_EQ(loaded.refusals.front().code, ErrorCode::notFound);
        EXPECT_FALSE(loaded.refusals.front().mend.empty());
        EXPECT_FALSE(loaded.refusals.front().file.empty());
    }
    fs::create_directory(path() / "women.toml");
    ASSERT_EQ(load().refusals.size(), 1U);
    EXPECT_THAT(load().refusals.front().cause, testing::HasSubstr("cannot be read"));
}

TEST_F(SizeFolder, refusesAFileThatIsTooLarge) {
    write("women.toml", std::string(kMaximumSizeTableBytes + 1, '#'));
    const SizeTables loaded = load();
    ASSERT_EQ(loaded.refusals.size(), 1U);
    EXPECT_THAT(loaded.refusals.front().cause, testing::HasSubstr("65537 bytes"));
}

TEST(ShippedSizes, areThoseOfTheirSources) {
    const SizeTables loaded = loadSizeTables(CHEVAL_SIZES);
    for (const Error& refusal : loaded.refusals)
        ADD_FAILURE() << refusal.message();
    ASSERT_EQ(loaded.tables.size(), 2U);
    const SizeTable& men = loaded.tables[0];
    const SizeTable& women = loaded.tables[1];
    ASSERT_EQ(men.sizesFor, SizesFor::men);
    ASSERT_EQ(women.sizesFor, SizesFor::women);
    for (const SizeTable& table : loaded.tables) {
        EXPECT_THAT(table.sizes, testing::ElementsAre("XS", "S", "M", "L", "XL", "XXL"));
        EXPECT_THAT(table.source, testing::HasSubstr("secondary sources"));
    }
    const auto centimetres = [](const std::vector<SizeTableBand>& bands) {
        std::vector<int> edges;
        if (!bands.empty()) edges.push_back(static_cast<int>(std::lround(100.0 * bands.front().over)));
        for (const SizeTableBand& band : bands)
            edges.push_back(static_cast<int>(std::lround(100.0 * band.to)));
        return edges;
    };
    EXPECT_THAT(centimetres(men.bands[0]), testing::ElementsAre(78, 86, 94, 102, 110, 118, 129));
    EXPECT_THAT(centimetres(men.bands[1]), testing::ElementsAre(66, 74, 82, 90, 98, 106, 117));
    EXPECT_TRUE(men.bands[2].empty());
    EXPECT_THAT(centimetres(women.bands[0]), testing::ElementsAre(74, 82, 90, 98, 107, 119, 131));
    EXPECT_THAT(centimetres(women.bands[1]), testing::ElementsAre(58, 66, 74, 82, 91, 103, 115));
    EXPECT_THAT(centimetres(women.bands[2]), testing::ElementsAre(82, 90, 98, 106, 114, 124, 134));
}

}  // namespace
}  // namespace cheval::config

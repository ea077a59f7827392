#include "config/loader.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "config/settings_table.h"
#include "tests/support/temporary_folder.h"

namespace cheval::config {
namespace {

namespace fs = std::filesystem;

/// A settings folder that is gone after the test.
class Folder {
  public:
    Folder() { fs::create_directory(path_ / "cheval.toml.d"); }
    void write(const std::string& name, const std::string& text) const { std::ofstream(path_ / name) << text; }
    [[nodiscard]] std::string path() const { return path_.string(); }
    [[nodiscard]] LoadedSettings load(bool required = true) const {
        return loadSettings({.shippedFile = "", .folder = path(), .folderRequired = required});
    }

  private:
    test::TemporaryFolder temporary_;
    fs::path path_ = temporary_.path();
};

struct BadText {
    const char* name;
    const char* text;
    int line;
    const char* key;
    const char* cause;  ///< Part of it.
    const char* mend;   ///< Part of it.
};

void PrintTo(const BadText& bad, std::ostream* stream) {
    *stream << bad.name;
}

class BadInput : public testing::TestWithParam<BadText> {};

TEST_P(BadInput, isRefusedWithFileLineKeyCauseAndMend) {
    const BadText& bad = GetParam();
    const LoadedSettings loaded = loadSettingsText(bad.text, "/etc/cheval/cheval.toml");
    ASSERT_FALSE(loaded.good());
    const Error& problem = loaded.problems.front();
    EXPECT_EQ(problem.file, "/etc/cheval/cheval.toml");
    EXPECT_EQ(problem.line, bad.line);
    EXPECT_EQ(problem.key, bad.key);
    EXPECT_THAT(problem.cause, testing::HasSubstr(bad.cause));
    EXPECT_THAT(problem.mend, testing::HasSubstr(bad.mend));
    EXPECT_FALSE(problem.why.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Loader, BadInput,
    testing::Values(
        BadText{"unknownKey", "[sensor]\nheigth_mm = 1200\n", 2, "sensor.heigth_mm", "no such setting",
                "sensor.height_mm"},
        BadText{"unknownSection", "\n[sensr]\nheight_mm = 1200\n", 3, "sensr.height_mm", "no section [sensr]",
                "sensor.height_mm"},
        BadText{"emptyUnknownSection", "[dispaly]\n", 1, "dispaly", "no such setting", "\"display\""},
        BadText{"keyOutsideSections", "height_mm = 1200\n", 1, "height_mm", "no such setting", "sensor.height_mm"},
        BadText{"keyInTheWrongSection", "[display]\nfps = 20\n", 2, "display.fps", "no such setting", "loop.fps"},
        BadText{"sectionAsKey", "sensor = 3\n", 1, "sensor", "is a section", "[sensor]"},
        BadText{"arrayOfTables", "[[sensor]]\nheight_mm = 1\n", 1, "sensor", "is a section", "[sensor]"},
        BadText{"textForNumber", "[sensor]\nheight_mm = \"tall\"\n", 2, "sensor.height_mm",
                "is a text but must be a number", "height_mm = 0.0"},
        BadText{"numberForFlag", "[preview]\nenabled = 1\n", 2, "preview.enabled", "whole number but must be",
                "enabled = false"},
        BadText{"textForFlag", "[preview]\nenabled = \"yes\"\n", 2, "preview.enabled", "text but must be",
                "enabled = false"},
        BadText{"realForInteger", "[display]\nwidth = 1080.5\n", 2, "display.width", "must be a whole number",
                "width = 1080"},
        BadText{"dateForNumber", "[sensor]\ntilt_deg = 2020-01-01\n", 2, "sensor.tilt_deg", "date", "tilt_deg = 0.0"},
        BadText{"tooGreat", "[display]\nwidth = 100000\n", 2, "display.width", "100000 is out of range",
                "from 120 to 4320 pixels"},
        BadText{"tooSmall", "[sensor]\ntilt_deg = -45.5\n", 2, "sensor.tilt_deg", "-45.5 is out of range",
                "from -45.0 to 45.0 degrees"},
        BadText{"hugeInteger", "[preview]\nport = 9223372036854775807\n", 2, "preview.port", "out of range", "65535"},
        BadText{"integerBeyond64Bits", "[preview]\nport = 92233720368547758079\n", 2, "", "", "correct the line"},
        BadText{"notANumber", "[sensor]\nheight_mm = nan\n", 2, "sensor.height_mm", "not a finite number",
                "from 0.0 to 3000.0 mm"},
        BadText{"infinite", "[loop]\nfps = +inf\n", 2, "loop.fps", "not a finite number", "5.0 to 60.0 Hz"},
        BadText{"unknownChoice", "[display]\nkind = \"previw\"\n", 2, "display.kind",
                "not one of \"headless\", \"preview\"", "\"preview\""},
        BadText{"choiceAsNumber", "[display]\nkind = 2\n", 2, "display.kind", "must be one of", "headless"},
        BadText{"duplicateKey", "[sensor]\ntilt_deg = 1\ntilt_deg = 2\n", 3, "", "", "correct the line"},
        BadText{"duplicateSection", "[sensor]\n[sensor]\n", 2, "", "", "correct the line"},
        BadText{"brokenLine", "[sensor]\ntilt_deg =\n", 2, "", "", "correct the line"},
        BadText{"notUtf8", "[sensor]\n\xff\xfe = 1\n", 1, "", "", "correct the line"},
        BadText{"listOfNumbers", "[wardrobe]\ngarments = [1, 2]\n", 2, "wardrobe.garments", "must be a list of texts",
                "tshirt"},
        BadText{"listNamesTwice", "[wardrobe]\ngarments = [\"a\", \"a\"]\n", 2, "wardrobe.garments", "twice", "once"},
        BadText{"garmentWithFolder", "[wardrobe]\ngarments = [\"../../x\"]\noutfits = []\n", 2, "wardrobe.garments",
                "not a garment's name", "without folder"},
        BadText{"outfitOfUnknownGarment", "[wardrobe]\noutfits = [\"tshirts\"]\n", 2, "wardrobe.outfits",
                "names \"tshirts\"", "\"tshirt\""},
        BadText{"unknownStart", "[wardrobe]\nstart_outfit = \"tshrt\"\n", 2, "wardrobe.start_outfit",
                "not in wardrobe.outfits", "\"tshirt\""},
        BadText{"replayWithoutFolder", "[sensor]\nsource = \"replay\"\n", 2, "sensor.source", "no recording",
                "sensor.folder"},
        BadText{"previewNotEnabled", "[display]\nkind = \"preview\"\n", 2, "display.kind", "not enabled",
                "preview.enabled"},
        BadText{"swipeOverBeforeItBegins", "[gestures]\nswipe_end_speed = 0.5\n", 2, "gestures.swipe_end_speed",
                "over before it begins", "at most gestures.swipe_start_speed"},
        BadText{"swipeThatCannotBegin", "[gestures]\nswipe_start_speed = 0.2\n", 2, "gestures.swipe_start_speed",
                "over before it begins", "at most gestures.swipe_start_speed"},
        BadText{"swipeStartAboveItsPeak", "[gestures]\nswipe_start_speed = 0.7\n", 2, "gestures.swipe_start_speed",
                "faster than it need be", "at least gestures.swipe_start_speed"},
        BadText{"swipePeakUnderItsStart", "[gestures]\nswipe_peak_speed = 0.4\n", 2, "gestures.swipe_peak_speed",
                "faster than it need be", "at least gestures.swipe_start_speed"},
        BadText{"grabLongerThanItMay", "[gestures]\n\ngrab_closed_longest_s = 0.1\n", 3,
                "gestures.grab_closed_longest_s", "longer than it may", "less than gestures.grab_closed_longest_s"},
        BadText{"holdThatNeverEnds", "[gestures]\nhold_away = 0.03\n", 2, "gestures.hold_away",
                "away and still at once", "less than gestures.hold_away"},
        BadText{"unknownMeaningOfHold", "[session]\nhold = \"veiw\"\n", 2, "session.hold",
                "not one of \"view\", \"nothing\"", "\"view\""},
        BadText{"zoneInsideOut", "[zone]\nnear_m = 5.0\nfar_m = 1.0\n", 2, "zone.near_m", "ends before", "less"}),
    [](const testing::TestParamInfo<BadText>& parameter) { return parameter.param.name; });

TEST(Loader, withoutFilesGivesTheDefaults) {
    const LoadedSettings loaded = loadSettings({.shippedFile = "/nonexistent/cheval.toml", .folder = "/nonexistent"});
    EXPECT_TRUE(loaded.good());
    EXPECT_EQ(describeSettings(loaded.settings, {}), describeSettings(defaultSettings(), {}));
    EXPECT_FALSE(loaded.settings.preview.enabled);
}

TEST(Loader, readsDropInsInTheOrderOfTheirNamesOverTheFile) {
    const Folder folder;
    folder.write("cheval.toml", "[sensor]\ntilt_deg = 1\nroll_deg = 1\n[loop]\nfps = 20\n");
    folder.write("cheval.toml.d/20-later.toml", "[sensor]\ntilt_deg = 3\n");
    folder.write("cheval.toml.d/10-early.toml", "[sensor]\ntilt_deg = 2\nroll_deg = 2\n");
    folder.write("cheval.toml.d/30-not-toml.bak", "rubbish");
    folder.write("cheval.toml.d/.40-hidden.toml", "rubbish");
    const LoadedSettings loaded = folder.load();
    ASSERT_TRUE(loaded.good()) << loaded.problems.front().message();
    EXPECT_EQ(loaded.settings.sensor.tiltDeg, 3.0);
    EXPECT_EQ(loaded.settings.sensor.rollDeg, 2.0);
    EXPECT_EQ(loaded.settings.loop.fps, 20.0);
    EXPECT_EQ(loaded.files.size(), 3U);
    EXPECT_THAT(describeSettings(loaded.settings, loaded.origins),
                testing::HasSubstr("tilt_deg = 3.0  # " + folder.path() + "/cheval.toml.d/20-later.toml:2"));
}

TEST(Loader, readsTheShippedFileBelowThePeoples) {
    const Folder folder;
    folder.write("shipped.toml", "[loop]\nfps = 20\nbudget_scale = 2\n");
    folder.write("cheval.toml", "[loop]\nfps = 25\n");
    const LoadedSettings loaded =
        loadSettings({.shippedFile = folder.path() + "/shipped.toml", .folder = folder.path()});
    ASSERT_TRUE(loaded.good());
    EXPECT_EQ(loaded.settings.loop.fps, 25.0);
    EXPECT_EQ(loaded.settings.loop.budgetScale, 2.0);
}

TEST(Loader, takesRelativePathsFromTheFileThatSetsThem) {
    const Folder folder;
    folder.write("cheval.toml.d/replay.toml", "[sensor]\nsource = \"replay\"\nfolder = \"../frames\"\n");
    const LoadedSettings loaded = folder.load();
    ASSERT_TRUE(loaded.good());
    EXPECT_EQ(loaded.settings.sensor.folder, folder.path() + "/frames");
}

TEST(Loader, refusesANamedFolderWithoutSettings) {
    const LoadedSettings loaded =
        loadSettings({.shippedFile = "", .folder = "/nonexistent/etc", .folderRequired = true});
    ASSERT_FALSE(loaded.good());
    EXPECT_EQ(loaded.problems.front().file, "/nonexistent/etc");
    EXPECT_EQ(loaded.problems.front().code, ErrorCode::notFound);
}

TEST(Loader, refusesAFolderInPlaceOfAFileAndAnOversizedFile) {
    const Folder folder;
    fs::create_directory(folder.path() + "/cheval.toml");
    folder.write("cheval.toml.d/big.toml", std::string(kMaximumFileBytes + 1, '#'));
    const LoadedSettings loaded = folder.load();
    ASSERT_EQ(loaded.problems.size(), 2U);
    EXPECT_EQ(loaded.problems[0].code, ErrorCode::unavailable);
    EXPECT_THAT(loaded.problems[1].mend, testing::HasSubstr("keep settings files under"));
}

TEST(Loader, refusesAPipeInsteadOfWaitingForItsWriter) {
    const Folder folder;
    ASSERT_EQ(mkfifo((folder.path() + "/cheval.toml").c_str(), 0600), 0);
    const LoadedSettings loaded = folder.load();
    ASSERT_EQ(loaded.problems.size(), 1U);
    EXPECT_EQ(loaded.problems[0].code, ErrorCode::unavailable);
    EXPECT_EQ(loaded.problems[0].file, folder.path() + "/cheval.toml");
}

TEST(Loader, reportsEveryProblemUpToABound) {
    const LoadedSettings two =
        loadSettingsText("[sensor]\ntilt_deg = 99\nrol_deg = 1\n[loop]\nfps = \"x\"\n", "a.toml");
    EXPECT_EQ(two.problems.size(), 3U);
    std::string many = "[sensor]\n";
    for (int i = 0; i < 200; ++i)
        many += "k" + std::to_string(i) + " = 1\n";
    EXPECT_EQ(loadSettingsText(many, "a.toml").problems.size(), kMaximumProblems);
}

TEST(Loader, keepsWhatItUnderstoodFitToBeUsedTogether) {
    const LoadedSettings loaded = loadSettingsText(
        "[preview]\nenabled = true\n[display]\nkind = \"preview\"\nwidth = 1\n[zone]\nnear_m = 5.0\nfar_m = 1.0\n"
        "[wardrobe]\ngarments = [\"coat\"]\noutfits = [\"tshirt\"]\n",
        "a.toml");
    ASSERT_EQ(loaded.problems.size(), 1U);
    EXPECT_EQ(loaded.settings.display.kind, DisplayKind::preview);
    EXPECT_EQ(loaded.settings.display.width, 1080);
    EXPECT_LT(loaded.settings.zone.nearMetres, loaded.settings.zone.farMetres);
    EXPECT_EQ(loaded.settings.wardrobe.garments, defaultSettings().wardrobe.garments);
}

TEST(Loader, takesGesturesThatDoNotGoTogetherAllBackToTheirDefaults) {
    const LoadedSettings loaded = loadSettingsText(
        "[gestures]\nswipe_start_speed = 0.2\nswipe_end_speed = 0.3\nswipe_peak_speed = 0.3\nswipe_distance = 0.2\n"
        "grab_closed_least_s = 5\n",
        "a.toml");
    EXPECT_EQ(loaded.problems.size(), 2U) << "one a rule";
    const auto& gestures = loaded.settings.gestures;
    const auto& usual = defaultSettings().gestures;
    EXPECT_EQ(gestures.swipeStartSpeed, usual.swipeStartSpeed);
    EXPECT_EQ(gestures.swipeEndSpeed, usual.swipeEndSpeed);
    EXPECT_EQ(gestures.swipePeakSpeed, usual.swipePeakSpeed);
    EXPECT_EQ(gestures.swipeDistance, 0.2) << "what goes with the others stays";
    EXPECT_EQ(gestures.grabClosedLeastSeconds, usual.grabClosedLeastSeconds);
}

TEST(Loader, acceptsWholeNumbersWhereNumbersAreMeant) {
    const LoadedSettings loaded = loadSettingsText("sensor.height_mm = 1400\n[loop]\nfps = 15\n", "a.toml");
    ASSERT_TRUE(loaded.good());
    EXPECT_EQ(loaded.settings.sensor.heightMm, 1400.0);
}

TEST(Loader, offersWhatTheNamedGarmentsAllow) {
    const LoadedSettings fewer = loadSettingsText("[wardrobe]\ngarments = [\"trousers\"]\n", "/a.toml");
    ASSERT_TRUE(fewer.good()) << fewer.problems.front().message();
    EXPECT_EQ(fewer.settings.wardrobe.outfits, std::vector<std::string>{"trousers"});
    EXPECT_EQ(fewer.settings.wardrobe.startOutfit, "trousers");
    const LoadedSettings others = loadSettingsText("[wardrobe]\ngarments = [\"coat\", \"hat\"]\n", "/a.toml");
    ASSERT_TRUE(others.good()) << others.problems.front().message();
    EXPECT_EQ(others.settings.wardrobe.outfits, (std::vector<std::string>{"coat", "hat"}));
    EXPECT_EQ(others.settings.wardrobe.startOutfit, "coat");
}

TEST(Loader, describesWhatItCanReadBack) {
    Settings settings = defaultSettings();
    settings.sensor.folder = "/data/\"quoted\"\\and\ttabbed";
    settings.sensor.source = SensorSource::replay;
    settings.sensor.heightMm = 1234.5;
    settings.wardrobe.garments.emplace_back("coat");
    settings.preview.enabled = true;
    const std::string text = describeSettings(settings, {});
    const LoadedSettings loaded = loadSettingsText(text, "/a.toml");
    ASSERT_TRUE(loaded.good()) << loaded.problems.front().message();
    EXPECT_EQ(describeSettings(loaded.settings, {}), text);
    EXPECT_EQ(loaded.settings.sensor.folder, settings.sensor.folder);
}

TEST(Loader, shipsADefaultsFileThatEqualsTheTable) {
    std::ifstream stream(CHEVAL_SOURCE "/config/cheval.toml");
    std::stringstream text;
    text << stream.rdbuf();
    EXPECT_EQ(text.str(), describeSettings(defaultSettings(), {}))
        << "make it again with: chevalctl config show --defaults";
}

}  // namespace
}  // namespace cheval::config

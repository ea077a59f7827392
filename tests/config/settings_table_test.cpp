#include "config/settings_table.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace cheval::config {
namespace {

TEST(SettingsTable, namesEachSettingOnceInAKnownSection) {
    std::set<std::string_view> sections;
    for (const Section& section : settingsSections()) {
        EXPECT_TRUE(sections.insert(section.name).second) << section.name;
        EXPECT_FALSE(section.sentence.empty());
    }
    std::set<std::string_view> paths;
    for (const Setting& setting : settingsTable()) {
        EXPECT_TRUE(paths.insert(setting.path).second) << setting.path;
        EXPECT_TRUE(sections.contains(setting.section)) << setting.path;
        EXPECT_TRUE(setting.sentence.ends_with('.')) << setting.path;
    }
    EXPECT_GT(paths.size(), 30U);
}

TEST(SettingsTable, holdsDefaultsInsideTheirRanges) {
    for (const Setting& setting : settingsTable()) {
        if (const double* real = std::get_if<double>(&setting.fallback)) {
            EXPECT_LE(setting.low, *real) << setting.path;
            EXPECT_GE(setting.high, *real) << setting.path;
        }
        if (const auto* integer = std::get_if<std::int64_t>(&setting.fallback)) {
            EXPECT_LE(setting.low, static_cast<double>(*integer)) << setting.path;
            EXPECT_GE(setting.high, static_cast<double>(*integer)) << setting.path;
        }
        if (setting.kind == SettingKind::choice) {
            const auto names = choiceNames(setting);
            EXPECT_GT(names.size(), 1U) << setting.path;
            EXPECT_NE(std::find(names.begin(), names.end(), std::get<std::string>(setting.fallback)), names.end())
                << setting.path;
        }
    }
}

TEST(SettingsTable, givesBackEveryValueThatItIsGiven) {
    for (const Setting& setting : settingsTable()) {
        Settings settings = defaultSettings();
        EXPECT_EQ(setting.get(settings), setting.fallback) << setting.path;
        SettingValue other = setting.fallback;
        if (auto* flag = std::get_if<bool>(&other)) *flag = !*flag;
        if (auto* integer = std::get_if<std::int64_t>(&other)) ++*integer;
        if (auto* real = std::get_if<double>(&other)) *real += 0.25;
        if (auto* texts = std::get_if<std::vector<std::string>>(&other)) texts->push_back("more");
        if (setting.kind == SettingKind::choice) {
            other = std::string(choiceNames(setting).back());
        } else if (auto* text = std::get_if<std::string>(&other)) {
            *text += "more";
        }
        setting.set(settings, other);
        EXPECT_EQ(setting.get(settings), other) << setting.path;
        setting.set(settings, setting.fallback);
        for (const Setting& any : settingsTable())
            EXPECT_EQ(any.get(settings), any.fallback) << setting.path << " disturbs " << any.path;
    }
}

TEST(SettingsTable, writesTomlThatTellsRealFromWhole) {
    EXPECT_EQ(toToml(SettingValue(1.0)), "1.0");
    EXPECT_EQ(toToml(SettingValue(0.1)), "0.1");
    EXPECT_EQ(toToml(SettingValue(1e300)), "1e+300");
    EXPECT_EQ(toToml(SettingValue(std::int64_t{7})), "7");
    EXPECT_EQ(toToml(SettingValue(std::string("a\"b\n"))), "\"a\\\"b\\u000A\"");
    EXPECT_EQ(toToml(SettingValue(std::vector<std::string>{"a", "b"})), "[\"a\", \"b\"]");
}

}  // namespace
}  // namespace cheval::config

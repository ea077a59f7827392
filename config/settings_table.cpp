#include "config/settings_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>

namespace cheval::config {

namespace {

std::size_t choiceIndex(std::string_view names, std::string_view name) {
    std::size_t index = 0;
    for (std::size_t begin = 0; begin <= names.size(); ++index) {
        const std::size_t end = std::min(names.find('|', begin), names.size());
        if (names.substr(begin, end - begin) == name) return index;
        begin = end + 1;
    }
    return 0;
}

std::string choiceName(std::string_view names, std::size_t index) {
    std::size_t begin = 0;
    for (; index > 0; --index) {
        const std::size_t end = names.find('|', begin);
        if (end == std::string_view::npos) return {};
        begin = end + 1;
    }
    return std::string(names.substr(begin, std::min(names.find('|', begin), names.size()) - begin));
}

/// The defaults of list settings, written as TOML arrays of plain texts in the table.
std::vector<std::string> textsOf(std::string_view array) {
    std::vector<std::string> texts;
    for (std::size_t begin = array.find('"'); begin != std::string_view::npos;) {
        const std::size_t end = array.find('"', begin + 1);
        texts.emplace_back(array.substr(begin + 1, end - begin - 1));
        begin = array.find('"', end + 1);
    }
    return texts;
}

// NOLINTBEGIN(bugprone-macro-parentheses): names and types in place of arguments cannot stand in parentheses.
std::vector<Setting> makeTable() {
    return {
#define CHEVAL_SECTION(section, sentence)
#define CHEVAL_SECTION_END(section)
#define CHEVAL_ROW(sectionName, keyName, kindOf, unitName, lowest, highest, names, words, value, getter, setter) \
    Setting{.section = #sectionName,                                                                             \
            .key = keyName,                                                                                      \
            .path = #sectionName "." keyName,                                                                    \
            .kind = SettingKind::kindOf,                                                                         \
            .unit = unitName,                                                                                    \
            .low = static_cast<double>(lowest),                                                                  \
            .high = static_cast<double>(highest),                                                                \
            .choices = names,                                                                                    \
            .sentence = words,                                                                                   \
            .fallback = value,                                                                                   \
            .get = [](const Settings& s) -> SettingValue { return getter; },                                     \
            .set = [](Settings& s, const SettingValue& v) { setter; }},
#define CHEVAL_FLAG(section, member, key, fallback, sentence)                          \
    CHEVAL_ROW(section, key, flag, "", 0, 0, "", sentence, fallback, s.section.member, \
               s.section.member = std::get<bool>(v))
#define CHEVAL_INTEGER(section, member, key, fallback, unit, low, high, sentence)                              \
    CHEVAL_ROW(section, key, integer, unit, low, high, "", sentence, std::int64_t{fallback}, s.section.member, \
               s.section.member = std::get<std::int64_t>(v))
#define CHEVAL_REAL(section, member, key, fallback, unit, low, high, sentence)                \
    CHEVAL_ROW(section, key, real, unit, low, high, "", sentence, fallback, s.section.member, \
               s.section.member = std::get<double>(v))
#define CHEVAL_TEXT(section, member, key, fallback, longest, sentence)                                    \
    CHEVAL_ROW(section, key, text, "", 0, longest, "", sentence, std::string(fallback), s.section.member, \
               s.section.member = std::get<std::string>(v))
#define CHEVAL_PATH(section, member, key, fallback, sentence)                                          \
    CHEVAL_ROW(section, key, path, "", 0, 4096, "", sentence, std::string(fallback), s.section.member, \
               s.section.member = std::get<std::string>(v))
#define CHEVAL_TEXTS(section, member, key, fallback, most, sentence)                                \
    CHEVAL_ROW(section, key, texts, "", 0, most, "", sentence, textsOf(fallback), s.section.member, \
               s.section.member = std::get<std::vector<std::string>>(v))
#define CHEVAL_CHOICE(section, member, key, type, fallback, names, sentence)            \
    CHEVAL_ROW(section, key, choice, "", 0, 0, names, sentence, std::string(#fallback), \
               choiceName(names, static_cast<std::size_t>(s.section.member)),           \
               s.section.member = static_cast<type>(choiceIndex(names, std::get<std::string>(v))))
#include "config/settings.def"
#undef CHEVAL_ROW
    };
}

// NOLINTEND(bugprone-macro-parentheses)

constexpr std::array kSections = {
#define CHEVAL_SECTION(section, sentence) Section{#section, sentence},
#define CHEVAL_SECTION_END(section)
#define CHEVAL_FLAG(section, member, key, fallback, sentence)
#define CHEVAL_INTEGER(section, member, key, fallback, unit, low, high, sentence)
#define CHEVAL_REAL(section, member, key, fallback, unit, low, high, sentence)
#define CHEVAL_TEXT(section, member, key, fallback, longest, sentence)
#define CHEVAL_PATH(section, member, key, fallback, sentence)
#define CHEVAL_TEXTS(section, member, key, fallback, most, sentence)
#define CHEVAL_CHOICE(section, member, key, type, fallback, names, sentence)
#include "config/settings.def"
};

std::string quoted(std::string_view text) {
    static constexpr std::string_view kHex = "0123456789ABCDEF";
    std::string result = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            result += '\\';
            result += c;
        } else if (byte < 0x20U || byte == 0x7FU) {
            result += "\\u00";
            result += kHex[byte >> 4U];
            result += kHex[byte & 15U];
        } else {
            result += c;
        }
    }
    return result + '"';
}

std::string numeral(double value) {
    std::array<char, 32> digits{};
    const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    std::string text(digits.data(), written.ptr);
    // TOML tells real numbers from whole ones by the point.
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
}

}  // namespace

std::span<const Setting> settingsTable() {
    static const std::vector<Setting> kTable = makeTable();
    return kTable;
}

std::span<const Section> settingsSections() {
    return kSections;
}

Settings defaultSettings() {
    Settings settings;
    for (const Setting& setting : settingsTable())
        setting.set(settings, setting.fallback);
    return settings;
}

std::vector<std::string_view> choiceNames(const Setting& setting) {
    std::vector<std::string_view> names;
    for (std::size_t begin = 0; begin <= setting.choices.size() && !setting.choices.empty();) {
        const std::size_t end = std::min(setting.choices.find('|', begin), setting.choices.size());
        names.push_back(setting.choices.substr(begin, end - begin));
        begin = end + 1;
    }
    return names;
}

std::string_view kindName(SettingKind kind) {
    switch (kind) {
        case SettingKind::flag:
            return "true or false";
        case SettingKind::integer:
            return "whole number";
        case SettingKind::real:
            return "number";
        case SettingKind::text:
            return "text";
        case SettingKind::path:
            return "path";
        case SettingKind::texts:
            return "list of texts";
        case SettingKind::choice:
            return "choice";
    }
    return "";
}

std::string toToml(const SettingValue& value) {
    if (const bool* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
    if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
    if (const double* real = std::get_if<double>(&value)) return numeral(*real);
    if (const auto* text = std::get_if<std::string>(&value)) return quoted(*text);
    std::string array = "[";
    for (const std::string& text : std::get<std::vector<std::string>>(value)) {
        if (array.size() > 1) array += ", ";
        array += quoted(text);
    }
    return array + "]";
}

}  // namespace cheval::config

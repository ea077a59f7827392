#include "config/toml_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "config/nearest_name.h"
#include "config/settings_table.h"
#include "config/toml_library.h"

namespace cheval::config {

namespace {

std::string example(const Setting& setting) {
    return std::string(setting.key) + " = " + toToml(setting.fallback);
}

std::string rangeOf(const Setting& setting) {
    std::string low = toToml(setting.low);
    std::string high = toToml(setting.high);
    if (setting.kind == SettingKind::integer) {
        low = std::to_string(static_cast<std::int64_t>(setting.low));
        high = std::to_string(static_cast<std::int64_t>(setting.high));
    }
    std::string range = "from " + low + " to " + high;
    if (!setting.unit.empty()) range += " " + std::string(setting.unit);
    return range;
}

/// One value on its way from a file into the settings.
class ValueReader {
  public:
    ValueReader(const Setting& setting, const toml::node& node, const std::string& file)
        : setting_(setting), node_(node), file_(file) {}

    Expected<SettingValue> read() const {
        switch (setting_.kind) {
            case SettingKind::flag:
                return readFlag();
            case SettingKind::integer:
                return readInteger();
            case SettingKind::real:
                return readReal();
            case SettingKind::text:
                return readText();
            case SettingKind::path:
                return readPath();
            case SettingKind::texts:
                return readTexts();
            case SettingKind::choice:
                return readChoice();
        }
        return wrongType();
    }

  private:
    [[nodiscard]] Error problem(std::string cause, std::string mend) const {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = std::move(cause),
                     .mend = std::move(mend),
                     .why = std::string(setting_.sentence),
                     .file = file_,
                     .line = lineOf(node_.source()),
                     .key = std::string(setting_.path)};
    }
    [[nodiscard]] Error wrongType() const {
        // A line's number, say, is a text too: quoted it is what was meant.
        if (const auto number = node_.value_exact<std::int64_t>(); number && setting_.kind == SettingKind::text) {
            return problem("is a whole number but must be a text",
                           "write it like: " + std::string(setting_.key) + " = \"" + std::to_string(*number) + "\"");
        }
        return problem("is " + std::string(typeName(node_)) + " but must be a " + std::string(kindName(setting_.kind)),
                       "write it like: " + example(setting_));
    }
    [[nodiscard]] Error outOfRange(const std::string& value) const {
        return problem(value + " is out of range", "give a value " + rangeOf(setting_));
    }

    [[nodiscard]] Expected<SettingValue> readFlag() const {
        const auto value = node_.value_exact<bool>();
        if (!value) return wrongType();
        return SettingValue(*value);
    }
    [[nodiscard]] Expected<SettingValue> readInteger() const {
        const auto value = node_.value_exact<std::int64_t>();
        if (!value) return wrongType();
        const auto real = static_cast<double>(*value);
        if (real < setting_.low || real > setting_.high) return outOfRange(std::to_string(*value));
        return SettingValue(*value);
    }
    [[nodiscard]] Expected<SettingValue> readReal() const {
        std::optional<double> value = node_.value_exact<double>();
        if (const auto whole = node_.value_exact<std::int64_t>()) value = static_cast<double>(*whole);
        if (!value) return wrongType();
        if (!std::isfinite(*value)) return problem("is not a finite number", "give a value " + rangeOf(setting_));
        if (*value < setting_.low || *value > setting_.high) return outOfRange(toToml(*value));
        return SettingValue(*value);
    }
    [[nodiscard]] Expected<SettingValue> readText() const {
        auto value = node_.value_exact<std::string>();
        if (!value) return wrongType();
        if (static_cast<double>(value->size()) > setting_.high) {
            return problem("the text is too long",
                           "shorten it to " + toToml(static_cast<std::int64_t>(setting_.high)) + " bytes");
        }
        if (value->find('\0') != std::string::npos) return problem("the text holds a zero byte", "remove it");
        return SettingValue(std::move(*value));
    }
    [[nodiscard]] Expected<SettingValue> readPath() const {
        Expected<SettingValue> text = readText();
        if (!text) return text;
        const std::filesystem::path path(std::get<std::string>(*text));
        if (path.empty() || path.is_absolute()) return text;
        const std::filesystem::path folder = std::filesystem::path(file_).parent_path();
        return SettingValue((folder / path).lexically_normal().string());
    }
    [[nodiscard]] Expected<SettingValue> readTexts() const {
        const toml::array* array = node_.as_array();
        if (array == nullptr) return wrongType();
        if (static_cast<double>(array->size()) > setting_.high) {
            return problem("the list has " + std::to_string(array->size()) + " entries",
                           "keep at most " + std::to_string(static_cast<std::int64_t>(setting_.high)));
        }
        std::vector<std::string> texts;
        for (const toml::node& entry : *array) {
            auto text = entry.value_exact<std::string>();
            if (!text) return wrongType();
            if (text->empty() || text->size() > 200 || text->find('\0') != std::string::npos) {
                return problem("an entry of the list is empty or too long", "give names of 1 to 200 bytes");
            }
            if (std::find(texts.begin(), texts.end(), *text) != texts.end()) {
                return problem("\"" + *text + "\" is in the list twice", "name it once");
            }
            texts.push_back(std::move(*text));
        }
        return SettingValue(std::move(texts));
    }
    [[nodiscard]] Expected<SettingValue> readChoice() const {
        auto value = node_.value_exact<std::string>();
        const std::vector<std::string_view> names = choiceNames(setting_);
        std::string all;
        for (const std::string_view name : names)
            all += (all.empty() ? "" : ", ") + ("\"" + std::string(name) + "\"");
        if (!value)
            return problem("is " + std::string(typeName(node_)) + " but must be one of " + all,
                           "write it like: " + example(setting_));
        if (std::find(names.begin(), names.end(), *value) == names.end()) {
            return problem("\"" + value->substr(0, 80) + "\" is not one of " + all,
                           "did you mean \"" + std::string(nearestName(*value, names)) + "\"?");
        }
        return SettingValue(std::move(*value));
    }

    const Setting& setting_;
    const toml::node& node_;
    const std::string& file_;
};

/// What was meant by a key that nobody reads: the same key of another section, or the nearest name.
std::string_view meant(std::string_view key, std::string_view path, std::span<const std::string_view> paths) {
    for (const Setting& setting : settingsTable()) {
        if (setting.key == key) return setting.path;
    }
    return nearestName(path, paths);
}

void refuseLeftovers(const toml::table& left, const std::string& file, LoadedSettings& loaded) {
    static constexpr std::string_view kWhy = "a setting that nobody reads is most often a slip of the pen";
    std::vector<std::string_view> sections;
    for (const Section& section : settingsSections())
        sections.push_back(section.name);
    std::vector<std::string_view> paths;
    for (const Setting& setting : settingsTable())
        paths.push_back(setting.path);

    for (const auto& [name, node] : left) {
        const std::string section(name.str());
        const toml::table* table = node.as_table();
        const bool known = std::find(sections.begin(), sections.end(), section) != sections.end();
        if (table == nullptr || (!known && table->empty())) {
            std::string mend = known
                                   ? "write [" + section + "] on a line of its own and its keys below it"
                                   : "did you mean \"" +
                                         std::string(nearestName(section, table == nullptr ? paths : sections)) + "\"?";
            addProblem(loaded, Error{.code = ErrorCode::invalidInput,
                                     .cause = known ? "is a section, not a key" : "there is no such setting",
                                     .mend = std::move(mend),
                                     .why = std::string(kWhy),
                                     .file = file,
                                     .line = lineOf(name.source()),
                                     .key = section.substr(0, 80)});
            continue;
        }
        for (const auto& [key, value] : *table) {
            const std::string path = section + "." + std::string(key.str());
            addProblem(loaded, Error{.code = ErrorCode::invalidInput,
                                     .cause = known ? "there is no such setting"
                                                    : "there is no section [" + section.substr(0, 80) + "]",
                                     .mend = "did you mean \"" + std::string(meant(key.str(), path, paths)) + "\"?",
                                     .why = std::string(kWhy),
                                     .file = file,
                                     .line = lineOf(key.source()),
                                     .key = path.substr(0, 160)});
        }
    }
}

}  // namespace

void addProblem(LoadedSettings& loaded, Error problem) {
    if (loaded.problems.size() < kMaximumProblems) loaded.problems.push_back(std::move(problem));
}

void readToml(std::string_view text, const std::string& file, LoadedSettings& loaded) {
    toml::parse_result parsed = toml::parse(text);
    if (!parsed) {
        const toml::parse_error& error = parsed.error();
        addProblem(loaded, Error{.code = ErrorCode::invalidInput,
                                 .cause = std::string(error.description()),
                                 .mend = "correct the line, or remove the file to return to the defaults",
                                 .why = "settings are TOML 1.0; a key may stand once in a file",
                                 .file = file,
                                 .line = lineOf(error.source())});
        return;
    }
    toml::table& root = parsed.table();
    const std::span<const Setting> table = settingsTable();
    for (std::size_t i = 0; i < table.size(); ++i) {
        const Setting& setting = table[i];
        toml::node* sectionNode = root.get(setting.section);
        toml::table* section = sectionNode == nullptr ? nullptr : sectionNode->as_table();
        const toml::node* node = section == nullptr ? nullptr : section->get(setting.key);
        if (node == nullptr) continue;
        const int line = lineOf(node->source());
        Expected<SettingValue> value = ValueReader(setting, *node, file).read();
        if (value) {
            setting.set(loaded.settings, *value);
            loaded.origins[i] = {.file = file, .line = line};
        } else {
            addProblem(loaded, std::move(value).error());
        }
        section->erase(setting.key);
    }
    refuseLeftovers(root, file, loaded);
}

}  // namespace cheval::config

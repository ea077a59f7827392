// The settings table as data: what the loader checks against and what `chevalctl config show` prints.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/settings.h"

namespace cheval::config {

enum class SettingKind : std::uint8_t { flag, integer, real, text, path, texts, choice };

/// A setting's value; a choice is held by its name.
using SettingValue = std::variant<bool, std::int64_t, double, std::string, std::vector<std::string>>;

/// One row of the table. Immutable.
struct Setting {
    std::string_view section;  ///< E.g. "sensor".
    std::string_view key;      ///< E.g. "height_mm".
    std::string_view path;     ///< Both: "sensor.height_mm".
    SettingKind kind = SettingKind::flag;
    std::string_view unit;  ///< Empty where there is none.
    double low = 0.0;       ///< Range of numbers; for texts and lists, `high` is the greatest length.
    double high = 0.0;
    std::string_view choices;  ///< Names joined by '|'; choices only.
    std::string_view sentence;
    SettingValue fallback;  ///< The default.
    SettingValue (*get)(const Settings&) = nullptr;
    /// The value must be of the kind's type and, for a choice, one of its names.
    void (*set)(Settings&, const SettingValue&) = nullptr;
};

/// A section and its sentence, in the order of the table.
struct Section {
    std::string_view name;
    std::string_view sentence;
};

std::span<const Setting> settingsTable();
std::span<const Section> settingsSections();
/// Every setting at its default.
Settings defaultSettings();
/// The names of a choice, in the order of its enumeration.
std::vector<std::string_view> choiceNames(const Setting& setting);
/// E.g. "number", as people say it.
std::string_view kindName(SettingKind kind);
/// A value as TOML writes it.
std::string toToml(const SettingValue& value);

}  // namespace cheval::config

// Reads settings: /etc/cheval/cheval.toml and cheval.toml.d/*.toml, in the order of their names, over the shipped
// cheval.toml, over the table's defaults.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "config/settings.h"
#include "config/shipped_files.h"
#include "hal/expected.h"

namespace cheval::config {

/// Where the shipped file is, under the prefix that the program is installed to; see shippedPath().
inline constexpr std::string_view kShippedFile = "lib/cheval/cheval.toml";
/// Where the settings of this mirror are.
inline constexpr std::string_view kSystemFolder = "/etc/cheval";

/// Bounds on what is read, checked before anything is parsed.
inline constexpr std::size_t kMaximumFileBytes = 256U << 10U;
inline constexpr std::size_t kMaximumDropIns = 64;
/// Problems kept; a file with more has other troubles.
inline constexpr std::size_t kMaximumProblems = 32;

struct LoadOptions {
    /// Empty, as in a build tree, where nothing is shipped: the table's defaults hold.
    std::string shippedFile = shippedPath(kShippedFile);
    std::string folder = std::string(kSystemFolder);
    /// The folder was named by a person: it is a problem when it, or anything to read in it, is missing.
    bool folderRequired = false;
};

/// Where a setting got its value; an empty file means the table's default.
struct SettingOrigin {
    std::string file;
    int line = 0;
};

/// What a load came to. With problems, `settings` is what could be understood, each refused value at its default and
/// all of them fit to be used together: whoever has last good settings keeps those; whoever starts has nothing better.
struct LoadedSettings {
    Settings settings;
    std::vector<Error> problems;         ///< Each with cause, mend and why; file, line and key where they apply.
    std::vector<SettingOrigin> origins;  ///< In the order of settingsTable().
    std::vector<std::string> files;      ///< What was read, in order.

    [[nodiscard]] bool good() const { return problems.empty(); }
};

/// Never throws and never stops at the first problem: a technician gets the whole list.
LoadedSettings loadSettings(const LoadOptions& options);

/// Reads one text over the defaults, as if it were the file `name`. For tests, checks and fuzzing.
LoadedSettings loadSettingsText(std::string_view text, const std::string& name);

/// All settings as a cheval.toml with sentences, units and ranges as comments; of `origins` (may be empty), where each
/// value came from. The shipped cheval.toml is this text for the defaults.
std::string describeSettings(const Settings& settings, const std::vector<SettingOrigin>& origins);

}  // namespace cheval::config

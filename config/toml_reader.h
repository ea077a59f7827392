// Reads one TOML text into settings by the table. Used by the loader only.
#pragma once

#include <string>
#include <string_view>

#include "config/loader.h"

namespace cheval::config {

/// Takes what `text` sets into `loaded`, consuming keys; whatever is left over becomes a problem.
void readToml(std::string_view text, const std::string& file, LoadedSettings& loaded);

/// Adds a problem unless there are kMaximumProblems already.
void addProblem(LoadedSettings& loaded, Error problem);

}  // namespace cheval::config

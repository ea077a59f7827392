// Reads a file that people wrote, whole.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "hal/expected.h"

namespace cheval::config {

/// The bytes of the regular file at `path`, which is one of `kind`, such as "settings files". Errors name it:
/// unavailable, when it is none or cannot be read; invalidInput, when it has more than `maximumBytes`.
Expected<std::string> readText(const std::string& path, std::size_t maximumBytes, std::string_view kind);

}  // namespace cheval::config

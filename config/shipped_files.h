// Where the files are that came with the program: beside it, so that any --prefix will do.
#pragma once

#include <string>
#include <string_view>

namespace cheval::config {

/// The absolute path of the file or folder `underPrefix` ("lib/cheval/cheval.toml") of the installation that the
/// running program belongs to, that is, ../`underPrefix` from the program's folder. Empty where there is none, as in a
/// build tree.
std::string shippedPath(std::string_view underPrefix);

}  // namespace cheval::config

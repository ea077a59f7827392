// "Did you mean …": the nearest of some names.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace cheval::config {

/// Edit distance of Damerau and Levenshtein (optimal string alignment): insertions, deletions, replacements and
/// exchanges of neighbours that turn `a` into `b`. Texts longer than 64 bytes count as their first 64.
std::size_t editDistance(std::string_view a, std::string_view b);

/// The name nearest to `wrong`; the first of equals; empty if `names` is empty.
std::string_view nearestName(std::string_view wrong, std::span<const std::string_view> names);

}  // namespace cheval::config

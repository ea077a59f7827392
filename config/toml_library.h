// toml++ as the readers of this room use it: headers alone, without exceptions, and words for what it found. Used by
// the readers only.
#pragma once

#include <string_view>

#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
// toml++ asserts (and tells an optimiser to assume) that a key begins as keys do, and refuses it politely right after.
// A broken file is no programming error: the refusal is wanted.
#define TOML_ASSERT(expression) static_assert(true)
#pragma push_macro("NDEBUG")
#undef NDEBUG
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace cheval::config {

/// Where something begins in its file, from 1.
inline int lineOf(const toml::source_region& region) {
    return static_cast<int>(region.begin.line);
}

/// "a text", "a list": what a value is, as people say it.
inline std::string_view typeName(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a section";
        case toml::node_type::array:
            return "a list";
        case toml::node_type::string:
            return "a text";
        case toml::node_type::integer:
            return "a whole number";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "true or false";
        default:
            return "a date or time";
    }
}

}  // namespace cheval::config

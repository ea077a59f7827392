// The settings as plain values. The members are generated from settings.def, the one table, where each has its type,
// unit, range, default and a sentence.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cheval::config {

enum class SensorSource : std::uint8_t { sim, replay, openni };
enum class Rotation : std::uint8_t { none, clockwise, anticlockwise };
enum class DisplayKind : std::uint8_t { headless, preview };
enum class ButtonSource : std::uint8_t { none, gpio };
enum class ButtonBias : std::uint8_t { keep, off, up, down };
enum class HighestRung : std::uint8_t { device, process, usb, power, daemon, machine };
enum class SwipeMeaning : std::uint8_t { carousel, arrow };
enum class HoldMeaning : std::uint8_t { view, nothing };
enum class RenderContext : std::uint8_t { automatic, egl, osmesa };
enum class BusKind : std::uint8_t { system, session, none };
enum class StartView : std::uint8_t { mirror, avatar };
enum class SizesFor : std::uint8_t { women, men, none };

/// Settings of the whole program, one nested struct a section, e.g. `settings.sensor.heightMm`. A default-made one
/// holds zeros and empty texts: take defaultSettings() (settings_table.h).
// Types and names in place of arguments cannot stand in parentheses.
// NOLINTBEGIN(bugprone-macro-parentheses)
struct Settings {
#define CHEVAL_SECTION(section, sentence) struct {
#define CHEVAL_SECTION_END(section) \
    }                               \
    section;
#define CHEVAL_FLAG(section, member, key, fallback, sentence) bool member = false;
#define CHEVAL_INTEGER(section, member, key, fallback, unit, low, high, sentence) std::int64_t member = 0;
#define CHEVAL_REAL(section, member, key, fallback, unit, low, high, sentence) double member = 0.0;
#define CHEVAL_TEXT(section, member, key, fallback, longest, sentence) std::string member;
#define CHEVAL_PATH(section, member, key, fallback, sentence) std::string member;
#define CHEVAL_TEXTS(section, member, key, fallback, most, sentence) std::vector<std::string> member;
#define CHEVAL_CHOICE(section, member, key, type, fallback, names, sentence) type member = type::fallback;
#include "config/settings.def"
};
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace cheval::config

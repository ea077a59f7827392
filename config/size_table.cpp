#include "config/size_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "config/nearest_name.h"
#include "config/text_file.h"
#include "config/toml_library.h"

namespace cheval::config {

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 11> kLetters = {"3XS", "XXS", "XS",  "S",   "M",  "L",
                                                       "XL",  "XXL", "3XL", "4XL", "5XL"};
constexpr std::size_t kLongestText = 200;
/// Finer bands than this are a slip of the pen: no maker cuts them, and no tape tells them apart.
constexpr double kNarrowestBand = 0.005;
/// A gap smaller than this is rounding, as where inches were turned into centimetres.
constexpr double kSamePlace = 1e-6;
constexpr std::string_view kWhyBands = "whoever falls between two bands, or into two, could be told no size";

struct Unit {
    std::string_view name;
    double metres;
};
constexpr std::array<Unit, 3> kUnits = {{{"mm", 0.001}, {"cm", 0.01}, {"in", 0.0254}}};

std::string inQuotes(std::string_view text) {
    return "\"" + std::string(text.substr(0, 40)) + "\"";
}

std::string listOf(std::span<const std::string_view> names) {
    std::string list;
    for (const std::string_view name : names)
        list += (list.empty() ? "" : ", ") + inQuotes(name);
    return list;
}

/// A length in the file's own unit, as its author would write it.
std::string inUnit(double metres, const Unit& unit) {
    std::array<char, 32> digits{};
    const double value = std::round(metres / unit.metres * 100.0) / 100.0;
    const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    return std::string(digits.data(), written.ptr) + " " + std::string(unit.name);
}

/// One text on its way into a table. Takes keys out of the file as it reads them, so that what is left over is known
/// to be read by nobody.
class TableReader {
  public:
    TableReader(toml::table& root, const std::string& file) : root_(root), file_(file) {}

    Expected<SizeTable> read() {
        if (auto done = readHead(); !done) return std::move(done).error();
        for (std::size_t i = 0; i < kSizedDimensions.size(); ++i) {
            if (auto done = readDimension(i); !done) return std::move(done).error();
        }
        if (auto done = refuseLeftovers(); !done) return std::move(done).error();
        if (table_.sizes.empty()) {
            return problem(0, "", "the table has no sizes", "add at least one dimension, such as chest_girth = [ … ]",
                           "a size is told by the girths that it is for");
        }
        return std::move(table_);
    }

  private:
    [[nodiscard]] Error problem(int line, std::string key, std::string cause, std::string mend,
                                std::string_view why) const {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = std::move(cause),
                     .mend = std::move(mend),
                     .why = std::string(why),
                     .file = file_,
                     .line = line,
                     .key = std::move(key)};
    }

    /// A text that must be there and say something.
    Expected<std::string> text(std::string_view key, std::string_view example, std::string_view why) {
        const toml::node* node = root_.get(key);
        if (node == nullptr)
            return problem(0, std::string(key), "it is missing", "add a line like: " + std::string(example), why);
        line_ = lineOf(node->source());
        auto value = node->value_exact<std::string>();
        if (!value) {
            return problem(line_, std::string(key), "is " + std::string(typeName(*node)) + " but must be a text",
                           "write it like: " + std::string(example), why);
        }
        if (value->empty() || value->size() > kLongestText || value->find('\0') != std::string::npos) {
            return problem(line_, std::string(key), "it is empty, or too long",
                           "write 1 to " + std::to_string(kLongestText) + " bytes", why);
        }
        root_.erase(key);
        return std::move(*value);
    }

    /// A text that must be one of some names; its place among them.
    Expected<std::size_t> choice(std::string_view key, std::span<const std::string_view> names, std::string_view why) {
        const std::string example = std::string(key) + " = " + inQuotes(names.front());
        Expected<std::string> value = text(key, example, why);
        if (!value) return std::move(value).error();
        const auto found = std::find(names.begin(), names.end(), *value);
        if (found == names.end()) {
            return problem(line_, std::string(key), inQuotes(*value) + " is not one of " + listOf(names),
                           "did you mean " + inQuotes(nearestName(*value, names)) + "?", why);
        }
        return static_cast<std::size_t>(found - names.begin());
    }

    Expected<void> readHead() {
        const auto system = choice("system", kSizeSystems, "it says how sizes are called, and how the names must run");
        if (!system) return system.error();
        table_.system = kSizeSystems[*system];
        auto region = text("region", "region = \"Europe\"", "a letter is another size elsewhere");
        if (!region) return std::move(region).error();
        table_.region = std::move(*region);
        static constexpr std::array<std::string_view, 2> kPeople = {"women", "men"};
        const auto people = choice("for", kPeople, "a letter is another size for women than for men");
        if (!people) return people.error();
        table_.sizesFor = static_cast<SizesFor>(*people);
        auto source = text("source", "source = \"the maker's table\"", "figures without a source cannot be checked");
        if (!source) return std::move(source).error();
        table_.source = std::move(*source);
        if (auto date = readDate(); !date) return date;
        std::array<std::string_view, kUnits.size()> units;
        std::transform(kUnits.begin(), kUnits.end(), units.begin(), [](const Unit& unit) { return unit.name; });
        const auto unit = choice("unit", units, "an inch is two and a half centimetres");
        if (!unit) return unit.error();
        unit_ = kUnits[*unit];
        return {};
    }

    Expected<void> readDate() {
        static constexpr std::string_view kWhy = "tables change, and people's sizes with them";
        const toml::node* node = root_.get("date");
        if (node == nullptr) return problem(0, "date", "it is missing", "add a line like: date = 2026-01-31", kWhy);
        const auto date = node->value_exact<toml::date>();
        if (!date || date->year < 1900 || date->year > 2200) {
            return problem(lineOf(node->source()), "date", "it is no date, or one of another century",
                           "write the day of the figures like: date = 2026-01-31", kWhy);
        }
        std::array<char, 16> digits{};
        std::snprintf(digits.data(), digits.size(), "%04u-%02u-%02u", static_cast<unsigned>(date->year),
                      static_cast<unsigned>(date->month), static_cast<unsigned>(date->day));
        table_.date = digits.data();
        root_.erase("date");
        return {};
    }

    Expected<void> readDimension(std::size_t index) {
        const std::string key(kSizedDimensions[index].name);
        const toml::node* node = root_.get(key);
        if (node == nullptr) return {};
        const int line = lineOf(node->source());
        const toml::array* array = node->as_array();
        if (array == nullptr || array->empty() || array->size() > kMaximumSizesInTable) {
            return problem(line, key, "it is no list of 1 to " + std::to_string(kMaximumSizesInTable) + " sizes",
                           "write it like: " + key + " = [ { size = \"M\", over = 90, to = 98 } ]",
                           "a size has one band of each girth");
        }
        const bool first = table_.sizes.empty();
        std::vector<SizeTableBand>& bands = table_.bands[index];
        for (const toml::node& entry : *array) {
            if (auto done = readBand(index, entry, first); !done) return done;
        }
        if (bands.size() != table_.sizes.size()) {
            return problem(line, key, "the size " + inQuotes(table_.sizes[bands.size()]) + " has no band here",
                           "name the same sizes in every dimension", kWhySameSizes);
        }
        root_.erase(key);
        return {};
    }

    Expected<void> readBand(std::size_t index, const toml::node& entry, bool first) {
        const std::string key(kSizedDimensions[index].name);
        std::vector<SizeTableBand>& bands = table_.bands[index];
        const int line = lineOf(entry.source());
        const toml::table* fields = entry.as_table();
        const auto name = fields == nullptr ? std::nullopt : (*fields)["size"].value_exact<std::string>();
        if (!name || fields->size() != 3) {
            return problem(line, key, "a band is not written as it must be",
                           "write it like: { size = \"M\", over = 90, to = 98 }", "it is for one size, over … up to …");
        }
        if (first) {
            if (auto named = addSize(line, key, *name); !named) return named;
        } else if (bands.size() >= table_.sizes.size() || table_.sizes[bands.size()] != *name) {
            return problem(line, key, inQuotes(*name) + " is not the size that comes here in the dimension before",
                           "name the same sizes in every dimension, in the same order", kWhySameSizes);
        }
        const auto over = girth(index, line, *name, (*fields)["over"], "over");
        if (!over) return over.error();
        const auto to = girth(index, line, *name, (*fields)["to"], "to");
        if (!to) return to.error();
        const SizeTableBand band{.over = *over, .to = *to};
        if (band.to - band.over < kNarrowestBand) {
            return problem(
                line, key,
                "the band of " + inQuotes(*name) + " does not rise by " + inUnit(kNarrowestBand, unit_) + " or more",
                "write the lower girth as over and the higher as to", kWhyBands);
        }
        if (!bands.empty() && std::abs(band.over - bands.back().to) > kSamePlace) {
            const bool gap = band.over > bands.back().to;
            return problem(
                line, key,
                (gap ? "there is a gap below the band of " : "the band below overlaps that of ") + inQuotes(*name),
                "let it begin where the one before ends: over = " + inUnit(bands.back().to, unit_),
                gap || band.over >= bands.back().over ? kWhyBands
                                                      : "sizes are written from the smallest to the largest");
        }
        bands.push_back(band);
        return {};
    }

    Expected<double> girth(std::size_t index, int line, const std::string& size, toml::node_view<const toml::node> node,
                           std::string_view field) const {
        const SizedDimension& dimension = kSizedDimensions[index];
        std::optional<double> value = node.value_exact<double>();
        if (const auto whole = node.value_exact<std::int64_t>()) value = static_cast<double>(*whole);
        const double metres = value.value_or(0.0) * unit_.metres;
        // Written so that what is no number is refused too.
        if (value && metres >= dimension.least && metres <= dimension.greatest) return metres;
        return problem(line, std::string(dimension.name),
                       "\"" + std::string(field) + "\" of " + inQuotes(size) + " is no girth that a grown-up may have",
                       "give a number from " + inUnit(dimension.least, unit_) + " to " +
                           inUnit(dimension.greatest, unit_) + ", or correct the unit",
                       "a table in another unit than it says would tell everybody a wrong size");
    }

    Expected<void> addSize(int line, const std::string& key, const std::string& name) {
        const bool printable = std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~'; });
        if (name.empty() || name.size() > kLongestSizeName || !printable) {
            return problem(line, key, "the name of a size is empty, too long or not plain",
                           "use 1 to " + std::to_string(kLongestSizeName) + " letters and digits",
                           "shoppers read it from two metres away");
        }
        if (std::find(table_.sizes.begin(), table_.sizes.end(), name) != table_.sizes.end()) {
            return problem(line, key, inQuotes(name) + " is there twice", "name each size once",
                           "a size has one band of each girth");
        }
        if (auto fits = fitsSystem(line, key, name); !fits) return fits;
        table_.sizes.push_back(name);
        return {};
    }

    /// Whether this name may come next in the table's system.
    [[nodiscard]] Expected<void> fitsSystem(int line, const std::string& key, const std::string& name) const {
        static constexpr std::string_view kWhy = "sizes are written from the smallest to the largest";
        const std::string* before = table_.sizes.empty() ? nullptr : &table_.sizes.back();
        if (table_.system == kSizeSystems[0]) {
            const auto letter = std::find(kLetters.begin(), kLetters.end(), name);
            if (letter == kLetters.end()) {
                return problem(line, key, inQuotes(name) + " is no letter code", "use one of " + listOf(kLetters),
                               "that is what the system says");
            }
            if (before != nullptr && letter < std::find(kLetters.begin(), kLetters.end(), *before))
                return problem(line, key, inQuotes(name) + " comes after " + inQuotes(*before),
                               "put it in the order " + listOf(kLetters), kWhy);
        } else if (table_.system == kSizeSystems[1]) {
            const std::optional<int> number = wholeNumber(name);
            if (!number || (before != nullptr && *number <= wholeNumber(*before).value_or(0)))
                return problem(line, key, inQuotes(name) + " is no number, or not more than the one before",
                               "write sizes as whole numbers that rise, in quotes", kWhy);
        }
        return {};
    }

    static std::optional<int> wholeNumber(const std::string& text) {
        int number = 0;
        const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
        return read.ec == std::errc() && read.ptr == text.data() + text.size() ? std::optional(number) : std::nullopt;
    }

    [[nodiscard]] Expected<void> refuseLeftovers() const {
        std::vector<std::string_view> known = {"system", "region", "for", "source", "date", "unit"};
        for (const SizedDimension& dimension : kSizedDimensions)
            known.push_back(dimension.name);
        // One is told; whoever corrects it meets the next.
        for (const auto& [key, node] : root_) {
            return problem(lineOf(key.source()), std::string(key.str().substr(0, 80)),
                           "there is no such dimension or key",
                           "did you mean " + inQuotes(nearestName(key.str(), known)) + "?",
                           "a girth that nobody reads would be left out without a word");
        }
        return {};
    }

    static constexpr std::string_view kWhySameSizes = "a garment of one size has one band of each girth";

    toml::table& root_;
    const std::string& file_;
    SizeTable table_;
    Unit unit_{};
    int line_ = 0;  ///< Of the text that was read last.
};

}  // namespace

Expected<SizeTable> parseSizeTable(std::string_view text, const std::string& file) {
    toml::parse_result parsed = toml::parse(text);
    if (!parsed) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = std::string(parsed.error().description()),
                     .mend = "correct the line",
                     .why = "size tables are TOML 1.0; a key may stand once in a file",
                     .file = file,
                     .line = lineOf(parsed.error().source())};
    }
    return TableReader(parsed.table(), file).read();
}

Expected<SizeTable> loadSizeTable(const std::string& path) {
    Expected<std::string> text = readText(path, kMaximumSizeTableBytes, "size tables");
    if (!text) return std::move(text).error();
    return parseSizeTable(*text, path);
}

SizeTables loadSizeTables(const std::string& folder) {
    SizeTables loaded;
    std::vector<fs::path> files;
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
        const fs::path& path = entry->path();
        if (path.extension() == ".toml" && !path.filename().string().starts_with('.')) files.push_back(path);
    }
    std::sort(files.begin(), files.end());
    if (failed || files.empty() || files.size() > kMaximumSizeTables) {
        loaded.refusals.push_back(
            Error{.code = failed || files.empty() ? ErrorCode::notFound : ErrorCode::invalidInput,
                  .cause = failed || files.empty() ? "there are no size tables" : "there are too many size tables",
                  .mend = "put women.toml and men.toml there, or name another folder with fitting.sizes_folder",
                  .why = "without a table shoppers are told no size",
                  .file = folder});
        return loaded;
    }
    for (const fs::path& path : files) {
        Expected<SizeTable> table = loadSizeTable(path.string());
        if (!table) {
            loaded.refusals.push_back(std::move(table).error());
            continue;
        }
        const bool twice = std::any_of(loaded.tables.begin(), loaded.tables.end(),
                                       [&](const SizeTable& other) { return other.sizesFor == table->sizesFor; });
        if (twice) {
            loaded.refusals.push_back(Error{.code = ErrorCode::invalidInput,
                                            .cause = "another file has a table for the same people already",
                                            .mend = "keep one of the two",
                                            .why = "a shopper is told one size",
                                            .file = path.string(),
                                            .key = "for"});
            continue;
        }
        loaded.tables.push_back(std::move(*table));
    }
    return loaded;
}

}  // namespace cheval::config

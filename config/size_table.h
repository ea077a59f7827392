// Size tables: which body girths a size is for, as data files with their source and date (config/sizes/*.toml).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "config/settings.h"
#include "hal/expected.h"

namespace cheval::config {

/// Where the tables are that came with the program, under its prefix; see shippedPath().
inline constexpr std::string_view kShippedSizes = "share/cheval/sizes";

/// Bounds on what is read.
inline constexpr std::size_t kMaximumSizeTableBytes = 64U << 10U;
inline constexpr std::size_t kMaximumSizeTables = 16;
inline constexpr std::size_t kMaximumSizesInTable = 16;
/// Longest name of a size, in bytes of printable ASCII.
inline constexpr std::size_t kLongestSizeName = 7;

/// The body dimensions that a table may have, by their keys, each with the least and the greatest girth in metres that
/// a grown-up may have: what lies outside is most often in another unit than the file says.
struct SizedDimension {
    std::string_view name;
    double least = 0.0;
    double greatest = 0.0;
};
inline constexpr std::array<SizedDimension, 4> kSizedDimensions = {
    {{"chest_girth", 0.5, 2.2}, {"waist_girth", 0.4, 2.2}, {"hip_girth", 0.5, 2.2}, {"neck_girth", 0.2, 0.8}}};

/// How sizes are called, which says how the names must run.
inline constexpr std::array<std::string_view, 3> kSizeSystems = {
    "EN 13402-3 letters",  // 3XS, XXS, XS, S, M, L, XL, XXL, 3XL, 4XL, 5XL, in this order; some may be left out.
    "numbers",             // Whole numbers that rise.
    "own"};                // The shop's own names, in the order of the file.

/// A size's share of one girth, in metres: greater than `over` and up to `to`.
struct SizeTableBand {
    double over = 0.0;
    double to = 0.0;
};

/// One file, checked. Immutable. Every dimension has a band for every size; each band begins where the one before ends.
struct SizeTable {
    std::string system;  ///< One of kSizeSystems.
    std::string region;
    std::string source;
    std::string date;                     ///< ISO 8601, of the figures.
    SizesFor sizesFor = SizesFor::women;  ///< Never `none`.
    std::vector<std::string> sizes;       ///< From the smallest.
    /// As kSizedDimensions; empty where the file has none, else as long as `sizes`.
    std::array<std::vector<SizeTableBand>, kSizedDimensions.size()> bands;
};

/// Reads one table, as if it were the file `file`. Errors are invalidInput with cause, mend, why, file, line and key: a
/// key that is missing, unknown or of the wrong type; an unknown system, unit (mm, cm, in) or dimension; a girth that
/// is not finite or that nobody has; bands that overlap, leave a gap or do not rise; a size that is named twice, or in
/// one dimension alone; a table without dimensions or sizes.
Expected<SizeTable> parseSizeTable(std::string_view text, const std::string& file);

/// As parseSizeTable(), from a file of at most kMaximumSizeTableBytes.
Expected<SizeTable> loadSizeTable(const std::string& path);

/// All tables of a folder; what is refused is left out, and everything else stays.
struct SizeTables {
    std::vector<SizeTable> tables;  ///< In the order of their files' names, at most one for women and one for men.
    std::vector<Error> refusals;
};

/// Reads every *.toml of `folder`. A second table for the same people is refused, and so is a folder without any.
SizeTables loadSizeTables(const std::string& folder);

}  // namespace cheval::config

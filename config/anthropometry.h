// What bodies of grown-ups are like, as surveys have it: means, standard deviations and correlations of lengths and
// girths (anthropometry/*.toml). cheval-bake gives them to the body model.
#pragma once

#include <string>
#include <vector>

#include "hal/expected.h"

namespace cheval::config {

/// People of one sex; all lists in the order of Anthropometry::dimensions.
struct PeopleTable {
    std::vector<double> mean;               ///< Metres.
    std::vector<double> standardDeviation;  ///< Metres, positive.
    /// Row i holds the correlations of dimension i + 1 with those before it, −1 … 1.
    std::vector<std::vector<double>> correlation;
};

struct Anthropometry {
    std::string source;
    std::string date;
    std::vector<std::string> dimensions;
    PeopleTable women, men;
};

/// Reads a table of at most 64 KiB. Errors: notFound, invalidInput with file, line and key: no source, date or
/// dimensions, another unit than metres, lists of another length than `dimensions`, what is not a finite number, a
/// deviation that is not positive, a correlation beyond −1 … 1.
Expected<Anthropometry> loadAnthropometry(const std::string& path);

}  // namespace cheval::config

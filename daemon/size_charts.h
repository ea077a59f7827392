// From the size tables of config/ to the charts of fitting/.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "config/size_table.h"
#include "fitting/body/size_chart.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// The shop's charts, by SizesFor, and why one of them is not there.
struct SizeCharts {
    std::array<std::optional<fitting::SizeChart>, fitting::kSizesForCount> charts;
    std::vector<Error> refusals;
};

fitting::SizeChart sizeChart(const config::SizeTable& table);

/// Reads the tables of a folder. What is refused is left out; that there is no table for `wanted` is a refusal too,
/// unless another says why.
SizeCharts loadSizeCharts(const std::string& folder, std::optional<fitting::SizesFor> wanted);

}  // namespace cheval::daemon

#include "daemon/size_charts.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace cheval::daemon {

static_assert(config::kMaximumSizesInTable <= fitting::kMaximumSizes);
static_assert(config::kLongestSizeName <= sizeof(fitting::SizeName::bytes));

fitting::SizeChart sizeChart(const config::SizeTable& table) {
    fitting::SizeChart chart{.sizesFor = table.sizesFor == config::SizesFor::men ? fitting::SizesFor::men
                                                                                 : fitting::SizesFor::women};
    for (const std::string& size : table.sizes)
        chart.sizes.emplace_back(size);
    for (std::size_t i = 0; i < config::kSizedDimensions.size(); ++i) {
        const auto known = std::find(fitting::kDimensionNames.begin(), fitting::kDimensionNames.end(),
                                     config::kSizedDimensions[i].name);
        if (known == fitting::kDimensionNames.end() || table.bands[i].empty()) continue;
        std::vector<float>& edges = chart.edges[static_cast<std::size_t>(known - fitting::kDimensionNames.begin())];
        edges.push_back(static_cast<float>(table.bands[i].front().over));
        for (const config::SizeTableBand& band : table.bands[i])
            edges.push_back(static_cast<float>(band.to));
    }
    return chart;
}

SizeCharts loadSizeCharts(const std::string& folder, std::optional<fitting::SizesFor> wanted) {
    config::SizeTables tables = config::loadSizeTables(folder);
    SizeCharts sizes{.refusals = std::move(tables.refusals)};
    for (const config::SizeTable& table : tables.tables) {
        fitting::SizeChart chart = sizeChart(table);
        sizes.charts[static_cast<std::size_t>(chart.sizesFor)] = std::move(chart);
    }
    if (wanted && !sizes.charts[static_cast<std::size_t>(*wanted)] && sizes.refusals.empty()) {
        const std::string people = *wanted == fitting::SizesFor::men ? "men" : "women";
        sizes.refusals.push_back(Error{.code = ErrorCode::notFound,
                                       .cause = "there is no size table for " + people,
                                       .mend = "put one there, or change fitting.sizes",
                                       .why = "fitting.sizes says that garments are cut for them",
                                       .file = folder});
    }
    return sizes;
}

}  // namespace cheval::daemon

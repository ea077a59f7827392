// Fuzzes the reader of size tables: whatever it reads, what comes out has bands that rise without gaps, one for each
// size and girth.
#include <cmath>
#include <cstdlib>
#include <string>

#include "config/size_table.h"
#include "tests/support/fuzz.h"

using namespace cheval;

namespace cheval::test {

std::vector<FuzzInput> fuzzSeeds() {
    std::vector<FuzzInput> seeds;
    const auto add = [&seeds](const std::string& text) { seeds.emplace_back(text.begin(), text.end()); };
    const std::string head = "region = \"Europe\"\nfor = \"men\"\nsource = \"a\"\ndate = 2026-01-31\n";
    add("system = \"EN 13402-3 letters\"\nunit = \"cm\"\n" + head +
        "chest_girth = [{size = \"S\", over = 82, to = 90}, {size = \"M\", over = 90, to = 98}]\n");
    add("system = \"numbers\"\nunit = \"mm\"\n" + head +
        "hip_girth = [{size = \"36\", over = 900, to = 940.5}, {size = \"38\", over = 940.5, to = 1000}]\n"
        "waist_girth = [{size = \"36\", over = 700, to = 740.5}, {size = \"38\", over = 740.5, to = 800}]\n");
    add("system = \"own\"\nunit = \"in\"\n" + head + "neck_girth = [{size = \"one\", over = 1e1, to = 15}]\n");
    add("unit = nan\nchest_girth = [[], {}, inf]\n[chest_girth.size]\n\"quoted key\" = '''multi\nline'''\n");
    return seeds;
}

}  // namespace cheval::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    const auto table = config::parseSizeTable(text, "sizes/men.toml");
    if (!table) {
        if (table.error().cause.empty() || table.error().mend.empty() || table.error().file.empty()) std::abort();
        return 0;
    }
    if (table->source.empty() || table->date.empty() || table->sizes.empty() ||
        table->sizes.size() > config::kMaximumSizesInTable || table->sizesFor == config::SizesFor::none)
        std::abort();
    bool any = false;
    for (const std::vector<config::SizeTableBand>& bands : table->bands) {
        any = any || !bands.empty();
        if (!bands.empty() && bands.size() != table->sizes.size()) std::abort();
        for (std::size_t i = 0; i < bands.size(); ++i) {
            if (!std::isfinite(bands[i].over) || !(bands[i].over < bands[i].to)) std::abort();
            if (i > 0 && std::abs(bands[i].over - bands[i - 1].to) > 1e-5) std::abort();
        }
    }
    if (!any) std::abort();
    return 0;
}

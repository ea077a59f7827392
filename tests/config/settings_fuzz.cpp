// Fuzzes the settings loader: whatever it reads, what comes out is fit to use and can be written and read back.
#include <cstdlib>
#include <string>

#include "config/loader.h"
#include "config/settings_table.h"
#include "tests/support/fuzz.h"

using namespace cheval;

namespace cheval::test {

std::vector<std::vector<std::uint8_t>> fuzzSeeds() {
    std::vector<std::vector<std::uint8_t>> seeds;
    const auto add = [&seeds](const std::string& text) { seeds.emplace_back(text.begin(), text.end()); };
    add("[sensor]\nsource = \"replay\"\nfolder = \"a/b\"\ntilt_deg = -4\nheight_mm = 1250.5\n");
    add("[wardrobe]\ngarments = [\"tshirt\", \"trousers\"]\noutfits = [\"tshirt+trousers\"]\nstart_outfit = "
        "\"tshirt+trousers\"\n");
    add("display.kind = \"preview\"\n[preview]\nenabled = true\nport = 0x1F90\n");
    add("[loop]\nfps = inf\nbudget_scale = nan\n[zone]\nnear_m = 1e300\n[sensr]\n\"quoted key\" = '''multi\nline'''\n");
    return seeds;
}

}  // namespace cheval::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    const config::LoadedSettings loaded = config::loadSettingsText(text, "/etc/cheval/cheval.toml");
    if (loaded.problems.size() > config::kMaximumProblems) std::abort();
    for (const Error& problem : loaded.problems) {
        if (problem.cause.empty() || problem.file.empty()) std::abort();
    }
    for (const config::Setting& setting : config::settingsTable()) {
        const config::SettingValue value = setting.get(loaded.settings);
        const double* real = std::get_if<double>(&value);
        if (real != nullptr && !(*real >= setting.low && *real <= setting.high)) std::abort();
    }
    const std::string written = config::describeSettings(loaded.settings, {});
    const config::LoadedSettings again = config::loadSettingsText(written, "/etc/cheval/cheval.toml");
    // A source without its folder is kept as it is (the screen says so); everything else must be accepted again.
    for (const Error& problem : again.problems) {
        if (problem.key != "sensor.source") std::abort();
    }
    if (config::describeSettings(again.settings, {}) != written) std::abort();
    return 0;
}

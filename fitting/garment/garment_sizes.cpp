#include "fitting/garment/garment_sizes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

namespace cheval::fitting {

namespace {

constexpr std::string_view kKey = "asset.extras.cheval.sizes";
constexpr std::array<std::pair<std::string_view, double>, 3> kUnits = {{{"mm", 0.001}, {"cm", 0.01}, {"in", 0.0254}}};
constexpr std::array<Dimension, 3> kDimensions = {Dimension::chestGirth, Dimension::waistGirth, Dimension::hipGirth};

/// Metres. What lies outside is most often in another unit than the file says.
constexpr double kLeastGirth = 0.4;
constexpr double kGreatestGirth = 2.5;
constexpr double kLeastEase = -0.3;
constexpr double kGreatestEase = 0.8;
constexpr double kNarrowestBand = 0.005;
constexpr double kSamePlace = 1e-6;

/// A name that shoppers can read, and nothing that a terminal obeys.
bool isName(std::string_view name) {
    return !name.empty() && name.size() <= SizeName().bytes.size() &&
           std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~'; });
}

class ChartReader {
  public:
    explicit ChartReader(const AssetFile& asset) : asset_(asset) {}

    Expected<SizeChart> read(SizesFor sizesFor) {
        chart_.sizesFor = sizesFor;
        const std::string unit = asset_.text("sizes/unit").value_or("");
        const auto known =
            std::find_if(kUnits.begin(), kUnits.end(), [&unit](const auto& entry) { return entry.first == unit; });
        if (known == kUnits.end())
            return refuse("unit", "it is missing or unknown", "use mm, cm or in", "girths are read by it");
        metres_ = known->second;
        for (const Dimension dimension : kDimensions) {
            if (auto done = readDimension(dimension); !done) return std::move(done).error();
        }
        if (chart_.sizes.empty())
            return refuse("", "there are no sizes", "add chest_girth, waist_girth or hip_girth", "a chart needs one");
        return std::move(chart_);
    }

  private:
    [[nodiscard]] Error refuse(const std::string& under, std::string cause, std::string mend, std::string why) const {
        return asset_.refuse(std::string(kKey) + (under.empty() ? "" : "." + under), std::move(cause), std::move(mend),
                             std::move(why));
    }

    Expected<void> readDimension(Dimension dimension) {
        const std::string name(kDimensionNames[static_cast<std::size_t>(dimension)]);
        const std::string path = "sizes/" + name;
        if (!asset_.has(path)) return {};
        const std::size_t count = asset_.length(path);
        const bool first = chart_.sizes.empty();
        if (count == 0 || count > kMaximumSizes || (!first && count != chart_.sizes.size()))
            return refuse(name, "it is no list of sizes, or not of as many as the dimension before",
                          "list the same 1 to " + std::to_string(kMaximumSizes) + " sizes in every dimension",
                          "a size has one band of each girth");
        const double ease = asset_.number("sizes/ease/" + name).value_or(std::nan("")) * metres_;
        if (!(ease >= kLeastEase && ease <= kGreatestEase))
            return refuse("ease." + name, "it is missing, or no ease that clothes have",
                          "say how much wider than the body the garment is meant to be",
                          "without it nobody's size can be told from the garment's");
        for (std::size_t i = 0; i < count; ++i) {
            if (auto done = readBand(dimension, name, i, ease); !done) return done;
        }
        return {};
    }

    Expected<void> readBand(Dimension dimension, const std::string& name, std::size_t number, double ease) {
        const std::string path = "sizes/" + name + "/" + std::to_string(number);
        const std::string key = name + "[" + std::to_string(number) + "]";
        const std::string size = asset_.text(path + "/size").value_or("");
        if (number >= chart_.sizes.size()) {
            const bool twice = std::any_of(chart_.sizes.begin(), chart_.sizes.end(),
                                           [&size](const SizeName& other) { return other.view() == size; });
            if (!isName(size) || twice)
                return refuse(key, "its size is missing, too long, not plain or named twice",
                              "give each size a name of 1 to 7 letters and digits", "shoppers read it");
            chart_.sizes.emplace_back(size);
        } else if (chart_.sizes[number].view() != size) {
            return refuse(key, "its size is not the one that comes here in the dimension before",
                          "name the same sizes in every dimension, in the same order",
                          "a size has one band of each girth");
        }
        std::vector<float>& edges = chart_.edges[static_cast<std::size_t>(dimension)];
        const double over = asset_.number(path + "/over").value_or(std::nan("")) * metres_ - ease;
        const double to = asset_.number(path + "/to").value_or(std::nan("")) * metres_ - ease;
        // Written so that what is no number is refused too.
        if (!(over >= kLeastGirth && to <= kGreatestGirth && to - over >= kNarrowestBand))
            return refuse(key, "\"over\" and \"to\" are missing, do not rise, or belong to no body",
                          "write the lower girth as over and the higher as to, and check unit and ease",
                          "a chart in another unit than it says would tell everybody a wrong size");
        if (number == 0) {
            edges.push_back(static_cast<float>(over));
            end_ = over;
        }
        if (std::abs(over - end_) > kSamePlace)
            return refuse(key, over > end_ ? "there is a gap below it" : "it overlaps the one below",
                          "let it begin where the one before ends",
                          "whoever falls between two bands, or into two, could be told no size");
        edges.push_back(static_cast<float>(to));
        end_ = to;
        return {};
    }

    const AssetFile& asset_;
    SizeChart chart_;
    double metres_ = 1.0;
    double end_ = 0.0;  ///< Of the band before, metres.
};

}  // namespace

Expected<void> readGarmentSizes(const AssetFile& asset, Garment& garment) {
    if (!asset.has("sizes")) return {};
    const std::vector<std::string> keys = asset.keys("sizes");
    const bool whole = !keys.empty();
    const std::string people = asset.text(whole ? "sizes/for" : "sizes").value_or("");
    if (people != "women" && people != "men")
        return asset.refuse(std::string(kKey) + (whole ? ".for" : ""), "it says neither \"women\" nor \"men\"",
                            "say whom the garment is cut for, or leave it out",
                            "a letter is another size for women than for men");
    garment.cutFor = people == "women" ? SizesFor::women : SizesFor::men;
    if (!whole) return {};
    for (const std::string& key : keys) {
        const bool dimension = std::any_of(kDimensions.begin(), kDimensions.end(), [&key](Dimension known) {
            return kDimensionNames[static_cast<std::size_t>(known)] == key;
        });
        if (!dimension && key != "for" && key != "unit" && key != "ease")
            return asset.refuse(std::string(kKey) + "." + key.substr(0, 40), "there is no such dimension or key",
                                "use for, unit, ease, chest_girth, waist_girth and hip_girth",
                                "a girth that nobody reads would be left out without a word");
    }
    Expected<SizeChart> chart = ChartReader(asset).read(*garment.cutFor);
    if (!chart) return std::move(chart).error();
    garment.sizes = std::move(*chart);
    return {};
}

}  // namespace cheval::fitting

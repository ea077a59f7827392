#include "daemon/wardrobe.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "config/nearest_name.h"
#include "config/shipped_files.h"
#include "config/size_table.h"
#include "daemon/size_charts.h"

namespace cheval::daemon {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> split(std::string_view names) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0; begin <= names.size();) {
        const std::size_t end = std::min(names.find_first_of(",+", begin), names.size());
        parts.emplace_back(names.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

Expected<OutfitChoice> makeChoice(const Wardrobe& wardrobe, std::string_view names) {
    OutfitChoice choice;
    std::vector<std::uint16_t> worn;
    for (const std::string& id : split(names)) {
        const auto garment = std::find_if(wardrobe.garments.begin(), wardrobe.garments.end(),
                                          [&id](const fitting::Garment& candidate) { return candidate.id == id; });
        if (garment == wardrobe.garments.end()) {
            std::string known;
            std::vector<std::string_view> ids;
            for (const fitting::Garment& candidate : wardrobe.garments) {
                known += (known.empty() ? "" : ", ") + candidate.id;
                ids.push_back(candidate.id);
            }
            return Error{.code = ErrorCode::notFound,
                         .cause = "there is no garment \"" + id + "\"",
                         .mend = ids.empty() ? "put garments into the wardrobe's folder"
                                             : "did you mean \"" + std::string(config::nearestName(id, ids)) +
                                                   "\"? Known are: " + known,
                         .why = "an outfit is made of the garments that are loaded",
                         .key = std::string(names)};
        }
        worn.push_back(static_cast<std::uint16_t>(garment - wardrobe.garments.begin()));
        // Called as the technician wrote it, whichever is worn innermost.
        choice.id += (choice.id.empty() ? "" : "+") + garment->id;
        choice.name += (choice.name.empty() ? "" : " + ") + (garment->name.empty() ? garment->id : garment->name);
    }
    // Innermost first, whatever the order in which they were named.
    std::stable_sort(worn.begin(), worn.end(), [&wardrobe](std::uint16_t a, std::uint16_t b) {
        return wardrobe.garments[a].layerOrder < wardrobe.garments[b].layerOrder;
    });
    if (worn.size() > fitting::kMaximumLayers || std::adjacent_find(worn.begin(), worn.end()) != worn.end()) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "an outfit wears each garment once and at most " +
                              std::to_string(fitting::kMaximumLayers) + " of them",
                     .mend = "name fewer",
                     .key = std::string(names)};
    }
    for (const std::uint16_t index : worn)
        choice.outfit.garments[choice.outfit.count++] = index;
    return choice;
}

}  // namespace

Wardrobe loadWardrobe(const WardrobeOptions& options) {
    Wardrobe wardrobe;
    wardrobe.sizesFor = options.sizesFor;
    if (!options.sizesFolder.empty()) {
        SizeCharts sizes = loadSizeCharts(options.sizesFolder, options.sizesFor);
        wardrobe.charts = std::move(sizes.charts);
        for (Error& refusal : sizes.refusals)
            wardrobe.refusals.push_back(std::move(refusal).within("while loading the size tables"));
    }
    const fs::path folder(options.folder);
    Expected<fitting::Body> body = fitting::loadBody((folder / "body.glb").string());
    if (!body) {
        wardrobe.refusals.push_back(std::move(body).error().within("while loading the mannequin"));
        wardrobe.materials.emplace_back();
        return wardrobe;
    }
    wardrobe.body = std::move(*body);
    wardrobe.materials.push_back(std::move(wardrobe.body->material));
    for (const std::string& id : options.garments) {
        Expected<fitting::Garment> garment =
            fitting::loadGarment((folder / (id + ".glb")).string(), wardrobe.body->cageTemplate);
        if (!garment) {
            wardrobe.refusals.push_back(std::move(garment).error().within("while loading the garment " + id));
            continue;
        }
        wardrobe.materials.push_back(std::move(garment->material));
        wardrobe.garments.push_back(std::move(*garment));
    }
    for (const std::string& names : options.outfits) {
        Expected<OutfitChoice> choice = makeChoice(wardrobe, names);
        if (!choice) {
            wardrobe.refusals.push_back(std::move(choice).error().within("while putting the outfit together"));
            continue;
        }
        if (names == options.startOutfit) wardrobe.startOutfit = wardrobe.outfits.size();
        wardrobe.outfits.push_back(std::move(*choice));
    }
    return wardrobe;
}

Expected<std::size_t> chooseOutfit(Wardrobe& wardrobe, std::string_view names) {
    Expected<OutfitChoice> choice = makeChoice(wardrobe, names);
    if (!choice) return std::move(choice).error();
    for (std::size_t i = 0; i < wardrobe.outfits.size(); ++i) {
        if (wardrobe.outfits[i].outfit == choice->outfit) return i;
    }
    wardrobe.outfits.push_back(std::move(*choice));
    return wardrobe.outfits.size() - 1;
}

const fitting::SizeChart* sizeChartOf(const Wardrobe& wardrobe, const fitting::Garment& garment) {
    if (garment.sizes) return &*garment.sizes;
    const std::optional<fitting::SizesFor> people = garment.cutFor ? garment.cutFor : wardrobe.sizesFor;
    if (!people) return nullptr;
    const std::optional<fitting::SizeChart>& chart = wardrobe.charts[static_cast<std::size_t>(*people)];
    return chart ? &*chart : nullptr;
}

std::string shippedAssetsFolder() {
    std::string installed = config::shippedPath("share/cheval/assets");
    return installed.empty() ? CHEVAL_BUILT_ASSETS : installed;
}

std::string shippedSizesFolder() {
    std::string installed = config::shippedPath(config::kShippedSizes);
    return installed.empty() ? CHEVAL_SOURCE_SIZES : installed;
}

}  // namespace cheval::daemon

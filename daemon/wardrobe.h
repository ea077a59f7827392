// The clothes and the body they were made on, as loaded at start-up, and the outfits that shoppers choose from.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fitting/body/body.h"
#include "fitting/body/size_chart.h"
#include "fitting/garment/garment.h"
#include "fitting/material.h"
#include "fitting/outfit.h"
#include "hal/expected.h"

namespace cheval::daemon {

struct WardrobeOptions {
    std::string folder;                 ///< body.glb and <garment>.glb.
    std::vector<std::string> garments;  ///< Ids: file names without .glb.
    std::vector<std::string> outfits;   ///< Ids joined by '+'.
    std::string startOutfit;            ///< One of outfits.
    std::string sizesFolder;            ///< women.toml and men.toml; empty: no size is told by the shop's tables.
    /// Whose table counts for garments that do not say whom they are cut for; nothing: they get no advice.
    std::optional<fitting::SizesFor> sizesFor;
};

/// One thing to choose: a garment, or several worn together.
struct OutfitChoice {
    std::string id;    ///< E.g. "tshirt+trousers".
    std::string name;  ///< For people, e.g. "T-shirt + Trousers".
    fitting::Outfit outfit;
};

/// Immutable once loaded. What could not be loaded is refused with a message, and everything else stays.
struct Wardrobe {
    std::optional<fitting::Body> body;  ///< Absent: nobody can be dressed, but the mirror stays lit.
    std::vector<fitting::Garment> garments;
    /// 0: the body's; i + 1: garment i's. Moved out of them: a texture is 4 MB, and needed once.
    std::vector<fitting::Material> materials;
    std::vector<OutfitChoice> outfits;
    std::size_t startOutfit = 0;
    std::array<std::optional<fitting::SizeChart>, fitting::kSizesForCount> charts;  ///< The shop's, by SizesFor.
    std::optional<fitting::SizesFor> sizesFor;                                      ///< As in the options.
    std::vector<Error> refusals;
};

Wardrobe loadWardrobe(const WardrobeOptions& options);

/// The chart that a garment's size goes by: its own, else the shop's for whom it is cut; null where there is none.
const fitting::SizeChart* sizeChartOf(const Wardrobe& wardrobe, const fitting::Garment& garment);

/// The choice that wears just the garments named in `names` ("tshirt,trousers" or "tshirt+trousers"), added to the
/// wardrobe's choices if it is not there. An unknown name is refused with a list of the known ones.
Expected<std::size_t> chooseOutfit(Wardrobe& wardrobe, std::string_view names);

/// Where the assets that came with the program are: ../share/cheval/assets beside its folder when installed, else where
/// the build made them.
std::string shippedAssetsFolder();
/// The same of the size tables: ../share/cheval/sizes, else the source's.
std::string shippedSizesFolder();

}  // namespace cheval::daemon

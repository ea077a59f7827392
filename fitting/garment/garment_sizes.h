// A garment's own word on its sizes. Format: fitting/garment/FORMAT.md.
#pragma once

#include "fitting/garment/asset_file.h"
#include "fitting/garment/garment.h"
#include "hal/expected.h"

namespace cheval::fitting {

/// Reads asset.extras.cheval.sizes into `cutFor` and `sizes`, and leaves both empty where it is missing. Errors name
/// the file and the key: unknown keys, units, dimensions and people; a dimension without ease; bands that overlap,
/// leave a gap or do not rise; a size that is named twice, or in one dimension alone; girths that no body has.
Expected<void> readGarmentSizes(const AssetFile& asset, Garment& garment);

}  // namespace cheval::fitting

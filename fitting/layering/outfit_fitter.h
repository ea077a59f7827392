// Puts an outfit on a body: layer by layer, each garment's inner cage goes onto the outer cage of what is below (A1,
// A2, A4).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fitting/body/body.h"
#include "fitting/garment/garment.h"
#include "fitting/mesh.h"
#include "fitting/outfit.h"

namespace cheval::fitting {

/// One garment in the rest pose of a shaped body.
struct FittedGarment {
    const Garment* garment = nullptr;
    std::vector<Eigen::Vector3f> positions;  ///< As Garment::mesh.
    std::vector<Eigen::Vector3f> normals;
    std::uint32_t material =
        0;  ///< Into the wardrobe's material list: 0 is the body, garment i of the wardrobe is i + 1.
};

/// An outfit in rest pose, innermost first. Capacity for the wardrobe's largest garments is reserved at construction.
struct FittedOutfit {
    std::vector<FittedGarment> layers;  ///< kMaximumLayers entries; the first `count` are worn.
    std::size_t count = 0;
    std::uint64_t revision = 0;  ///< Rises with every fit.
};

/// Fits outfits. Thread-bound; borrows body and wardrobe, which must outlive it. After construction fit() takes no heap
/// memory.
class OutfitFitter {
  public:
    OutfitFitter(const Body& body, std::span<const Garment> wardrobe);
    ~OutfitFitter();
    OutfitFitter(const OutfitFitter&) = delete;
    OutfitFitter& operator=(const OutfitFitter&) = delete;

    /// Fits `outfit` onto `body`. An index outside the wardrobe is left out.
    const FittedOutfit& fit(const ShapedBody& body, const Outfit& outfit);
    [[nodiscard]] const FittedOutfit& fitted() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace cheval::fitting

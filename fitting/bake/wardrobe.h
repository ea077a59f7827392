// The garments that come with the mirror.
#pragma once

#include <span>
#include <string_view>
#include <variant>

#include "fitting/bake/body_builder.h"
#include "fitting/bake/cloth_cut.h"
#include "fitting/bake/fabric.h"
#include "fitting/garment/garment.h"

namespace cheval::fitting::bake {

/// One line of the wardrobe's table.
struct GarmentSpecification {
    std::string_view id;    ///< The file's name.
    std::string_view name;  ///< For people.
    GarmentKind kind = GarmentKind::other;
    float rigidity = 0.2F;
    std::variant<TopCut, TrousersCut> cut;
    Fabric fabric;
};

/// All garments, in the order of the carousel.
std::span<const GarmentSpecification> wardrobe();
/// The garment of that id; null where there is none.
const GarmentSpecification* findGarment(std::string_view id);

/// Cuts, lays out and paints a garment for the mannequin: render mesh between its inner cage (the body's outer cage)
/// and its outer cage, both in template order.
Garment makeGarment(const GarmentSpecification& specification, const BodyModel& model);

}  // namespace cheval::fitting::bake

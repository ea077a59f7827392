// The mannequin and the wardrobe, made once for all tests of this program.
#pragma once

#include <map>
#include <string>

#include "fitting/bake/body_builder.h"
#include "fitting/bake/wardrobe.h"

namespace cheval::fitting::bake {

inline const BodyModel& bodyModel() {
    static const BodyModel kModel = makeBody();
    return kModel;
}

inline const Garment& garment(const std::string& id) {
    static std::map<std::string, Garment> made;
    const auto found = made.find(id);
    if (found != made.end()) return found->second;
    return made.emplace(id, makeGarment(*findGarment(id), bodyModel())).first->second;
}

}  // namespace cheval::fitting::bake

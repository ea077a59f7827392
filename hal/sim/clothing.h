// How closely measured shoppers are dressed.
#pragma once

#include <cstdint>

namespace cheval::hal::sim {

/// Eases are radial, from skin to cloth.
enum class Clothing : std::uint8_t {
    bare,      ///< No clothes, shoes or hair: the body that the truth is of.
    tight,     ///< 0 to 4 mm all over, soles up to 15 mm.
    ordinary,  ///< A shirt that follows the body at 6 to 14 mm.
    loose,     ///< 8 to 20 mm at the chest, from which cloth falls in folds to the hips and hides the waist.
    wide,      ///< An open bell from the shoulders to the knees, 60 to 120 mm off the body: nobody can measure that.
};

}  // namespace cheval::hal::sim

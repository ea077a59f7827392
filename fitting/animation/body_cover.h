// Which triangles of the body's render mesh a worn outfit hides, so that skin cannot poke through cloth.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fitting/body/body.h"
#include "fitting/layering/outfit_fitter.h"

namespace cheval::fitting {

/// Bound to one body at construction; afterwards takes no memory. Thread-bound.
///
/// A cage triangle is hidden when its corners and all their neighbours are covered by garments: one ring of skin stays
/// at every hem, cuff and neckline, where one can look in. A body triangle is hidden when all its corners lie on hidden
/// cage triangles.
class BodyCover {
  public:
    explicit BodyCover(const Body& body);

    /// Looks at what `outfit` wears.
    void update(const FittedOutfit& outfit);
    /// Whether triangle `i` of the body's mesh is hidden.
    [[nodiscard]] bool hidden(std::size_t i) const;

  private:
    const Body* body_;
    std::vector<std::uint32_t> cageTriangleOfVertex_;
    std::vector<std::uint8_t> covered_;     ///< Per cage vertex, shared across seams.
    std::vector<std::uint8_t> atEdge_;      ///< Per cage vertex: an uncovered neighbour.
    std::vector<std::uint8_t> hiddenCage_;  ///< Per cage triangle.
};

}  // namespace cheval::fitting

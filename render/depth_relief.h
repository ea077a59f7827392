// Depth readings as a lit grey relief, for technicians: shapes can be read, and nothing is repaired or made up.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/frame.h"
#include "hal/image.h"

namespace cheval::render {

/// Thread-bound; takes memory only when the picture's size changes. (What shoppers see of depth alone is DepthShading,
/// which hides holes and calms noise; this shows them.)
class DepthRelief {
  public:
    /// Grey of a pixel without a reading; every reading is at least kDarkestReading.
    static constexpr std::uint8_t kNoReading = 10;
    static constexpr std::uint8_t kDarkestReading = 56;

    /// Lights each reading by the slope of the surface about it, light from above the sensor, nearer ones brighter.
    /// Readings further apart than noise allows are two surfaces and do not shade each other. `depth` in millimetres,
    /// 0 = no reading. The picture has the size of `depth` and is valid until the next call.
    hal::ImageView<const std::uint8_t> light(hal::ImageView<const std::uint16_t> depth,
                                             const hal::Intrinsics& intrinsics);

  private:
    void smooth(hal::ImageView<const std::uint16_t> depth);

    hal::Image<std::uint8_t> picture_;
    std::vector<float> rows_, smooth_;  ///< Millimetres, averaged along rows, then along columns; 0: no reading.
};

}  // namespace cheval::render

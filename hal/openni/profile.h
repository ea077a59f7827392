// Which of a device's modes the mirror takes.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace cheval::hal {

/// A mode that a depth stream offers.
struct DepthMode {
    int width = 0;
    int height = 0;
    int framesPerSecond = 0;
    bool tenths = false;  ///< Readings in tenths of a millimetre; else in millimetres.
};

/// What was chosen.
struct DepthProfile {
    std::size_t mode = 0;  ///< Position in the list.
    int enlarge = 1;       ///< Each pixel becomes this many, both ways, so that 640×480 come out.
};

/// The ladder, best first: 640×480 at 30 Hz or nearest above, 640×480 from 15 Hz up, 320×240 likewise; whole
/// millimetres before tenths, which saturate at 6.5 m. std::nullopt: nothing that can be used.
std::optional<DepthProfile> chooseProfile(std::span<const DepthMode> modes);

}  // namespace cheval::hal

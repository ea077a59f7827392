// A tape measure for the simulated people: their true girths and lengths, cut from the bare body that is lofted.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "fitting/body.h"
#include "hal/sim/shopper.h"

namespace cheval::hal::sim {

/// Metres, in the order of fitting::Dimension and by the definitions of shared/data/shoppers: girths are tape lengths
/// about convex hulls.
using TrueMeasurements = std::array<float, fitting::kDimensionCount>;

/// Length of a tape drawn tight about the points, which it puts into another order; at most kMaximumTapePoints of them.
inline constexpr std::size_t kMaximumTapePoints = 256;
float tapeLength(std::span<Eigen::Vector2f> points);

/// Measures the body in its A-pose as it is without clothes, shoes and hair. Chest at the nipples, waist at its level
/// between ribs and hip bones, hips where the seat stands out most, thighs included, arms not; the neck square to its
/// axis where it is thinnest. Takes no memory.
TrueMeasurements measureBare(const Shopper& shopper);

}  // namespace cheval::hal::sim

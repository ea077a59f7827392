// One visit of Script::measuring as the mirror measures it, beside what a tape would say.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fitting/body.h"
#include "fitting/body/body.h"
#include "hal/sim/clothing.h"
#include "hal/sim/tape.h"

namespace cheval::fitting::test {

inline constexpr double kMeasuredFramesPerSecond = 30.0;
/// Seconds between two readings while the shopper first faces the glass, and how many are taken.
inline constexpr double kReadingSeconds = 0.25;
inline constexpr std::size_t kFacingReadings = 22;

struct MeasuredOptions {
    std::uint32_t seed = 1;  ///< Of the shop, its noise and who comes.
    hal::sim::Clothing clothing = hal::sim::Clothing::tight;
    float noiseScale = 1.0F;     ///< As hal::sim::WorldOptions has it.
    bool everybody = false;      ///< As there.
    double facingSeconds = 0.0;  ///< The visit ends after so many seconds of facing; 0: when the script does.
};

/// Lengths in metres.
struct MeasuredVisit {
    MeasuredOptions options;
    hal::sim::TrueMeasurements truth{};
    bool child = false, wheelchair = false;
    bool faced = false;  ///< The shopper came, stood and faced the glass; else nothing below was read.
    /// Reading i is of (i + 1) · kReadingSeconds after the shopper first stood facing the glass, trunk in view.
    std::array<Measurements, kFacingReadings> facing{};
    std::size_t facingCount = 0;
    std::optional<Measurements> sides;  ///< When both sides have been shown.
    Measurements end;                   ///< When the script is over.
    /// Seconds of facing until `converged` was first told; 0 where it was told before.
    std::optional<double> converged;
    std::uint32_t trackedFrames = 0;  ///< Frames with a skeleton …
    std::uint32_t frames = 0;         ///< … of those since the stand.
};

/// Runs tracker and estimator, as the mirror's frame chain ties them, over the first visit of a world.
MeasuredVisit measureVisit(const Body& body, const MeasuredOptions& options);

const char* nameOf(hal::sim::Clothing clothing);
const char* nameOf(MeasurementDoubt doubt);

}  // namespace cheval::fitting::test

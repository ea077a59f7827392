// Advice on size: one size, two neighbours, or why it cannot be told. Never a body measurement.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace cheval::fitting {

enum class AdviceCertainty : std::uint8_t { cannotTell, between, certain };

/// Why advice cannot be told or, with `smallerThanChart` and `largerThanChart`, what else it may be.
enum class AdviceReason : std::uint8_t {
    none,
    measuring,  ///< As the MeasurementDoubt of the same name, and so on to tiltUnknown.
    child,
    seated,
    looseClothes,
    partlySeen,
    crowded,
    tiltUnknown,
    uncertain,         ///< The measurements are too coarse for bands as narrow as these.
    girthsDisagree,    ///< One girth asks for another size than the next, and not its neighbour.
    smallerThanChart,  ///< The chart begins at `size`.
    largerThanChart,   ///< The chart ends at `size`.
    notSized,          ///< Nothing is to be told: no chart, or a garment that has no sizes.
};

/// The name of a size, such as "M" or "42". Plain value of fixed size; longer names are cut.
struct SizeName {
    std::array<char, 7> bytes{};
    std::uint8_t length = 0;

    SizeName() = default;
    explicit SizeName(std::string_view name) : length(static_cast<std::uint8_t>(std::min(name.size(), bytes.size()))) {
        std::copy_n(name.begin(), length, bytes.begin());
    }
    [[nodiscard]] std::string_view view() const { return {bytes.data(), length}; }
    friend bool operator==(const SizeName&, const SizeName&) = default;
};

/// Plain value of fixed size. What a shopper reads of it is made by adviceInWords() (fitting/body/size_words.h).
struct SizeAdvice {
    AdviceCertainty certainty = AdviceCertainty::cannotTell;
    AdviceReason reason = AdviceReason::measuring;
    /// The size, or the smaller one of two; the chart's end with smallerThanChart and largerThanChart; else empty.
    SizeName size;
    SizeName largerSize;  ///< Only between two sizes of the chart.

    friend bool operator==(const SizeAdvice&, const SizeAdvice&) = default;
};

}  // namespace cheval::fitting

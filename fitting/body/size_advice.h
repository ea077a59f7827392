// From girths and their uncertainty to advice on size.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fitting/advice.h"
#include "fitting/body.h"
#include "fitting/body/size_chart.h"
#include "fitting/garment/garment.h"
#include "hal/clock.h"

namespace cheval::fitting {

/// What advice is asked for; borrowed for the time of a call.
struct SizeQuestion {
    const Measurements* measurements = nullptr;  ///< Null: nobody is measured.
    const SizeChart* chart = nullptr;            ///< Null: there is none for this garment.
    GarmentKind kind = GarmentKind::other;
};

/// How likely each size is: [0] smaller than the chart, [1] its first size, and so on, [count + 1] larger than the
/// chart. They sum to one.
struct SizeProbabilities {
    std::array<double, kMaximumSizes + 2> of{};
    std::size_t count = 0;
};

/// The girths that decide about a garment's size (primary dimensions of ISO 8559-2): chest for tops and outerwear;
/// hips for women's trousers and skirts, waist for men's, and the other of the two where the chart has that alone;
/// chest, waist and hips, as far as the chart has them, for dresses. Count 0: the garment has no size by this chart.
struct PrimaryGirths {
    std::array<Dimension, 3> dimensions{};
    std::size_t count = 0;
};
PrimaryGirths primaryGirths(GarmentKind kind, const SizeChart& chart);

/// The normal distribution of the measurement, shared out over the bands between `edges` (metres, rising, at least
/// two and at most kMaximumSizes + 1). The measurement must be sound (isSound).
SizeProbabilities sizeProbabilities(const Measurement& measurement, std::span<const float> edges);

/// Valid, finite and positive, with a finite uncertainty that is not negative.
bool isSound(const Measurement& measurement);

/// Advice without a past: from `measurements` to a size of `chart`, to two neighbours, or to a reason. One size is
/// named when it is likely enough that, over all girths and with the given uncertainty, at least 95 of 100 shoppers
/// get theirs; two when together they are 95 % likely. Several girths count as one body that a garment must fit
/// everywhere, however they go together: what all have in common is at least 1 − the sum of what each denies
/// (Boole's inequality). Takes no heap memory.
SizeAdvice adviseSize(const SizeQuestion& question);

/// Advice, frame after frame: what was once told stands until something else is clear, and has been for a while.
/// Thread-bound. No call takes heap memory.
class SizeAdviser {
  public:
    /// Another person: nothing is known of them.
    void reset();
    /// Takes in what is measured now; `now` may stand still or run backwards, which counts as no time. Another chart
    /// or another kind of garment is answered at once.
    const SizeAdvice& update(const SizeQuestion& question, hal::TimePoint now);
    [[nodiscard]] const SizeAdvice& advice() const { return advice_; }

    /// Slots of SizeProbabilities that are named, from `first`; none: only a reason.
    struct Verdict {
        AdviceReason reason = AdviceReason::measuring;
        std::uint8_t first = 0;
        std::uint8_t count = 0;

        friend bool operator==(const Verdict&, const Verdict&) = default;
    };

  private:
    void take(const Verdict& verdict, const SizeChart* chart, hal::TimePoint now);

    SizeAdvice advice_;
    Verdict standing_;
    Verdict pending_;
    hal::TimePoint pendingSince_{};
    hal::TimePoint agreedAt_{};  ///< When the standing verdict was last what the measurements say.
    const SizeChart* chart_ = nullptr;
    GarmentKind kind_ = GarmentKind::other;
    bool asked_ = false;
};

}  // namespace cheval::fitting

#include "fitting/body/size_advice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cheval::fitting {

namespace {

using Verdict = SizeAdviser::Verdict;

/// No girth of a living body is known better than this; a measurement that says so is not believed.
constexpr double kFinestUncertainty = 0.002;  // metres

/// How likely a single size must be. A size that is named at 83 % and above is right in 96 % of all cases where bands
/// are at least six times as wide as the uncertainty, since most girths lie deeper in a band than at that threshold.
/// In narrower bands they do not, and at a quarter only what is 95 % likely by itself will do. Between them the
/// straight line keeps the share of right sizes between 95 % and 96 %.
constexpr double kSingleFine = 0.83;
constexpr double kSingleCoarse = 0.95;
constexpr double kFine = 1.0 / 6.0;  // uncertainty in bands
constexpr double kCoarse = 1.0 / 4.0;
constexpr double kPair = 0.95;
/// What stands may become this much less likely before it falls.
constexpr double kSingleSlack = 0.04;
constexpr double kPairSlack = 0.03;

/// A verdict must last this long before it is told.
constexpr hal::Duration kSettle = std::chrono::milliseconds(500);
/// Somebody who moves, or whom somebody passes, is not measured for a moment, and has their size all the same.
constexpr hal::Duration kKeep = std::chrono::seconds(2);
/// Measurements that say now this and now that, but never what stands.
constexpr hal::Duration kLongestDispute = std::chrono::seconds(3);

double normalShare(double z) {
    return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

/// All that is known of a body's size by one chart.
struct Evidence {
    std::array<SizeProbabilities, 3> girths{};
    std::array<double, 3> uncertainty{};
    std::array<std::span<const float>, 3> edges{};
    std::size_t girthCount = 0;
    std::size_t slots = 0;

    /// At least how likely it is that every girth lies in these slots.
    [[nodiscard]] double share(std::size_t first, std::size_t count) const {
        double denied = 0.0;
        for (std::size_t g = 0; g < girthCount; ++g) {
            double inside = 0.0;
            for (std::size_t slot = first; slot < first + count; ++slot)
                inside += girths[g].of[slot];
            denied += 1.0 - inside;
        }
        return std::max(1.0 - denied, 0.0);
    }

    /// The slots, `count` side by side, that are likeliest.
    [[nodiscard]] std::size_t likeliest(std::size_t count) const {
        std::size_t best = 0;
        for (std::size_t first = 1; first + count <= slots; ++first) {
            if (share(first, count) > share(best, count)) best = first;
        }
        return best;
    }

    /// How likely this slot must be to be named alone.
    [[nodiscard]] double singleThreshold(std::size_t slot) const {
        double coarseness = 0.0;
        for (std::size_t g = 0; g < girthCount; ++g) {
            if (slot == 0 || slot + 1 == slots) continue;  // Open ends are as wide as can be.
            const double width = static_cast<double>(edges[g][slot]) - static_cast<double>(edges[g][slot - 1]);
            coarseness = std::max(coarseness, uncertainty[g] / width);
        }
        const double along = std::clamp((coarseness - kFine) / (kCoarse - kFine), 0.0, 1.0);
        return kSingleFine + along * (kSingleCoarse - kSingleFine);
    }

    /// Girths whose likeliest sizes are no neighbours.
    [[nodiscard]] bool disagree() const {
        std::size_t least = slots;
        std::size_t most = 0;
        for (std::size_t g = 0; g < girthCount; ++g) {
            const auto begin = girths[g].of.begin();
            const auto best =
                static_cast<std::size_t>(std::max_element(begin, begin + static_cast<std::ptrdiff_t>(slots)) - begin);
            least = std::min(least, best);
            most = std::max(most, best);
        }
        return girthCount > 0 && most - least > 1;
    }
};

AdviceReason reasonOf(MeasurementDoubt doubt) {
    switch (doubt) {
        case MeasurementDoubt::none:
        case MeasurementDoubt::measuring:
            return AdviceReason::measuring;
        case MeasurementDoubt::child:
            return AdviceReason::child;
        case MeasurementDoubt::seated:
            return AdviceReason::seated;
        case MeasurementDoubt::looseClothes:
            return AdviceReason::looseClothes;
        case MeasurementDoubt::partlySeen:
            return AdviceReason::partlySeen;
        case MeasurementDoubt::crowded:
            return AdviceReason::crowded;
        case MeasurementDoubt::tiltUnknown:
            return AdviceReason::tiltUnknown;
    }
    return AdviceReason::measuring;
}

/// `standing` is what was told last by the same chart, and stands on lower thresholds; none: {}.
Verdict judge(const SizeQuestion& question, const Verdict& standing) {
    if (question.chart == nullptr || question.chart->sizes.size() > kMaximumSizes)
        return {.reason = AdviceReason::notSized};
    const PrimaryGirths primary = primaryGirths(question.kind, *question.chart);
    if (primary.count == 0) return {.reason = AdviceReason::notSized};
    if (question.measurements == nullptr) return {.reason = AdviceReason::measuring};
    const Measurements& measurements = *question.measurements;
    if (measurements.doubt != MeasurementDoubt::none) return {.reason = reasonOf(measurements.doubt)};

    Evidence evidence{.slots = question.chart->sizes.size() + 2};
    for (; evidence.girthCount < primary.count; ++evidence.girthCount) {
        const std::size_t g = evidence.girthCount;
        const Measurement& measurement = measurements[primary.dimensions[g]];
        if (!isSound(measurement)) return {.reason = AdviceReason::measuring};
        evidence.edges[g] = question.chart->of(primary.dimensions[g]);
        evidence.girths[g] = sizeProbabilities(measurement, evidence.edges[g]);
        evidence.uncertainty[g] = std::max(static_cast<double>(measurement.uncertainty), kFinestUncertainty);
    }
    const auto stands = [&standing](std::size_t first, std::size_t count) {
        return standing.count == count && standing.first == first;
    };
    const std::size_t single = evidence.likeliest(1);
    const double needed = evidence.singleThreshold(single) - (stands(single, 1) ? kSingleSlack : 0.0);
    const auto named = [&evidence](std::size_t first, std::size_t count) {
        AdviceReason reason = AdviceReason::none;
        if (first == 0) reason = AdviceReason::smallerThanChart;
        if (first + count == evidence.slots) reason = AdviceReason::largerThanChart;
        return Verdict{
            .reason = reason, .first = static_cast<std::uint8_t>(first), .count = static_cast<std::uint8_t>(count)};
    };
    if (evidence.share(single, 1) >= needed) return named(single, 1);
    const std::size_t pair = evidence.likeliest(2);
    // Of two pairs that would both do, the one that stands stays.
    if (standing.count == 2 && evidence.share(standing.first, 2) >= kPair - kPairSlack) return standing;
    if (evidence.share(pair, 2) >= kPair) return named(pair, 2);
    return {.reason = evidence.disagree() ? AdviceReason::girthsDisagree : AdviceReason::uncertain};
}

SizeAdvice adviceOf(const Verdict& verdict, const SizeChart* chart) {
    SizeAdvice advice{.reason = verdict.reason};
    if (verdict.count == 0 || chart == nullptr || chart->sizes.empty()) return advice;
    const std::size_t last = chart->sizes.size();  // The slot of the largest size.
    const bool beyond = verdict.reason != AdviceReason::none;
    if (!beyond || verdict.count == 2)
        advice.certainty = verdict.count == 1 ? AdviceCertainty::certain : AdviceCertainty::between;
    const std::size_t slot = std::clamp<std::size_t>(verdict.first, 1, last);
    advice.size = chart->sizes[slot - 1];
    if (!beyond && verdict.count == 2) advice.largerSize = chart->sizes[slot];
    return advice;
}

}  // namespace

PrimaryGirths primaryGirths(GarmentKind kind, const SizeChart& chart) {
    PrimaryGirths girths;
    const auto add = [&](Dimension dimension) {
        if (chart.of(dimension).size() != chart.sizes.size() + 1 || chart.sizes.empty()) return;
        girths.dimensions[girths.count++] = dimension;
    };
    switch (kind) {
        case GarmentKind::top:
        case GarmentKind::outerwear:
            add(Dimension::chestGirth);
            break;
        case GarmentKind::trousers:
        case GarmentKind::skirt: {
            const bool women = chart.sizesFor == SizesFor::women;
            add(women ? Dimension::hipGirth : Dimension::waistGirth);
            if (girths.count == 0) add(women ? Dimension::waistGirth : Dimension::hipGirth);
            break;
        }
        case GarmentKind::dress:
            add(Dimension::chestGirth);
            add(Dimension::waistGirth);
            add(Dimension::hipGirth);
            break;
        case GarmentKind::headwear:
        case GarmentKind::other:
            break;
    }
    return girths;
}

bool isSound(const Measurement& measurement) {
    return measurement.valid && std::isfinite(measurement.value) && measurement.value > 0.0F &&
           std::isfinite(measurement.uncertainty) && measurement.uncertainty >= 0.0F;
}

SizeProbabilities sizeProbabilities(const Measurement& measurement, std::span<const float> edges) {
    SizeProbabilities probabilities{.count = edges.size() - 1};
    const double uncertainty = std::max(static_cast<double>(measurement.uncertainty), kFinestUncertainty);
    double below = 0.0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const double upTo =
            normalShare((static_cast<double>(edges[i]) - static_cast<double>(measurement.value)) / uncertainty);
        probabilities.of[i] = upTo - below;
        below = upTo;
    }
    probabilities.of[edges.size()] = 1.0 - below;
    return probabilities;
}

SizeAdvice adviseSize(const SizeQuestion& question) {
    return adviceOf(judge(question, {}), question.chart);
}

void SizeAdviser::reset() {
    *this = {};
}

void SizeAdviser::take(const Verdict& verdict, const SizeChart* chart, hal::TimePoint now) {
    standing_ = verdict;
    pending_ = verdict;
    pendingSince_ = now;
    agreedAt_ = now;
    advice_ = adviceOf(verdict, chart);
}

const SizeAdvice& SizeAdviser::update(const SizeQuestion& question, hal::TimePoint now) {
    const bool other = asked_ && (question.chart != chart_ || question.kind != kind_);
    const Verdict verdict = judge(question, other ? Verdict{} : standing_);
    chart_ = question.chart;
    kind_ = question.kind;
    if (!asked_) agreedAt_ = now;
    asked_ = true;
    pendingSince_ = std::min(pendingSince_, now);
    agreedAt_ = std::min(agreedAt_, now);
    if (other || verdict.reason == AdviceReason::notSized) {
        take(verdict, question.chart, now);
    } else if (verdict == standing_) {
        pending_ = verdict;
        agreedAt_ = now;
    } else {
        if (!(verdict == pending_)) {
            pending_ = verdict;
            pendingSince_ = now;
        }
        const hal::Duration needed = standing_.count > 0 && verdict.count == 0 ? kKeep : kSettle;
        if (now - pendingSince_ >= needed || now - agreedAt_ >= kLongestDispute) take(verdict, question.chart, now);
    }
    return advice_;
}

}  // namespace cheval::fitting

#include "fitting/body/size_advice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fitting/body/size_words.h"
#include "tests/support/allocation_counter.h"

namespace cheval::fitting {
namespace {

std::vector<float> metres(std::initializer_list<int> centimetres) {
    std::vector<float> edges;
    for (const int edge : centimetres)
        edges.push_back(static_cast<float>(edge) / 100.0F);
    return edges;
}

void setEdges(SizeChart& chart, Dimension dimension, std::initializer_list<int> centimetres) {
    chart.edges[static_cast<std::size_t>(dimension)] = metres(centimetres);
}

SizeChart womensChart() {
    SizeChart chart{.sizesFor = SizesFor::women};
    for (const char* name : {"XS", "S", "M", "L", "XL", "XXL"})
        chart.sizes.emplace_back(name);
    setEdges(chart, Dimension::chestGirth, {74, 82, 90, 98, 107, 119, 131});
    setEdges(chart, Dimension::waistGirth, {58, 66, 74, 82, 91, 103, 115});
    setEdges(chart, Dimension::hipGirth, {82, 90, 98, 106, 114, 124, 134});
    return chart;
}

SizeChart mensChart() {
    SizeChart chart{.sizesFor = SizesFor::men};
    for (const char* name : {"XS", "S", "M", "L", "XL", "XXL"})
        chart.sizes.emplace_back(name);
    setEdges(chart, Dimension::chestGirth, {78, 86, 94, 102, 110, 118, 129});
    setEdges(chart, Dimension::waistGirth, {66, 74, 82, 90, 98, 106, 117});
    return chart;
}

/// Seven bands of eight centimetres.
SizeChart evenChart() {
    SizeChart chart;
    for (const char* name : {"A", "B", "C", "D", "E", "F", "G"})
        chart.sizes.emplace_back(name);
    setEdges(chart, Dimension::chestGirth, {72, 80, 88, 96, 104, 112, 120, 128});
    return chart;
}

Measurements measured(double chest, double waist, double hip, double uncertainty) {
    Measurements measurements{.frames = 60, .converged = true, .doubt = MeasurementDoubt::none};
    const auto set = [&](Dimension dimension, double value) {
        measurements[dimension] = {
            .value = static_cast<float>(value), .uncertainty = static_cast<float>(uncertainty), .valid = true};
    };
    set(Dimension::chestGirth, chest);
    set(Dimension::waistGirth, waist);
    set(Dimension::hipGirth, hip);
    return measurements;
}

SizeAdvice topAdvice(const SizeChart& chart, double chest, double uncertainty) {
    const Measurements measurements = measured(chest, 0.0, 0.0, uncertainty);
    return adviseSize({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::top});
}

std::string words(const SizeAdvice& advice) {
    AdviceText memory{};
    return std::string(adviceInWords(advice, memory));
}

/// Slots of the chart that an advice names: 0 below it, count + 1 above it.
std::pair<int, int> namedSlots(const SizeAdvice& advice, const SizeChart& chart) {
    const auto slot = [&](const SizeName& name) {
        return static_cast<int>(std::find(chart.sizes.begin(), chart.sizes.end(), name) - chart.sizes.begin()) + 1;
    };
    const int above = static_cast<int>(chart.sizes.size()) + 1;
    const bool alone = advice.certainty == AdviceCertainty::cannotTell;
    if (advice.reason == AdviceReason::smallerThanChart) return {0, alone ? 0 : 1};
    if (advice.reason == AdviceReason::largerThanChart) return {alone ? above : above - 1, above};
    if (alone) return {-1, -1};
    const int first = slot(advice.size);
    return {first, advice.certainty == AdviceCertainty::certain ? first : slot(advice.largerSize)};
}

int trueSlot(const std::vector<float>& edges, double girth) {
    return static_cast<int>(std::lower_bound(edges.begin(), edges.end(), static_cast<float>(girth)) - edges.begin());
}

TEST(SizeProbabilities, sumToOneWithTheOpenEnds) {
    const SizeChart chart = womensChart();
    std::mt19937 random(1);
    std::uniform_real_distribution<float> girth(0.3F, 2.0F);
    std::uniform_real_distribution<float> uncertainty(0.0F, 0.2F);
    for (int i = 0; i < 2000; ++i) {
        const SizeProbabilities probabilities =
            sizeProbabilities({.value = girth(random), .uncertainty = uncertainty(random), .valid = true},
                              chart.of(Dimension::chestGirth));
        ASSERT_EQ(probabilities.count, 6U);
        double sum = 0.0;
        for (std::size_t slot = 0; slot < probabilities.count + 2; ++slot) {
            EXPECT_GE(probabilities.of[slot], 0.0);
            sum += probabilities.of[slot];
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
    }
}

TEST(SizeProbabilities, areTheNormalDistributionsShareOfEachBand) {
    const std::vector<float> edges = metres({90, 98});
    const SizeProbabilities probabilities =
        sizeProbabilities({.value = 0.98F, .uncertainty = 0.04F, .valid = true}, edges);
    EXPECT_NEAR(probabilities.of[0], 0.02275, 1e-4);
    EXPECT_NEAR(probabilities.of[1], 0.47725, 1e-4);
    EXPECT_NEAR(probabilities.of[2], 0.5, 1e-4);
}

TEST(SizeAdvice, isOneSizeTwoOrNone) {
    const SizeChart chart = womensChart();
    EXPECT_EQ(words(topAdvice(chart, 0.94, 0.012)), "Your size: M");
    EXPECT_EQ(words(topAdvice(chart, 0.978, 0.012)), "Between M and L");
    EXPECT_EQ(words(topAdvice(chart, 0.982, 0.012)), "Between M and L");
    EXPECT_EQ(words(topAdvice(chart, 0.94, 0.06)), "Size: I cannot tell: I am not sure enough; please ask us");
}

TEST(SizeAdvice, saysWhereTheChartEnds) {
    const SizeChart chart = womensChart();
    EXPECT_EQ(words(topAdvice(chart, 0.60, 0.012)), "Size: I cannot tell: ours begin with XS; please ask us");
    EXPECT_EQ(words(topAdvice(chart, 0.74, 0.012)), "XS, or smaller than our sizes");
    EXPECT_EQ(words(topAdvice(chart, 1.31, 0.012)), "XXL, or larger than our sizes");
    EXPECT_EQ(words(topAdvice(chart, 1.50, 0.012)), "Size: I cannot tell: ours end with XXL; please ask us");
    EXPECT_EQ(topAdvice(chart, 1.50, 0.012).certainty, AdviceCertainty::cannotTell);
}

struct KindCase {
    GarmentKind kind;
    SizesFor sizesFor;
    const char* words;
};

void PrintTo(const KindCase& one, std::ostream* stream) {
    *stream << static_cast<int>(one.kind) << " for " << static_cast<int>(one.sizesFor);
}

class PrimaryGirth : public testing::TestWithParam<KindCase> {};

TEST_P(PrimaryGirth, decidesByTheGarmentsKind) {
    const SizeChart chart = GetParam().sizesFor == SizesFor::women ? womensChart() : mensChart();
    // Women: chest M, waist S, hips L. Men: chest S, waist XS.
    const Measurements measurements = measured(0.94, 0.70, 1.10, 0.005);
    EXPECT_EQ(words(adviseSize({.measurements = &measurements, .chart = &chart, .kind = GetParam().kind})),
              GetParam().words);
}

INSTANTIATE_TEST_SUITE_P(SizeAdvice, PrimaryGirth,
                         testing::Values(KindCase{GarmentKind::top, SizesFor::women, "Your size: M"},
                                         KindCase{GarmentKind::outerwear, SizesFor::women, "Your size: M"},
                                         KindCase{GarmentKind::top, SizesFor::men, "Between S and M"},
                                         KindCase{GarmentKind::trousers, SizesFor::women, "Your size: L"},
                                         KindCase{GarmentKind::skirt, SizesFor::women, "Your size: L"},
                                         KindCase{GarmentKind::trousers, SizesFor::men, "Your size: XS"},
                                         KindCase{GarmentKind::skirt, SizesFor::men, "Your size: XS"},
                                         KindCase{GarmentKind::dress, SizesFor::women,
                                                  "Size: I cannot tell: it depends on the cut; please try two sizes"},
                                         KindCase{GarmentKind::headwear, SizesFor::women, ""},
                                         KindCase{GarmentKind::other, SizesFor::men, ""}));

TEST(SizeAdvice, ofADressIsForAllGirths) {
    const SizeChart chart = womensChart();
    const auto dress = [&](double chest, double waist, double hip) {
        const Measurements measurements = measured(chest, waist, hip, 0.008);
        return words(adviseSize({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::dress}));
    };
    EXPECT_EQ(dress(0.94, 0.78, 1.02), "Your size: M");
    EXPECT_EQ(dress(0.94, 0.78, 1.10), "Between M and L");
    EXPECT_EQ(dress(0.94, 0.86, 1.10), "Between M and L");
    EXPECT_EQ(dress(0.86, 0.78, 1.10), "Size: I cannot tell: it depends on the cut; please try two sizes");
    Measurements hipless = measured(0.94, 0.78, 1.02, 0.008);
    hipless[Dimension::hipGirth].valid = false;
    EXPECT_EQ(adviseSize({.measurements = &hipless, .chart = &chart, .kind = GarmentKind::dress}).reason,
              AdviceReason::measuring);
}

TEST(SizeAdvice, goesByTheGirthThatAChartHas) {
    SizeChart chart = womensChart();
    chart.edges[static_cast<std::size_t>(Dimension::hipGirth)].clear();
    const Measurements measurements = measured(0.94, 0.78, 1.10, 0.008);
    EXPECT_EQ(words(adviseSize({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::trousers})),
              "Your size: M");
    EXPECT_EQ(words(adviseSize({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::dress})),
              "Your size: M");
    for (std::vector<float>& edges : chart.edges)
        edges.clear();
    EXPECT_EQ(words(adviseSize({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::top})), "");
}

TEST(SizeAdvice, hasAReasonForEachDoubtThatTellsNothingOfTheBody) {
    const SizeChart chart = womensChart();
    std::vector<std::string> all;
    for (int doubt = 0; doubt <= static_cast<int>(MeasurementDoubt::tiltUnknown); ++doubt) {
        Measurements measurements = measured(0.94, 0.78, 1.02, 0.008);
        measurements.doubt = static_cast<MeasurementDoubt>(doubt);
        const SizeAdvice advice =
            adviseSize({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::top});
        if (measurements.doubt == MeasurementDoubt::none) {
            EXPECT_EQ(advice.certainty, AdviceCertainty::certain);
            continue;
        }
        EXPECT_EQ(advice.certainty, AdviceCertainty::cannotTell);
        EXPECT_FALSE(reasonInWords(advice.reason).empty());
        all.push_back(words(advice));
    }
    std::sort(all.begin(), all.end());
    EXPECT_EQ(std::unique(all.begin(), all.end()), all.end()) << "each has words of its own";
    for (const std::string& text : all) {
        EXPECT_THAT(text, testing::StartsWith("Size: I cannot tell: "));
        EXPECT_LT(text.size(), 72U) << "two lines of the head-up display: " << text;
        EXPECT_EQ(text.find_first_of("0123456789"), std::string::npos);
    }
}

TEST(SizeAdvice, isWithheldForWhatIsNoMeasurement) {
    const SizeChart chart = womensChart();
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (const auto& [value, uncertainty] :
         {std::pair(kNan, 0.01), std::pair(0.94, kNan), std::pair(kInfinity, 0.01), std::pair(0.94, kInfinity),
          std::pair(-0.94, 0.01), std::pair(0.94, -0.01), std::pair(0.0, 0.01)}) {
        const SizeAdvice advice = topAdvice(chart, value, uncertainty);
        EXPECT_EQ(advice.certainty, AdviceCertainty::cannotTell) << value << " ± " << uncertainty;
        EXPECT_EQ(advice.reason, AdviceReason::measuring);
    }
    EXPECT_EQ(adviseSize({.chart = &chart, .kind = GarmentKind::top}).reason, AdviceReason::measuring);
    // Zero is no uncertainty that anybody has: at a band's edge it must not decide.
    EXPECT_EQ(words(topAdvice(chart, 0.94, 0.0)), "Your size: M");
    EXPECT_EQ(words(topAdvice(chart, 0.98, 0.0)), "Between M and L");
}

TEST(SizeAdvice, risesWithTheGirth) {
    for (const SizeChart& chart : {womensChart(), evenChart()}) {
        for (const double uncertainty : {0.005, 0.012, 0.02, 0.03, 0.05}) {
            std::pair<int, int> before{0, 0};
            for (int millimetre = 400; millimetre < 1700; ++millimetre) {
                const auto slots = namedSlots(topAdvice(chart, millimetre / 1000.0, uncertainty), chart);
                if (slots.first < 0) continue;
                EXPECT_GE(slots.first, before.first) << millimetre << " mm ± " << uncertainty;
                EXPECT_GE(slots.second, before.second) << millimetre << " mm ± " << uncertainty;
                before = slots;
            }
        }
    }
}

TEST(SizeAdvice, isNeverMoreCertainWithMoreUncertainty) {
    const SizeChart chart = womensChart();
    const auto certainty = [&](int millimetre, int tenths) {
        const auto slots = namedSlots(topAdvice(chart, millimetre / 1000.0, tenths / 10000.0), chart);
        return slots.first < 0 ? 0 : slots.first == slots.second ? 2 : 1;
    };
    for (int millimetre = 650; millimetre < 1400; millimetre += 3) {
        int before = 2;
        for (int tenths = 0; tenths < 800; tenths += 7) {
            const int now = certainty(millimetre, tenths);
            EXPECT_LE(now, before) << millimetre << " mm ± " << tenths / 10.0 << " mm";
            before = std::min(before, now);
        }
    }
}

/// What came of many shoppers.
struct Tally {
    int beyond = 0;  ///< The slot above the chart.
    int shoppers = 0, told = 0, right = 0, single = 0, singleRight = 0;

    void add(const std::pair<int, int>& slots, int truthLeast, int truthMost) {
        ++shoppers;
        if (slots.first < 0) return;
        ++told;
        const bool covered = slots.first <= truthLeast && truthMost <= slots.second;
        right += covered ? 1 : 0;
        if (slots.first != slots.second || slots.first == 0 || slots.first == beyond) return;
        ++single;
        singleRight += covered ? 1 : 0;
    }
    [[nodiscard]] double rightShare() const { return static_cast<double>(right) / std::max(told, 1); }
    [[nodiscard]] double singleShare() const { return static_cast<double>(single) / shoppers; }
    [[nodiscard]] double singleRightShare() const {
        return single == 0 ? 1.0 : static_cast<double>(singleRight) / single;
    }
};

TEST(SizeAdvice, namesTheRightSizeInAtLeast95OfAHundred) {
    constexpr int kShoppers = 40'000;
    // Whatever the shoppers are like: every girth alike, or as women's chests go.
    for (const bool uniform : {true, false}) {
        for (const SizeChart& chart : {womensChart(), evenChart()}) {
            for (int millimetre = 5; millimetre <= 30; millimetre += 1) {
                std::mt19937 random(static_cast<unsigned>(millimetre));
                std::uniform_real_distribution<double> anybody(0.70, 1.33);
                std::normal_distribution<double> women(0.96, 0.10);
                std::normal_distribution<double> error(0.0, millimetre / 1000.0);
                Tally tally{.beyond = static_cast<int>(chart.sizes.size()) + 1};
                for (int i = 0; i < kShoppers; ++i) {
                    const double truth = uniform ? anybody(random) : women(random);
                    const int slot = trueSlot(chart.of(Dimension::chestGirth), truth);
                    tally.add(namedSlots(topAdvice(chart, truth + error(random), millimetre / 1000.0), chart), slot,
                              slot);
                }
                EXPECT_GE(tally.rightShare(), 0.95) << "± " << millimetre << " mm, uniform " << uniform;
                // Coarse measurements of rare sizes are most often of the common one beside them; few such are told.
                EXPECT_GE(tally.singleRightShare(), uniform || tally.singleShare() > 0.3 ? 0.945 : 0.90)
                    << "± " << millimetre << " mm, uniform " << uniform;
                RecordProperty("single_share_" + std::to_string(chart.sizes.size()) + (uniform ? "_uniform_" : "_") +
                                   std::to_string(millimetre) + "_mm",
                               std::to_string(tally.singleShare()));
            }
        }
    }
}

TEST(SizeAdvice, isOneSizeForSevenInTenWithTwelveMillimetres) {
    const SizeChart chart = evenChart();
    std::mt19937 random(12);
    // Girths that lie within the chart.
    std::uniform_real_distribution<double> anybody(0.80, 1.20);
    std::normal_distribution<double> error(0.0, 0.012);
    Tally tally{.beyond = static_cast<int>(chart.sizes.size()) + 1};
    for (int i = 0; i < 100'000; ++i) {
        const double truth = anybody(random);
        const int slot = trueSlot(chart.of(Dimension::chestGirth), truth);
        tally.add(namedSlots(topAdvice(chart, truth + error(random), 0.012), chart), slot, slot);
    }
    EXPECT_GE(tally.singleShare(), 0.70);
    EXPECT_GE(tally.rightShare(), 0.95);
    EXPECT_EQ(tally.told, tally.shoppers);
}

TEST(SizeAdvice, ofADressIsRightForAllGirthsHoweverTheirErrorsGoTogether) {
    const SizeChart chart = womensChart();
    for (const double together : {0.0, 0.9}) {
        for (const double uncertainty : {0.005, 0.010, 0.015, 0.020, 0.030}) {
            std::mt19937 random(7);
            std::normal_distribution<double> normal(0.0, 1.0);
            Tally tally{.beyond = static_cast<int>(chart.sizes.size()) + 1};
            for (int i = 0; i < 40'000; ++i) {
                const double build = 0.09 * normal(random);
                const std::array truth = {0.94 + build + 0.02 * normal(random), 0.78 + build + 0.02 * normal(random),
                                          1.02 + build + 0.02 * normal(random)};
                const double common = normal(random);
                std::array<double, 3> seen{};
                for (std::size_t g = 0; g < 3; ++g)
                    seen[g] = truth[g] +
                              uncertainty * (std::sqrt(together) * common + std::sqrt(1.0 - together) * normal(random));
                const std::array slots = {trueSlot(chart.of(Dimension::chestGirth), truth[0]),
                                          trueSlot(chart.of(Dimension::waistGirth), truth[1]),
                                          trueSlot(chart.of(Dimension::hipGirth), truth[2])};
                const Measurements measurements = measured(seen[0], seen[1], seen[2], uncertainty);
                const SizeAdvice advice =
                    adviseSize({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::dress});
                tally.add(namedSlots(advice, chart), *std::min_element(slots.begin(), slots.end()),
                          *std::max_element(slots.begin(), slots.end()));
            }
            EXPECT_GE(tally.rightShare(), 0.95) << "± " << uncertainty << ", together " << together;
        }
    }
}

/// One stretch of equal measurements, and what is told at its end.
struct Stretch {
    double seconds;
    double chest;
    double uncertainty;
    MeasurementDoubt doubt;
    const char* words;
};

struct Story {
    const char* name;
    std::vector<Stretch> stretches;
};

void PrintTo(const Story& story, std::ostream* stream) {
    *stream << story.name;
}

class AdviserStory : public testing::TestWithParam<Story> {};

constexpr hal::Duration kFrame = std::chrono::milliseconds(33);
constexpr auto kNone = MeasurementDoubt::none;
constexpr const char* kMeasuring = "Size: I cannot tell: still measuring";

TEST_P(AdviserStory, tellsWhatLasts) {
    const SizeChart chart = womensChart();
    SizeAdviser adviser;
    hal::TimePoint now{};
    for (const Stretch& stretch : GetParam().stretches) {
        Measurements measurements = measured(stretch.chest, 0.0, 0.0, stretch.uncertainty);
        measurements.doubt = stretch.doubt;
        for (const hal::TimePoint end = now + hal::fromSeconds(stretch.seconds); now < end; now += kFrame)
            adviser.update({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::top}, now);
        EXPECT_EQ(words(adviser.advice()), stretch.words) << "at " << hal::seconds(now) << " s";
    }
}

INSTANTIATE_TEST_SUITE_P(
    SizeAdviser, AdviserStory,
    testing::Values(Story{"settles",
                          {{1.0, 0.94, 0.01, MeasurementDoubt::measuring, kMeasuring},
                           {0.3, 0.94, 0.01, kNone, kMeasuring},
                           {0.5, 0.94, 0.01, kNone, "Your size: M"}}},
                    Story{"keepsASizeThroughAMoment",
                          {{1.0, 0.94, 0.01, kNone, "Your size: M"},
                           {1.8, 0.94, 0.01, MeasurementDoubt::crowded, "Your size: M"},
                           {0.1, 0.94, 0.01, kNone, "Your size: M"},
                           {1.8, 0.94, 0.01, MeasurementDoubt::crowded, "Your size: M"},
                           {0.5, 0.94, 0.01, MeasurementDoubt::crowded,
                            "Size: I cannot tell: please stand a little apart"},
                           {1.0, 0.94, 0.01, kNone, "Your size: M"}}},
                    Story{"tellsOneReasonAfterTheOther",
                          {{1.0, 0.94, 0.01, MeasurementDoubt::partlySeen,
                            "Size: I cannot tell: please step back so that I see all of you"},
                           {0.4, 0.94, 0.01, MeasurementDoubt::tiltUnknown,
                            "Size: I cannot tell: please step back so that I see all of you"},
                           {0.3, 0.94, 0.01, MeasurementDoubt::tiltUnknown,
                            "Size: I cannot tell: I am still looking for the floor"}}},
                    // At ± 12 mm one size is named up to 968.5 mm and kept up to 970.4 mm.
                    Story{"keepsALetterALittleBeyondItsThreshold",
                          {{1.0, 0.960, 0.012, kNone, "Your size: M"},
                           {2.0, 0.969, 0.012, kNone, "Your size: M"},
                           {2.0, 0.975, 0.012, kNone, "Between M and L"},
                           {2.0, 0.969, 0.012, kNone, "Between M and L"},
                           {2.0, 0.967, 0.012, kNone, "Your size: M"}}},
                    Story{"keepsAPairALittleBeyondItsThreshold",
                          {{1.0, 0.960, 0.030, kNone, "Between M and L"},
                           {2.0, 0.947, 0.030, kNone, "Between M and L"},
                           {4.0, 0.940, 0.030, kNone, "Size: I cannot tell: I am not sure enough; please ask us"},
                           {2.0, 0.947, 0.030, kNone, "Size: I cannot tell: I am not sure enough; please ask us"}}},
                    Story{"changesForSomebodyWhoIsMeasuredOtherwise",
                          {{1.0, 0.94, 0.01, kNone, "Your size: M"},
                           {0.4, 1.02, 0.01, kNone, "Your size: M"},
                           {0.3, 1.02, 0.01, kNone, "Your size: L"}}}),
    [](const auto& parameters) { return std::string(parameters.param.name); });

TEST(SizeAdviser, doesNotFlickerWhereMeasurementsDo) {
    const SizeChart chart = womensChart();
    SizeAdviser adviser;
    std::mt19937 random(3);
    std::normal_distribution<double> wobble(0.0, 0.002);
    hal::TimePoint now{};
    int changes = 0;
    SizeAdvice before;
    for (int frame = 0; frame < 9000; ++frame, now += kFrame) {
        // Right at the threshold between one size and two.
        const Measurements measurements = measured(0.9686 + wobble(random), 0.0, 0.0, 0.012);
        const SizeAdvice& advice =
            adviser.update({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::top}, now);
        changes += advice == before ? 0 : 1;
        before = advice;
    }
    EXPECT_LE(changes, 2) << "in five minutes";
}

TEST(SizeAdviser, endsADisputeThatNeverSettles) {
    const SizeChart chart = womensChart();
    SizeAdviser adviser;
    hal::TimePoint now{};
    const auto feed = [&](double chest) {
        const Measurements measurements = measured(chest, 0.0, 0.0, 0.005);
        adviser.update({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::top}, now);
        now += kFrame;
    };
    for (int i = 0; i < 30; ++i)
        feed(0.94);
    ASSERT_EQ(words(adviser.advice()), "Your size: M");
    // Neither lasts, but M is it no more.
    for (int i = 0; i < 120; ++i)
        feed(i % 2 == 0 ? 1.02 : 1.13);
    EXPECT_NE(words(adviser.advice()), "Your size: M");
}

TEST(SizeAdviser, answersForAnotherGarmentAtOnceAndForgetsAnotherPerson) {
    const SizeChart women = womensChart();
    const SizeChart men = mensChart();
    SizeAdviser adviser;
    const Measurements measurements = measured(0.94, 0.78, 1.10, 0.005);
    hal::TimePoint now{};
    const auto ask = [&](const SizeChart* chart, GarmentKind kind) {
        now += kFrame;
        return words(adviser.update({.measurements = &measurements, .chart = chart, .kind = kind}, now));
    };
    for (int i = 0; i < 30; ++i)
        ask(&women, GarmentKind::top);
    EXPECT_EQ(words(adviser.advice()), "Your size: M");
    EXPECT_EQ(ask(&women, GarmentKind::trousers), "Your size: L");
    EXPECT_EQ(ask(&men, GarmentKind::trousers), "Your size: S");
    EXPECT_EQ(ask(&men, GarmentKind::headwear), "");
    EXPECT_EQ(ask(nullptr, GarmentKind::top), "");
    EXPECT_EQ(ask(&women, GarmentKind::top), "Your size: M");
    adviser.reset();
    EXPECT_EQ(words(adviser.advice()), kMeasuring);
    EXPECT_EQ(ask(&women, GarmentKind::top), kMeasuring) << "a newcomer's size must last before it is told";
}

TEST(SizeAdviser, takesTimeThatRunsBackwardsAsNone) {
    const SizeChart chart = womensChart();
    SizeAdviser adviser;
    const Measurements measurements = measured(0.94, 0.0, 0.0, 0.005);
    hal::TimePoint now = hal::TimePoint{} + std::chrono::seconds(100);
    for (int i = 0; i < 30; ++i, now += kFrame)
        adviser.update({.measurements = &measurements, .chart = &chart, .kind = GarmentKind::top}, now);
    const Measurements larger = measured(1.02, 0.0, 0.0, 0.005);
    hal::TimePoint earlier{};
    for (int i = 0; i < 30; ++i, earlier += kFrame)
        adviser.update({.measurements = &larger, .chart = &chart, .kind = GarmentKind::top}, earlier);
    EXPECT_EQ(words(adviser.advice()), "Your size: L");
}

TEST(SizeAdviser, takesNoHeapMemory) {
    const SizeChart chart = womensChart();
    SizeAdviser adviser;
    AdviceText memory{};
    hal::TimePoint now{};
    const test::AllocationCounter counter;
    std::size_t length = 0;
    for (int i = 0; i < 300; ++i, now += kFrame) {
        const Measurements measurements = measured(0.60 + i / 300.0, 0.78, 1.10, 0.012);
        const GarmentKind kind = i % 7 == 0 ? GarmentKind::dress : GarmentKind::top;
        length +=
            adviceInWords(adviser.update({.measurements = &measurements, .chart = &chart, .kind = kind}, now), memory)
                .size();
    }
    EXPECT_EQ(counter.count(), 0U);
    EXPECT_GT(length, 0U);
}

TEST(SizeWords, fitTheirMemoryWithTheLongestNames) {
    AdviceText memory{};
    const SizeAdvice advice{.certainty = AdviceCertainty::between,
                            .reason = AdviceReason::none,
                            .size = SizeName("longest"),
                            .largerSize = SizeName("longest and cut")};
    EXPECT_EQ(adviceInWords(advice, memory), "Between longest and longest");
}

}  // namespace
}  // namespace cheval::fitting

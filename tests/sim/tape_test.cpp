#include "hal/sim/tape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "hal/sim/figure.h"
#include "hal/sim/world.h"
#include "tests/support/allocation_counter.h"

namespace cheval::hal::sim {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using fitting::Dimension;

constexpr double kTau = 2.0 * std::numbers::pi;
constexpr std::array<fitting::Side, 2> kSides = {fitting::Side::left, fitting::Side::right};

float of(const TrueMeasurements& truth, Dimension dimension) {
    return truth[static_cast<std::size_t>(dimension)];
}

std::vector<Vector2f> superellipse(double across, double ahead, double squareness, int count) {
    std::vector<Vector2f> points;
    for (int i = 0; i < count; ++i) {
        const double angle = kTau * i / count;
        const auto swell = [&](double value) {
            return std::copysign(std::pow(std::abs(value), 2.0 / squareness), value);
        };
        points.emplace_back(static_cast<float>(across * swell(std::cos(angle))),
                            static_cast<float>(ahead * swell(std::sin(angle))));
    }
    return points;
}

TEST(Tape, GoesRoundAnEllipseAsRamanujanHasIt) {
    constexpr double kA = 0.17;
    constexpr double kB = 0.11;
    const double share = (kA - kB) * (kA - kB) / ((kA + kB) * (kA + kB));
    const double expected = 0.5 * kTau * (kA + kB) * (1.0 + 3.0 * share / (10.0 + std::sqrt(4.0 - 3.0 * share)));
    std::vector<Vector2f> points = superellipse(kA, kB, 2.0, 200);
    EXPECT_NEAR(tapeLength(points), expected, 2e-4);
    // A trunk's forty segments lose no millimetre and a half.
    points = superellipse(kA, kB, 2.0, 40);
    EXPECT_NEAR(tapeLength(points), expected, 1.5e-3);
}

TEST(Tape, IsLongerAboutSquarerSections) {
    float before = 0.0F;
    for (const double squareness : {1.9, 2.25, 2.6, 8.0}) {
        std::vector<Vector2f> points = superellipse(0.17, 0.11, squareness, 240);
        const float length = tapeLength(points);
        EXPECT_GT(length, before);
        EXPECT_LT(length, 4.0F * 0.28F);
        before = length;
    }
}

TEST(Tape, BridgesHollowsAndForgivesPointsThatLieTogether) {
    std::vector<Vector2f> points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5F, 0.2F}, {0.5F, 0.5F}, {1, 1}, {0.5F, 1}};
    EXPECT_NEAR(tapeLength(points), 4.0F, 1e-6F);
    points = {{0.3F, 0.3F}, {0.3F, 0.3F}};
    EXPECT_EQ(tapeLength(points), 0.0F);
}

TEST(Tape, MeasuresABodyTwiceAsTallTwiceAsLong) {
    Shopper shopper = makeMeasuredShopper(3, 1, Clothing::tight, false);
    const TrueMeasurements once = measureBare(shopper);
    shopper.stature *= 2.0F;
    shopper.headHeight *= 2.0F;
    const TrueMeasurements twice = measureBare(shopper);
    for (std::size_t i = 0; i < once.size(); ++i)
        EXPECT_NEAR(twice[i], 2.0F * once[i], 2e-4F * twice[i]) << fitting::kDimensionNames[i];
}

TEST(Tape, KnowsNothingOfClothesShoesAndHair) {
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        Shopper shopper = makeMeasuredShopper(seed, 0, Clothing::tight, false);
        const TrueMeasurements bare = measureBare(shopper);
        shopper.clothEase = 0.02F;
        shopper.trouserEase = 0.02F;
        shopper.drape = {.ease = 0.08F, .hem = -0.2F, .flare = 0.1F, .folds = 0.02F};
        shopper.hairStyle = HairStyle::bob;
        shopper.hairRise = 0.03F;
        shopper.lift = 0.035F;
        EXPECT_EQ(measureBare(shopper), bare);
    }
}

TEST(Tape, TakesNoMemory) {
    const Shopper shopper = makeShopper(3, 1);
    const cheval::test::AllocationCounter counter;
    static_cast<void>(measureBare(shopper));
    EXPECT_EQ(counter.count(), 0U);
}

TEST(Tape, MeasuresWhatABiggerShareAdds) {
    const Shopper shopper = makeShopper(9, 1);
    const TrueMeasurements before = measureBare(shopper);
    const auto change = [&](auto&& alter, Dimension dimension) {
        Shopper altered = shopper;
        alter(altered.shares);
        return of(measureBare(altered), dimension) - of(before, dimension);
    };
    EXPECT_GT(change([](BodyShares& s) { s.bust = 0.01F; }, Dimension::chestGirth), 0.01F);
    EXPECT_GT(change([](BodyShares& s) { s.belly = 0.01F; }, Dimension::waistGirth), 0.01F);
    EXPECT_GT(change([](BodyShares& s) { s.seat = 0.01F; }, Dimension::hipGirth), 0.01F);
    EXPECT_NEAR(change([](BodyShares& s) { s.bust = 0.01F; }, Dimension::hipGirth), 0.0F, 1e-4F);
    EXPECT_NEAR(change([](BodyShares& s) { s.neckGirth = 1.1F; }, Dimension::neckGirth),
                0.1F * of(before, Dimension::neckGirth), 1e-3F);
    EXPECT_NEAR(change([](BodyShares& s) { s.leg = 0.01F; }, Dimension::insideLeg), 0.0105F * shopper.stature, 1e-3F);
    EXPECT_NEAR(change([](BodyShares& s) { s.leg = 0.01F; }, Dimension::stature), 0.0F, 1e-6F);
    EXPECT_NEAR(change([](BodyShares& s) { s.armLength = 1.1F; }, Dimension::armLength),
                0.1F * of(before, Dimension::armLength), 1e-4F);
}

/// Mean and deviation of a dimension among grown-ups of one sex.
struct Spread {
    double sum = 0.0, squares = 0.0;
    int count = 0;
    void add(double value) {
        sum += value;
        squares += value * value;
        ++count;
    }
    [[nodiscard]] double mean() const { return sum / count; }
    [[nodiscard]] double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
};

TEST(MeasuredShopper, IsSpreadAsThePopulationIs) {
    struct Expected {
        Dimension dimension;
        double mean, deviation;
    };
    constexpr std::array<Expected, 4> kWomen = {{{Dimension::stature, 1.63, 0.065},
                                                 {Dimension::chestGirth, 0.94, 0.10},
                                                 {Dimension::waistGirth, 0.78, 0.11},
                                                 {Dimension::hipGirth, 1.02, 0.09}}};
    constexpr std::array<Expected, 4> kMen = {{{Dimension::stature, 1.76, 0.07},
                                               {Dimension::chestGirth, 1.02, 0.09},
                                               {Dimension::waistGirth, 0.90, 0.11},
                                               {Dimension::hipGirth, 1.01, 0.075}}};
    std::array<std::array<Spread, fitting::kDimensionCount>, 2> spreads;
    for (std::uint32_t seed = 0; seed < 1500; ++seed) {
        const Shopper shopper = makeMeasuredShopper(seed, 0, Clothing::tight, false);
        const TrueMeasurements truth = measureBare(shopper);
        for (std::size_t i = 0; i < truth.size(); ++i)
            spreads[shopper.masculine > 0.5F ? 1 : 0][i].add(static_cast<double>(truth[i]));
    }
    for (const std::size_t sex : {0U, 1U}) {
        for (const auto& [dimension, mean, deviation] : sex == 0 ? kWomen : kMen) {
            const auto which = static_cast<std::size_t>(dimension);
            const Spread& spread = spreads[sex][which];
            EXPECT_GT(spread.count, 600);
            EXPECT_NEAR(spread.mean(), mean, 0.012) << fitting::kDimensionNames[which] << " of sex " << sex;
            EXPECT_NEAR(spread.deviation(), deviation, 0.012) << fitting::kDimensionNames[which] << " of sex " << sex;
        }
    }
}

TEST(MeasuredShopper, ComesAsAChildOrSeatedOnlyWhenAsked) {
    int children = 0, seated = 0;
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        const Shopper adult = makeMeasuredShopper(seed, 0, Clothing::tight, false);
        EXPECT_GT(adult.stature, 1.46F);
        EXPECT_FALSE(adult.wheelchair);
        const Shopper anybody = makeMeasuredShopper(seed, 0, Clothing::tight, true);
        children += anybody.stature < 1.45F ? 1 : 0;
        seated += anybody.wheelchair ? 1 : 0;
    }
    EXPECT_GT(children, 10);
    EXPECT_GT(seated, 3);
}

/// Whether a vertex is an arm's or a hand's.
bool isArm(const Hold& hold) {
    return std::any_of(kSides.begin(), kSides.end(), [&](fitting::Side side) {
        const auto within = [&](std::size_t which) {
            return (which >= bone(side, SideBone::upperArm) && which <= bone(side, SideBone::hand)) ||
                   (which >= phalanx(side, 0, 0) && which <= phalanx(side, kFingerCount - 1, kPhalanxCount - 1));
        };
        return within(hold.first) || within(hold.second);
    });
}

/// Where a mesh's edges pass a height, arms left out; x and z.
std::vector<Vector2f> sectionAt(const Mesh& mesh, float height) {
    std::vector<Vector2f> section;
    for (const auto& triangle : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3f& a = mesh.positions[triangle[i]];
            const Vector3f& b = mesh.positions[triangle[(i + 1) % 3]];
            if ((a.y() - height) * (b.y() - height) > 0.0F || a.y() == b.y()) continue;
            if (isArm(mesh.holds[triangle[i]])) continue;
            const Vector3f p = a + (height - a.y()) / (b.y() - a.y()) * (b - a);
            section.emplace_back(p.x(), p.z());
        }
    }
    return section;
}

/// How far a mesh's skin reaches from the middle in 32 directions at a height, arms left out; −1: not there.
std::array<float, 32> reachAt(const Mesh& mesh, float height) {
    std::array<float, 32> reach;
    reach.fill(-1.0F);
    for (const Vector2f& p : sectionAt(mesh, height)) {
        for (std::size_t k = 0; k < reach.size(); ++k) {
            const auto angle = static_cast<float>(kTau * static_cast<double>(k) / 32.0);
            reach[k] = std::max(reach[k], p.x() * std::cos(angle) + p.y() * std::sin(angle));
        }
    }
    return reach;
}

/// A tape about the points that lie farthest out in each of 180 directions.
float tapeAbout(const std::vector<Vector2f>& section) {
    std::vector<Vector2f> farthest;
    for (int k = 0; k < 180; ++k) {
        const double angle = kTau * k / 180.0;
        const Vector2f way(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
        farthest.push_back(*std::max_element(section.begin(), section.end(), [&](const Vector2f& a, const Vector2f& b) {
            return a.dot(way) < b.dot(way);
        }));
    }
    return tapeLength(farthest);
}

TEST(Tape, AgreesWithCutsThroughTheMeshThatIsDrawn) {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        const Shopper bare = makeMeasuredShopper(seed, 0, Clothing::bare, false);
        const Rig rig = makeRig(bare);
        Mesh mesh;
        buildFigure(bare, rig, mesh);
        const TrueMeasurements truth = measureBare(bare);
        const float crotch = (0.475F + bare.shares.leg) * bare.stature;
        const float trunk = rig.at(Bone::neck).y() - crotch;
        EXPECT_NEAR(of(truth, Dimension::chestGirth), tapeAbout(sectionAt(mesh, crotch + 0.67F * trunk)), 1e-3F);
        EXPECT_NEAR(of(truth, Dimension::waistGirth), tapeAbout(sectionAt(mesh, crotch + 0.42F * trunk)), 1e-3F);
        // Hips: at one of the levels below the belt, none of which is larger by much.
        float widest = 0.0F;
        for (int level = 0; level <= 25; ++level)
            widest = std::max(widest, tapeAbout(sectionAt(mesh, crotch + 0.01F * static_cast<float>(level) * trunk)));
        EXPECT_LE(of(truth, Dimension::hipGirth), widest + 1e-3F);
        EXPECT_GT(of(truth, Dimension::hipGirth), widest - 0.05F);
        float highest = 0.0F;
        for (const Vector3f& p : mesh.positions)
            highest = std::max(highest, p.y());
        EXPECT_NEAR(of(truth, Dimension::stature), highest, 1e-4F);
    }
}

class EveryClothing : public testing::TestWithParam<Clothing> {};

TEST_P(EveryClothing, OnlyEverAddsToTheBody) {
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        const Shopper dressed = makeMeasuredShopper(seed, 0, GetParam(), false);
        const Shopper bare = bareOf(dressed);
        Mesh clothes, body;
        buildFigure(dressed, makeRig(dressed), clothes);
        buildFigure(bare, makeRig(bare), body);
        EXPECT_LE(clothes.positions.size(), kMaximumFigureVertices);
        EXPECT_LE(clothes.triangles.size(), kMaximumFigureTriangles);
        for (int level = 6; level < 76; ++level) {
            const float share = 0.013F * static_cast<float>(level);
            const float height = share * bare.stature;
            const auto skin = reachAt(body, height);
            const auto cloth = reachAt(clothes, height + dressed.lift);
            for (std::size_t k = 0; k < skin.size(); ++k)
                ASSERT_GT(cloth[k], skin[k] - 5e-4F) << "seed " << seed << " at " << share << ", direction " << k;
        }
    }
}

TEST_P(EveryClothing, LiftsTheCrownByTheSolesAlone) {
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        const World world({.seed = seed, .script = Script::measuring, .clothing = GetParam()});
        const FigureTruth truth = truthAt(world, 5.0).figures[0];
        const Shopper shopper = makeMeasuredShopper(seed, 0, GetParam(), false);
        EXPECT_EQ(truth.measurements, measureBare(shopper));
        EXPECT_NEAR(truth.statureMetres, of(truth.measurements, Dimension::stature) + shopper.lift, 0.003F);
    }
}

TEST_P(EveryClothing, IsWornByTheSameBody) {
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        EXPECT_EQ(measureBare(makeMeasuredShopper(seed, 0, GetParam(), false)),
                  measureBare(makeMeasuredShopper(seed, 0, Clothing::bare, false)));
    }
}

std::string nameOf(const testing::TestParamInfo<Clothing>& info) {
    constexpr std::array<const char*, 5> kNames = {"bare", "tight", "ordinary", "loose", "wide"};
    return kNames[static_cast<std::size_t>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(Kinds, EveryClothing,
                         testing::Values(Clothing::bare, Clothing::tight, Clothing::ordinary, Clothing::loose,
                                         Clothing::wide),
                         nameOf);

TEST(Clothing, HidesTheWaistWhereItIsLoose) {
    const auto waistOf = [](Clothing clothing, std::uint32_t seed) {
        const Shopper shopper = makeMeasuredShopper(seed, 0, clothing, false);
        Mesh mesh;
        const Rig rig = makeRig(shopper);
        buildFigure(shopper, rig, mesh);
        const float crotch = (0.475F + shopper.shares.leg) * shopper.stature + shopper.lift;
        const auto reach = reachAt(mesh, crotch + 0.42F * (rig.at(Bone::neck).y() - crotch));
        return reach[8] + reach[24];  // Ahead and behind.
    };
    int hidden = 0;
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        EXPECT_LT(waistOf(Clothing::tight, seed) - waistOf(Clothing::bare, seed), 0.02F);
        hidden += waistOf(Clothing::loose, seed) - waistOf(Clothing::bare, seed) > 0.04F ? 1 : 0;
    }
    EXPECT_GT(hidden, 10);
}

TEST(Clothing, HangsInFoldsWhereItIsLoose) {
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        Mesh mesh;
        const Shopper tight = makeMeasuredShopper(seed, 0, Clothing::tight, false);
        buildFigure(tight, makeRig(tight), mesh);
        EXPECT_TRUE(mesh.folds.empty());
        const Shopper loose = makeMeasuredShopper(seed, 0, Clothing::loose, false);
        buildFigure(loose, makeRig(loose), mesh);
        ASSERT_FALSE(mesh.folds.empty());
        float deepest = 0.0F;
        for (const Fold& fold : mesh.folds) {
            ASSERT_LT(fold.vertex, mesh.positions.size());
            deepest = std::max(deepest, fold.reach);
        }
        EXPECT_GT(deepest, 0.003F);
        EXPECT_LE(deepest, loose.drape.folds);
    }
}

TEST(Clothing, ShowsMoreOfWhoIsLooselyDressedInEveryFrame) {
    const auto breadths = [](Clothing clothing) {
        World world({.seed = 12,
                     .colour = false,
                     .sensorNoise = false,
                     .script = Script::measuring,
                     .visitSeconds = 23.0,
                     .clothing = clothing});
        Image<std::uint16_t> depth;
        Image<Rgb8> none;
        std::vector<int> pixels;
        for (std::uint64_t frame = 130; frame < 180; frame += 10) {
            renderFrame(world, frame, depth, none);
            const ImageView<const std::uint8_t> owner = exactView(world).owner;
            int seen = 0;
            for (int y = 0; y < owner.height; ++y)
                seen += static_cast<int>(std::count(owner.row(y), owner.row(y) + owner.width, std::uint8_t{1}));
            pixels.push_back(seen);
        }
        return pixels;
    };
    const std::vector<int> bare = breadths(Clothing::bare);
    const std::vector<int> loose = breadths(Clothing::loose);
    for (std::size_t i = 0; i < bare.size(); ++i)
        EXPECT_GT(loose[i], bare[i] + 300);
}

}  // namespace
}  // namespace cheval::hal::sim

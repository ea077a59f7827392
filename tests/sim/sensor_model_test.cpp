// The sensor model against the literature: Khoshelham & Elberink, Sensors 12(2), 2012.
#include "hal/sim/sensor_model.h"

#include <cmath>
#include <cstdint>
#include <set>

#include <gtest/gtest.h>

namespace cheval::hal::sim {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

Room flatRoom(float depthMm, Material material = Material::room) {
    Room room;
    room.depth.resize(kWidth, kHeight, depthMm);
    room.material.resize(kWidth, kHeight, material);
    room.colour.resize(kWidth, kHeight);
    return room;
}

struct Box {
    int left, top, right, bottom;
    float depthMm;
    Material material = Material::cloth;
};

Image<std::uint16_t> sense(const Room& room, std::uint64_t frame, std::uint32_t key = 1) {
    SensorModel sensor(Intrinsics{}, room, key);
    Image<std::uint16_t> readings(kWidth, kHeight);
    sensor.sense(room.depth, room.material, {}, frame, readings.view());
    return readings;
}

Image<std::uint16_t> senseBox(const Room& room, const Box& box, std::uint64_t frame = 0) {
    SensorModel sensor(Intrinsics{}, room, 1);
    Image<float> depth = room.depth;
    Image<Material> material = room.material;
    for (int y = box.top; y < box.bottom; ++y) {
        for (int x = box.left; x < box.right; ++x) {
            depth.view().at(x, y) = box.depthMm;
            material.view().at(x, y) = box.material;
        }
    }
    Image<std::uint16_t> readings(kWidth, kHeight);
    const PixelBox changed{box.left - 60, box.top - 4, box.right + 4, box.bottom + 4};
    sensor.sense(depth, material, changed, frame, readings.view());
    return readings;
}

struct Statistics {
    double mean = 0.0, deviation = 0.0, valid = 0.0, step = 0.0;
};
Statistics statistics(const Image<std::uint16_t>& readings) {
    double sum = 0.0;
    double squares = 0.0;
    double count = 0.0;
    std::set<std::uint16_t> levels;
    // Away from the borders, where the projector's light ends.
    for (int y = 20; y < kHeight - 20; ++y) {
        for (int x = 20; x < kWidth - 100; ++x) {
            const double z = readings.view().at(x, y);
            if (z <= 0.0) continue;
            sum += z;
            squares += z * z;
            count += 1.0;
            levels.insert(readings.view().at(x, y));
        }
    }
    Statistics result;
    result.mean = sum / count;
    result.deviation = std::sqrt(squares / count - result.mean * result.mean);
    result.valid = count / ((kHeight - 40.0) * (kWidth - 120.0));
    result.step =
        levels.size() > 1 ? (*levels.rbegin() - *levels.begin()) / (static_cast<double>(levels.size()) - 1.0) : 0.0;
    return result;
}

/// Distance, and the ranges in which deviation and quantisation step must lie, millimetres.
struct Expectation {
    float depthMm;
    double deviationLow, deviationHigh, stepLow, stepHigh;
};
class Noise : public testing::TestWithParam<Expectation> {};

TEST_P(Noise, GrowsWithTheSquareOfDepth) {
    const Expectation& expected = GetParam();
    const Statistics seen = statistics(sense(flatRoom(expected.depthMm), 7));
    EXPECT_NEAR(seen.mean, expected.depthMm, 0.004 * expected.depthMm);
    EXPECT_GT(seen.deviation, expected.deviationLow);
    EXPECT_LT(seen.deviation, expected.deviationHigh);
    EXPECT_GE(seen.step, expected.stepLow);
    EXPECT_LE(seen.step, expected.stepHigh);
    EXPECT_GT(seen.valid, 0.999);
}
INSTANTIATE_TEST_SUITE_P(Distances, Noise,
                         testing::Values(Expectation{1000.0F, 1.2, 2.2, 2.5, 3.4},
                                         Expectation{2400.0F, 7.5, 11.0, 16.0, 18.0},
                                         Expectation{3000.0F, 12.5, 17.0, 25.0, 28.0},
                                         Expectation{5000.0F, 36.0, 47.0, 70.0, 78.0}));

TEST(SensorModel, ReadsOnlyWholeStepsOfDisparity) {
    const Image<std::uint16_t> readings = sense(flatRoom(2600.0F), 3);
    for (const std::uint16_t reading : readings.pixels) {
        if (reading == 0) continue;
        const double steps = 570.3 * kBaselineMm / reading / kDisparityStep;
        // Rounding to millimetres moves a step by at most half a millimetre.
        ASSERT_NEAR(steps, std::round(steps), 0.5 * 570.3 * 75.0 / (2600.0 * 2600.0) / kDisparityStep * 1.1);
    }
}

TEST(SensorModel, HalfOfTheNoiseStaysAndHalfChanges) {
    const Room room = flatRoom(3000.0F);
    const Image<std::uint16_t> first = sense(room, 100);
    const Image<std::uint16_t> second = sense(room, 101);
    double product = 0.0;
    double square = 0.0;
    for (std::size_t i = 0; i < first.pixels.size(); ++i) {
        if (first.pixels[i] == 0 || second.pixels[i] == 0) continue;
        const double a = first.pixels[i] - 3000.0;
        const double b = second.pixels[i] - 3000.0;
        product += a * b;
        square += 0.5 * (a * a + b * b);
    }
    EXPECT_GT(product / square, 0.25);
    EXPECT_LT(product / square, 0.65);
}

TEST(SensorModel, CastsTheShadowOnTheLeftAsWideAsTheDisparitiesDiffer) {
    const Box box{300, 150, 380, 330, 2000.0F};
    const Image<std::uint16_t> readings = senseBox(flatRoom(4000.0F), box);
    const int width = static_cast<int>(570.3F * kBaselineMm * (1.0F / 2000.0F - 1.0F / 4000.0F));  // 10 pixels.
    for (int y = 160; y < 320; ++y) {
        for (int x = 300 - width + 1; x < 299; ++x)
            ASSERT_EQ(readings.view().at(x, y), 0) << x << ' ' << y;
    }
    int left = 0;
    int right = 0;
    for (int y = 160; y < 320; ++y) {
        for (int x = 4; x < 20; ++x) {
            if (readings.view().at(300 - width - x, y) > 3500) ++left;
            if (readings.view().at(379 + x, y) > 3500) ++right;
        }
    }
    EXPECT_GT(left, 160 * 14);
    EXPECT_GT(right, 160 * 14);
}

TEST(SensorModel, SeesBehindAFingerOnBothSidesOfItsShadow) {
    // Four pixels wide and far before the wall: its shadow stands free of it.
    const Box finger{400, 150, 404, 330, 1200.0F};
    const Image<std::uint16_t> readings = senseBox(flatRoom(4000.0F), finger);
    const float shift = 570.3F * kBaselineMm * (1.0F / 1200.0F - 1.0F / 4000.0F);
    const int shadow = 402 - static_cast<int>(shift);
    int between = 0;
    int inShadow = 0;
    for (int y = 160; y < 320; ++y) {
        if (readings.view().at(shadow, y) != 0) ++inShadow;
        if (readings.view().at((shadow + 400) / 2, y) != 0) ++between;
    }
    EXPECT_EQ(inShadow, 0);
    EXPECT_GT(between, 150);
}

TEST(SensorModel, LosesReadingsAtEdgesButFewInside) {
    const Box box{200, 100, 400, 380, 2400.0F};
    const Image<std::uint16_t> readings = senseBox(flatRoom(3900.0F), box);
    int edgeLost = 0;
    int insideLost = 0;
    int edges = 0;
    int inside = 0;
    for (int y = 110; y < 370; ++y) {
        for (const int x : {200, 399}) {
            ++edges;
            edgeLost += readings.view().at(x, y) == 0 ? 1 : 0;
        }
        for (int x = 210; x < 390; ++x) {
            ++inside;
            insideLost += readings.view().at(x, y) == 0 ? 1 : 0;
        }
    }
    EXPECT_GT(edgeLost, edges / 4);
    EXPECT_LT(edgeLost, 3 * edges / 4);
    EXPECT_LT(insideLost, inside / 200);
}

TEST(SensorModel, LosesHairAndDarkClothButNotSkin) {
    const auto lost = [](Material material) {
        const Image<std::uint16_t> readings = sense(flatRoom(2400.0F, material), 5);
        return 1.0 - statistics(readings).valid;
    };
    EXPECT_LT(lost(Material::skin), 0.002);
    EXPECT_NEAR(lost(Material::darkCloth), 0.05, 0.02);
    EXPECT_NEAR(lost(Material::hair), 0.30, 0.06);
}

TEST(SensorModel, DropsOutFlickeringPartlyAndPartlyForGood) {
    const Room room = flatRoom(2400.0F, Material::hair);
    const Image<std::uint16_t> first = sense(room, 1);
    const Image<std::uint16_t> second = sense(room, 2);
    double both = 0.0;
    double one = 0.0;
    double all = 0.0;
    for (std::size_t i = 0; i < first.pixels.size(); ++i) {
        all += 1.0;
        one += first.pixels[i] == 0 ? 1.0 : 0.0;
        both += first.pixels[i] == 0 && second.pixels[i] == 0 ? 1.0 : 0.0;
    }
    EXPECT_GT(both / one, 1.3 * one / all);  // More than chance …
    EXPECT_LT(both / one, 0.9);              // … but not always the same.
}

TEST(SensorModel, ReadsNothingOutOfRange) {
    for (const float depth : {0.0F, 300.0F, 6500.0F}) {
        const Image<std::uint16_t> readings = sense(flatRoom(depth), 2);
        for (const std::uint16_t reading : readings.pixels)
            ASSERT_EQ(reading, 0);
    }
}

TEST(SensorModel, DoesNotDependOnHowMuchIsSaidToHaveChanged) {
    const Room room = flatRoom(3900.0F);
    SensorModel sensor(Intrinsics{}, room, 4);
    Image<float> depth = room.depth;
    for (int y = 100; y < 200; ++y) {
        for (int x = 250; x < 330; ++x)
            depth.view().at(x, y) = 2300.0F;
    }
    Image<std::uint16_t> little(kWidth, kHeight);
    Image<std::uint16_t> much(kWidth, kHeight);
    sensor.sense(depth, room.material, {210, 60, 370, 240}, 9, little.view());
    sensor.sense(depth, room.material, {0, 0, kWidth, kHeight}, 9, much.view());
    EXPECT_EQ(little.pixels, much.pixels);
}

}  // namespace
}  // namespace cheval::hal::sim

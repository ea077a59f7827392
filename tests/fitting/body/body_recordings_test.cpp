// The estimator on recordings of shoppers, given their true joints and outlines: what is left is its own error.
#include <cstdio>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fitting/body/body_estimator.h"
#include "hal/png/png.h"

using namespace cheval;
using namespace cheval::fitting;
using nlohmann::json;

namespace {

SensorPlacement placementOf(const json& camera) {
    SensorPlacement placement;
    for (int row = 0; row < 3; ++row) {
        const auto r = static_cast<std::size_t>(row);
        for (int column = 0; column < 3; ++column) {
            placement.rotation(row, column) = camera["rotation"][r][static_cast<std::size_t>(column)].get<float>();
        }
        placement.translation[row] = camera["translation"][r].get<float>() * 1e-3F;
    }
    // Sensor x is mirror −x.
    placement.rotation.row(0) *= -1.0F;
    placement.translation.x() *= -1.0F;
    return placement;
}

Skeleton skeletonOf(const json& truth, const SensorPlacement& placement) {
    Skeleton skeleton;
    skeleton.userId = 1;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        const std::string name(kJointNames[i]);
        const json& at = truth["joints"][name];
        skeleton.joints[i].position = placement.toMirror({at[0].get<float>(), at[1].get<float>(), at[2].get<float>()});
        skeleton.joints[i].confidence = truth["visible"][name].get<bool>() ? 1.0F : 0.2F;
    }
    return skeleton;
}

class RecordedShopper : public testing::TestWithParam<const char*> {};

}  // namespace

TEST_P(RecordedShopper, IsMeasuredFromTrueJointsAndOutline) {
    const std::string folder = std::string(CHEVAL_DATA) + "/shoppers/" + GetParam();
    std::ifstream file(folder + "/truth.json");
    ASSERT_TRUE(file.is_open());
    const json truth = json::parse(file);
    const auto body = loadBody(std::string(CHEVAL_ASSETS) + "/body.glb");
    ASSERT_TRUE(body.hasValue()) << body.error().message();
    BodyEstimator estimator(*body, {.averagedFrames = 15});
    const SensorPlacement placement = placementOf(truth["camera"]["sensor_to_floor"]);

    hal::Image<std::uint16_t> depth;
    hal::Image<hal::Rgb8> mask;
    hal::Image<std::uint8_t> map;
    for (std::size_t i = 0; i < truth["truth"].size(); i += 10) {
        std::string number = std::to_string(i);
        number = std::string(4 - number.size(), '0') + number + ".png";
        ASSERT_TRUE(hal::readPng(folder + "/depth-" + number, depth).hasValue());
        ASSERT_TRUE(hal::readPng(folder + "/mask-" + number, mask).hasValue());
        map.resize(mask.width, mask.height);
        // A tracker's map has no pixel where the sensor saw nothing.
        for (std::size_t p = 0; p < map.pixels.size(); ++p) {
            map.pixels[p] = mask.pixels[p].r == 1 && depth.pixels[p] != 0 ? 1 : 0;
        }
        hal::DepthFrame frame;
        frame.depth = depth.view();
        Users users;
        users.count = 1;
        users.users[0] = {.id = 1, .label = 1};
        users.activeId = 1;
        users.map = map.view();
        // Outlines are known of every tenth frame only: each stands for three.
        for (int repeat = 0; repeat < 3; ++repeat) {
            estimator.update(frame, users, skeletonOf(truth["truth"][i], placement), placement);
        }
    }

    const auto error = [&](Dimension dimension) {
        const Measurement& measured = estimator.measurements()[dimension];
        const auto exact =
            truth["measurements"][std::string(kDimensionNames[static_cast<std::size_t>(dimension)])].get<float>() *
            0.01F;
        EXPECT_TRUE(measured.valid) << kDimensionNames[static_cast<std::size_t>(dimension)];
        std::printf("%s %s: %.3f m ± %.3f, truth %.3f\n", GetParam(),
                    std::string(kDimensionNames[static_cast<std::size_t>(dimension)]).c_str(),
                    static_cast<double>(measured.value), static_cast<double>(measured.uncertainty),
                    static_cast<double>(exact));
        return std::abs(measured.value - exact);
    };
    const Eigen::Vector3f& scale = estimator.shape().scale;
    std::printf("%s scale %.3f %.3f %.3f\n", GetParam(), static_cast<double>(scale.x()), static_cast<double>(scale.y()),
                static_cast<double>(scale.z()));
    EXPECT_LT(error(Dimension::stature), 0.03F);
    EXPECT_LT(error(Dimension::shoulderBreadth), 0.005F);
    EXPECT_LT(error(Dimension::armLength), 0.015F);
    if (estimator.measurements()[Dimension::insideLeg].valid) {
        EXPECT_LT(error(Dimension::insideLeg), 0.06F);  // Trousers hang below the crotch.
    }
}

INSTANTIATE_TEST_SUITE_P(BodyEstimator, RecordedShopper, testing::Values("seq01", "seq02", "seq03", "seq04", "seq05"),
                         [](const auto& test) { return std::string(test.param); });

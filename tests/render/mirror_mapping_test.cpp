#include "render/mirror_mapping.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "render/projection.h"
#include "tests/render/render_scene.h"

namespace cheval::render {
namespace {

using test::Mounting;
using test::RenderScene;

MirrorMapping mappingOf(const RenderScene& world, int width = 1080, int height = 1920) {
    const Scene scene = world.scene();
    CropFollower crop;
    return crop.follow(640, 480, width, height, uprightTurn(world.rotated(), world.placement()), world.intrinsics(),
                       world.placement(), scene.skeleton);
}

class Mount : public ::testing::TestWithParam<Mounting> {};
INSTANTIATE_TEST_SUITE_P(All, Mount, ::testing::Values(Mounting::upright, Mounting::rightEdgeUp, Mounting::leftEdgeUp));

TEST_P(Mount, sensorPixelAndDisplayMatrixAgree) {
    const RenderScene world({.mounting = GetParam()});
    const MirrorMapping mapping = mappingOf(world);
    const Eigen::Matrix3f displayFromSensor = mapping.displayFromSensor();
    for (int y = 3; y < mapping.mirroredHeight(); y += 97) {
        for (int x = 5; x < mapping.mirroredWidth(); x += 89) {
            const Eigen::Vector2f expected((static_cast<float>(x) + 0.5F - mapping.cropLeft) * mapping.scale,
                                           (static_cast<float>(y) + 0.5F - mapping.cropTop) * mapping.scale);
            const Eigen::Vector2f sensor = mapping.sensorPixel(x, y).cast<float>();
            EXPECT_LT(((displayFromSensor * sensor.homogeneous()).head<2>() - expected).norm(), 1e-2F);
        }
    }
}

TEST_P(Mount, upIsUpAndTheShoppersLeftIsAtTheLeft) {
    const RenderScene world({.mounting = GetParam()});
    const MirrorMapping mapping = mappingOf(world);
    const Projection projection = mirrorProjection(mapping, world.intrinsics(), world.placement());
    const Eigen::Vector3f point(0.0F, 1.2F, 2.0F);
    const Eigen::Vector2f here = projectPoint(projection, point);
    EXPECT_LT(projectPoint(projection, point + Eigen::Vector3f(0, 0.1F, 0)).y(), here.y() - 10.0F);
    EXPECT_LT(projectPoint(projection, point - Eigen::Vector3f(0.1F, 0, 0)).x(), here.x() - 10.0F);
}

TEST_P(Mount, projectionIsThePinholeThenTheMapping) {
    const RenderScene world({.mounting = GetParam()});
    const MirrorMapping mapping = mappingOf(world);
    const Projection projection = mirrorProjection(mapping, world.intrinsics(), world.placement());
    for (const Eigen::Vector3f& point :
         {Eigen::Vector3f(0.3F, 1.4F, 1.8F), Eigen::Vector3f(-0.2F, 0.6F, 2.6F), Eigen::Vector3f(0.0F, 1.0F, 1.0F)}) {
        const Eigen::Vector2f pixel = fitting::project(world.intrinsics(), world.placement().toSensor(point));
        const Eigen::Vector2f expected = (mapping.displayFromSensor() * pixel.homogeneous()).head<2>();
        EXPECT_LT((projectPoint(projection, point) - expected).norm(), 0.05F);
    }
}

TEST_P(Mount, cropFillsTheDisplayAndStaysInsideThePicture) {
    for (const float x : {-1.5F, -0.4F, 0.0F, 0.3F, 2.0F}) {
        const RenderScene world({.mounting = GetParam(), .personX = x});
        for (const auto& [width, height] : {std::pair{1080, 1920}, std::pair{1920, 1080}, std::pair{600, 600}}) {
            const MirrorMapping mapping = mappingOf(world, width, height);
            const float right = mapping.cropLeft + static_cast<float>(width) / mapping.scale;
            const float bottom = mapping.cropTop + static_cast<float>(height) / mapping.scale;
            EXPECT_GE(mapping.cropLeft, -1e-2F);
            EXPECT_GE(mapping.cropTop, -1e-2F);
            EXPECT_LE(right, static_cast<float>(mapping.mirroredWidth()) + 1e-2F);
            EXPECT_LE(bottom, static_cast<float>(mapping.mirroredHeight()) + 1e-2F);
        }
    }
}

TEST(CropFollower, startsWithTheShopperInTheMiddle) {
    const RenderScene world({.personX = 0.35F});
    const MirrorMapping mapping = mappingOf(world);
    const Projection projection = mirrorProjection(mapping, world.intrinsics(), world.placement());
    const Eigen::Vector3f torso = world.scene().skeleton[fitting::Joint::torso].position;
    EXPECT_NEAR(projectPoint(projection, torso).x(), 540.0F, 1.0F);
}

TEST(CropFollower, restsWhileTheShopperSways) {
    const RenderScene world({});
    fitting::Skeleton skeleton = world.scene().skeleton;
    CropFollower crop;
    const auto left = [&] {
        return crop.follow(640, 480, 1080, 1920, Turn::none, world.intrinsics(), world.placement(), skeleton).cropLeft;
    };
    const float start = left();
    for (int i = 1; i < 30; ++i) {
        skeleton.captureTime = hal::TimePoint(hal::fromSeconds(i / 30.0));
        skeleton[fitting::Joint::torso].position.x() = 0.03F * std::sin(static_cast<float>(i) * 0.3F);
        EXPECT_FLOAT_EQ(left(), start);
    }
}

TEST(CropFollower, easesAfterAWalkingShopperWithoutJumps) {
    const RenderScene world({});
    fitting::Skeleton skeleton = world.scene().skeleton;
    CropFollower crop;
    float before = 0.0F;
    float largest = 0.0F;
    float now = 0.0F;
    for (int i = 0; i < 90; ++i) {
        skeleton.captureTime = hal::TimePoint(hal::fromSeconds(i / 30.0));
        skeleton[fitting::Joint::torso].position.x() = 0.0F + (i > 0 ? 0.5F : 0.0F);
        now = crop.follow(640, 480, 1080, 1920, Turn::none, world.intrinsics(), world.placement(), skeleton).cropLeft;
        if (i > 0) largest = std::max(largest, std::abs(now - before));
        before = now;
    }
    const Projection projection =
        mirrorProjection(crop.follow(640, 480, 1080, 1920, Turn::none, world.intrinsics(), world.placement(), skeleton),
                         world.intrinsics(), world.placement());
    EXPECT_LT(largest, 15.0F) << "picture pixels in one frame";
    EXPECT_NEAR(projectPoint(projection, skeleton[fitting::Joint::torso].position).x(), 540.0F, 110.0F);
}

TEST(CropFollower, staysWhereItWasWhenTheShopperIsGone) {
    const RenderScene world({.personX = 0.3F});
    const fitting::Skeleton skeleton = world.scene().skeleton;
    CropFollower crop;
    const auto left = [&](const fitting::Skeleton& who) {
        return crop.follow(640, 480, 1080, 1920, Turn::none, world.intrinsics(), world.placement(), who).cropLeft;
    };
    const float with = left(skeleton);
    EXPECT_FLOAT_EQ(left({}), with);
}

TEST(Projection, clipMatrixPutsTheRectanglesCornersOnTheClipCubes) {
    const RenderScene world({});
    const Projection projection = mirrorProjection(mappingOf(world), world.intrinsics(), world.placement());
    const Eigen::Vector3f point(0.1F, 1.1F, 2.0F);
    const Eigen::Vector2f pixel = projectPoint(projection, point);
    const Eigen::Matrix4f clip = clipMatrix(projection, pixel.x(), pixel.y(), 200.0F, 100.0F);
    const Eigen::Vector4f corner = clip * point.homogeneous();
    EXPECT_NEAR(corner.x() / corner.w(), -1.0F, 1e-3F);
    EXPECT_NEAR(corner.y() / corner.w(), -1.0F, 1e-3F);
    EXPECT_GT(corner.z() / corner.w(), -1.0F);
    EXPECT_LT(corner.z() / corner.w(), 1.0F);
}

TEST(Projection, eyeIsWhereTheSensorHangs) {
    const RenderScene world({.mounting = Mounting::leftEdgeUp});
    const Projection projection = mirrorProjection(mappingOf(world), world.intrinsics(), world.placement());
    EXPECT_LT((eyeOf(projection) - world.placement().translation).norm(), 1e-3F);
}

}  // namespace
}  // namespace cheval::render

#include "fitting/body/body_estimator.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "fitting/body/sample_window.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/made_body.h"

using namespace cheval;
using namespace cheval::fitting;

namespace {

// A depth picture of the made body, scaled, before a sensor at 1.1 m that looks level.
struct Scene {
    Body body = test::makeBody();
    ShapedBody shaped;
    hal::Image<std::uint16_t> depth{640, 480};
    hal::Image<std::uint8_t> map{640, 480};
    SensorPlacement placement;
    Skeleton skeleton;
    Users users;
    hal::DepthFrame frame;
    BodyEstimator estimator{body, {}};

    explicit Scene(const Eigen::Vector3f& scale, float distance = 2.9F) {
        shapeBody(body, {.scale = scale}, shaped);
        placement.translation = {0.0F, 1.1F, 0.0F};
        draw({0.0F, 0.0F, distance});
        users.count = 1;
        users.users[0] = {.id = 5, .label = 1};
        users.activeId = 5;
    }

    void draw(const Eigen::Vector3f& place) {
        depth.resize(640, 480);
        map.resize(640, 480);
        const Eigen::Quaternionf facing(0, 0, 1, 0);
        skeleton = {};
        skeleton.userId = 5;
        for (std::size_t i = 0; i < kJointCount; ++i) {
            skeleton.joints[i] = {
                .position = facing * shaped.joints[i] + place, .orientation = facing, .confidence = 1.0F};
        }
        std::vector<Eigen::Vector3f> points;
        for (const Eigen::Vector3f& p : shaped.positions) {
            const Eigen::Vector3f sensor = placement.toSensor(facing * p + place);
            const Eigen::Vector2f pixel = project(frame.intrinsics, sensor);
            points.emplace_back(pixel.x(), pixel.y(), sensor.z());
        }
        for (const Triangle& t : body.mesh.triangles)
            fill(points[t.a], points[t.b], points[t.c]);
        frame.depth = depth.view();
        users.map = map.view();
    }

    void fill(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
        const auto edge = [](const Eigen::Vector3f& p, const Eigen::Vector3f& q, float x, float y) {
            return (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x());
        };
        const float area = edge(a, b, c.x(), c.y());
        if (std::abs(area) < 1e-6F) return;
        const int left = std::max(0, static_cast<int>(std::floor(std::min({a.x(), b.x(), c.x()}))));
        const int right = std::min(639, static_cast<int>(std::ceil(std::max({a.x(), b.x(), c.x()}))));
        const int top = std::max(0, static_cast<int>(std::floor(std::min({a.y(), b.y(), c.y()}))));
        const int bottom = std::min(479, static_cast<int>(std::ceil(std::max({a.y(), b.y(), c.y()}))));
        for (int v = top; v <= bottom; ++v) {
            for (int u = left; u <= right; ++u) {
                const auto x = static_cast<float>(u);
                const auto y = static_cast<float>(v);
                const float wa = edge(b, c, x, y) / area;
                const float wb = edge(c, a, x, y) / area;
                if (wa < 0.0F || wb < 0.0F || wa + wb > 1.0F) continue;
                const auto z = static_cast<std::uint16_t>(wa * a.z() + wb * b.z() + (1.0F - wa - wb) * c.z());
                std::uint16_t& pixel = depth.view().at(u, v);
                if (pixel == 0 || z < pixel) pixel = z;
                map.view().at(u, v) = 1;
            }
        }
    }

    void see(int frames) {
        for (int i = 0; i < frames; ++i)
            estimator.update(frame, users, skeleton, placement);
    }
    [[nodiscard]] const Measurement& measured(Dimension dimension) const { return estimator.measurements()[dimension]; }
};

}  // namespace

TEST(BodyEstimator, RecoversTheScaleOfTheMannequinItself) {
    for (const Eigen::Vector3f& scale : {Eigen::Vector3f(1.0F, 1.0F, 1.0F), Eigen::Vector3f(1.15F, 0.95F, 1.05F),
                                         Eigen::Vector3f(0.85F, 1.05F, 0.95F)}) {
        Scene scene(scale);
        scene.see(40);
        const BodyShape& shape = scene.estimator.shape();
        EXPECT_TRUE(shape.converged);
        EXPECT_NEAR(shape.scale.x(), scale.x(), 0.025F);
        EXPECT_NEAR(shape.scale.y(), scale.y(), 0.025F);
        EXPECT_FLOAT_EQ(shape.scale.z(), 0.5F * (shape.scale.x() + shape.scale.y()));
    }
}

TEST(BodyEstimator, MeasuresLengthsInMetres) {
    Scene scene({1.0F, 1.0F, 1.0F});
    scene.see(40);
    // The tube's flat top has a front rim, which a sensor from below sees 20 mm too high; a skull has none.
    EXPECT_NEAR(scene.measured(Dimension::stature).value, 1.77F, 0.012F);
    EXPECT_NEAR(scene.measured(Dimension::shoulderBreadth).value, 0.36F, 0.002F);
    EXPECT_NEAR(scene.measured(Dimension::armLength).value, 0.28F + 0.83F * 0.26F, 0.002F);
    EXPECT_NEAR(scene.measured(Dimension::insideLeg).value, 0.86F, 0.03F);
    for (const Dimension dimension : {Dimension::stature, Dimension::shoulderBreadth, Dimension::insideLeg}) {
        EXPECT_TRUE(scene.measured(dimension).valid);
        EXPECT_GT(scene.measured(dimension).uncertainty, 0.0F);
        EXPECT_LT(scene.measured(dimension).uncertainty, 0.04F);
    }
}

TEST(BodyEstimator, DoesNotClaimWhatItDoesNotMeasure) {
    Scene scene({1.0F, 1.0F, 1.0F});
    scene.see(40);
    for (const Dimension girth :
         {Dimension::chestGirth, Dimension::waistGirth, Dimension::hipGirth, Dimension::neckGirth}) {
        EXPECT_FALSE(scene.measured(girth).valid);
    }
}

TEST(BodyEstimator, LeavesOutHeightsWhenTheFeetAreOutsideThePicture) {
    Scene scene({1.1F, 1.1F, 1.1F});
    // What a sensor at 1.1 m sees from close by: no feet, and the tracker says so.
    scene.placement.translation.y() = 1.45F;
    scene.draw({0.0F, 0.0F, 1.5F});
    for (const Joint joint : {Joint::leftFoot, Joint::rightFoot, Joint::leftKnee, Joint::rightKnee}) {
        scene.skeleton[joint].confidence = 0.2F;
    }
    scene.see(40);
    EXPECT_FALSE(scene.measured(Dimension::stature).valid);
    EXPECT_FALSE(scene.measured(Dimension::insideLeg).valid);
    EXPECT_TRUE(scene.measured(Dimension::shoulderBreadth).valid);
    EXPECT_NEAR(scene.estimator.shape().scale.y(), 1.1F, 0.03F);
    EXPECT_NEAR(scene.estimator.shape().scale.x(), 1.1F, 0.04F);
}

TEST(BodyEstimator, ConvergesAfterTheAskedNumberOfFrames) {
    Scene scene({1.1F, 1.0F, 1.05F});
    scene.see(29);
    EXPECT_FALSE(scene.estimator.measurements().converged);
    EXPECT_FALSE(scene.estimator.shape().converged);
    scene.see(1);
    EXPECT_TRUE(scene.estimator.measurements().converged);
    EXPECT_TRUE(scene.estimator.shape().converged);
    EXPECT_EQ(scene.estimator.measurements().frames, 30);
}

TEST(BodyEstimator, RaisesTheRevisionOnTheFirstEstimateAndOnConvergenceOnly) {
    Scene scene({1.1F, 1.0F, 1.05F});
    EXPECT_EQ(scene.estimator.shape().revision, 0U);
    scene.see(10);
    EXPECT_EQ(scene.estimator.shape().revision, 1U);
    scene.see(300);
    EXPECT_EQ(scene.estimator.shape().revision, 2U);
}

TEST(BodyEstimator, DoesNotThrashWhenJointsTremble) {
    Scene scene({1.1F, 1.0F, 1.05F});
    std::mt19937 random(3);
    std::normal_distribution<float> tremble(0.0F, 0.02F);
    const Skeleton still = scene.skeleton;
    for (int i = 0; i < 300; ++i) {
        for (std::size_t j = 0; j < kJointCount; ++j) {
            scene.skeleton.joints[j].position =
                still.joints[j].position + Eigen::Vector3f(tremble(random), tremble(random), tremble(random));
        }
        scene.see(1);
    }
    EXPECT_LE(scene.estimator.shape().revision, 6U);
    EXPECT_NEAR(scene.estimator.shape().scale.x(), 1.1F, 0.04F);
    EXPECT_NEAR(scene.estimator.shape().scale.y(), 1.0F, 0.03F);
}

TEST(BodyEstimator, IsNotMovedByASingleWildFrame) {
    Scene scene({1.0F, 1.0F, 1.0F});
    scene.see(40);
    const Eigen::Vector3f before = scene.estimator.shape().scale;
    const Skeleton sound = scene.skeleton;
    scene.skeleton[Joint::leftShoulder].position.x() -= 0.15F;
    scene.see(3);
    scene.skeleton = sound;
    scene.see(20);
    EXPECT_EQ(scene.estimator.shape().scale, before);
}

TEST(BodyEstimator, IgnoresAShopperWhoTurnsAway) {
    Scene scene({1.0F, 1.0F, 1.0F});
    for (JointState& joint : scene.skeleton.joints) {
        const Eigen::Vector3f about(0.0F, 0.0F, 2.9F);
        joint.position = Eigen::AngleAxisf(1.2F, Eigen::Vector3f::UnitY()) * (joint.position - about) + about;
    }
    scene.see(40);
    EXPECT_EQ(scene.estimator.measurements().frames, 0);
    EXPECT_EQ(scene.estimator.shape().revision, 0U);
}

TEST(BodyEstimator, StartsAnewForAnotherShopperAndAfterARestart) {
    Scene scene({1.2F, 1.1F, 1.15F});
    scene.see(40);
    ASSERT_TRUE(scene.estimator.shape().converged);
    const std::uint32_t revision = scene.estimator.shape().revision;
    scene.users.users[0].id = scene.users.activeId = scene.skeleton.userId = 6;
    scene.see(1);
    EXPECT_FALSE(scene.estimator.measurements().converged);
    EXPECT_EQ(scene.estimator.shape().scale, Eigen::Vector3f::Ones());
    EXPECT_EQ(scene.estimator.shape().revision, revision + 1);
    scene.see(40);
    ASSERT_TRUE(scene.estimator.shape().converged);
    scene.frame.restart = true;
    scene.see(1);
    EXPECT_FALSE(scene.estimator.shape().converged);
}

TEST(BodyEstimator, CallsTheShapeMeasuredAnewForEachShopper) {
    Scene scene({1.2F, 1.1F, 1.15F});
    EXPECT_FALSE(scene.estimator.shape().measured);
    scene.see(1);
    EXPECT_FALSE(scene.estimator.shape().measured);
    scene.see(39);
    EXPECT_TRUE(scene.estimator.shape().measured);
    scene.users.users[0].id = scene.users.activeId = scene.skeleton.userId = 6;
    scene.see(1);
    EXPECT_GT(scene.estimator.shape().revision, 0U);
    EXPECT_FALSE(scene.estimator.shape().measured) << "the first shopper's measurement is not the second's";
    scene.see(39);
    EXPECT_TRUE(scene.estimator.shape().measured);
    scene.estimator.reset();
    EXPECT_FALSE(scene.estimator.shape().measured);
}

TEST(BodyEstimator, StaysWithinHumanProportions) {
    Scene scene({1.0F, 1.0F, 1.0F});
    for (const Joint joint : {Joint::leftShoulder, Joint::rightShoulder, Joint::leftHip, Joint::rightHip}) {
        scene.skeleton[joint].position.x() *= 1.9F;
    }
    scene.see(40);
    const Eigen::Vector3f& scale = scene.estimator.shape().scale;
    EXPECT_LE(scale.x(), 1.4F * scale.y() + 1e-4F);
    EXPECT_LE(scale.maxCoeff(), 1.5F);
}

TEST(BodyEstimator, SurvivesJointsThatAreNotFinite) {
    for (std::size_t i = 0; i < kJointCount; ++i) {
        Scene scene({1.0F, 1.0F, 1.0F});
        scene.skeleton.joints[i].position.setConstant(std::nanf(""));
        scene.see(35);
        EXPECT_TRUE(scene.estimator.shape().scale.allFinite()) << kJointNames[i];
        for (const Measurement& measurement : scene.estimator.measurements().dimensions) {
            EXPECT_TRUE(!measurement.valid || std::isfinite(measurement.value)) << kJointNames[i];
        }
    }
}

TEST(BodyEstimator, TakesNoMemoryAfterItsConstruction) {
    Scene scene({1.1F, 1.0F, 1.05F});
    const test::AllocationCounter counter;
    scene.see(40);
    scene.estimator.reset();
    scene.see(5);
    EXPECT_EQ(counter.count(), 0U);
}

TEST(BodyEstimator, SaysWhyNoSizeShouldBeTold) {
    Scene scene(Eigen::Vector3f::Ones());
    scene.see(3);
    EXPECT_EQ(scene.estimator.measurements().doubt, MeasurementDoubt::measuring);
    scene.see(60);
    EXPECT_EQ(scene.estimator.measurements().doubt, MeasurementDoubt::none);

    // Somebody else within an arm's length.
    scene.users.users[0].lower = {-0.3F, 0.0F, 2.7F};
    scene.users.users[0].upper = {0.3F, 1.8F, 3.1F};
    scene.users.users[1] = {.id = 6, .lower = {0.35F, 0.0F, 2.7F}, .upper = {0.9F, 1.8F, 3.1F}, .label = 2};
    scene.users.count = 2;
    scene.see(1);
    EXPECT_EQ(scene.estimator.measurements().doubt, MeasurementDoubt::crowded);
    scene.users.users[1].lower.x() = 0.6F;
    scene.see(1);
    EXPECT_EQ(scene.estimator.measurements().doubt, MeasurementDoubt::none);

    // Knees as high as hips.
    for (const auto& [hip, knee] :
         {std::pair(Joint::leftHip, Joint::leftKnee), std::pair(Joint::rightHip, Joint::rightKnee)})
        scene.skeleton[knee].position.y() = scene.skeleton[hip].position.y();
    scene.see(1);
    EXPECT_EQ(scene.estimator.measurements().doubt, MeasurementDoubt::seated);
}

TEST(BodyEstimator, TellsChildrenNoSize) {
    Scene scene(Eigen::Vector3f::Constant(0.72F), 2.5F);
    scene.see(60);
    ASSERT_TRUE(scene.measured(Dimension::stature).valid);
    ASSERT_LT(scene.measured(Dimension::stature).value, 1.4F);
    EXPECT_EQ(scene.estimator.measurements().doubt, MeasurementDoubt::child);
}

TEST(BodyEstimator, TellsNoSizeOfHalfAPerson) {
    Scene scene(Eigen::Vector3f::Ones());
    // The feet are below the picture, so nothing is known of heights above the floor.
    for (const Joint foot : {Joint::leftFoot, Joint::rightFoot})
        scene.skeleton[foot].confidence = 0.0F;
    scene.see(60);
    EXPECT_EQ(scene.estimator.measurements().doubt, MeasurementDoubt::partlySeen);
}

TEST(SampleWindow, AveragesWhatIsNotAstray) {
    SampleWindow window;
    EXPECT_EQ(window.average().count, 0U);
    for (int i = 0; i < 20; ++i)
        window.add(i % 2 == 0 ? 1.0F : 1.1F);
    window.add(9.0F);
    const SampleWindow::Average average = window.average();
    EXPECT_NEAR(average.value, 1.05F, 1e-5F);
    EXPECT_EQ(average.count, 20U);
    EXPECT_NEAR(average.standardError, 0.0513F / std::sqrt(20.0F), 1e-3F);
}

TEST(SampleWindow, ForgetsTheOldest) {
    SampleWindow window;
    for (std::size_t i = 0; i < SampleWindow::kCapacity; ++i)
        window.add(1.0F);
    for (std::size_t i = 0; i < SampleWindow::kCapacity; ++i)
        window.add(2.0F);
    EXPECT_FLOAT_EQ(window.average().value, 2.0F);
    EXPECT_EQ(window.count(), SampleWindow::kCapacity);
}

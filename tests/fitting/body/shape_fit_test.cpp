#include "fitting/body/shape_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "fitting/body/body_measures.h"
#include "tests/support/allocation_counter.h"

using namespace cheval;
using namespace cheval::fitting;

namespace {

const Body& body() {
    static const Body kBody = [] {
        auto loaded = loadBody(std::string(CHEVAL_ASSETS) + "/body.glb");
        return loaded ? std::move(*loaded) : Body{};
    }();
    return kBody;
}

// An exact depth picture of a shaped body before a level sensor, with exact joints.
struct Scene {
    ShapedBody shaped;
    hal::Image<std::uint16_t> depth{640, 480};
    hal::Image<std::uint8_t> map{640, 480};
    SensorPlacement placement;
    Skeleton skeleton;
    hal::DepthFrame frame;

    explicit Scene(const ShapeParameters& parameters) {
        shapeBody(body(), {.parameters = parameters, .fitted = 1.0F}, shaped);
        placement.translation = {0.0F, 1.1F, 0.0F};
    }
    void draw(float yaw, const Eigen::Vector3f& place) {
        depth.resize(640, 480);
        map.resize(640, 480);
        std::fill(depth.pixels.begin(), depth.pixels.end(), std::uint16_t{0});
        std::fill(map.pixels.begin(), map.pixels.end(), std::uint8_t{0});
        const Eigen::Quaternionf facing(Eigen::AngleAxisf(3.14159265F + yaw, Eigen::Vector3f::UnitY()));
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
        for (const Triangle& t : body().mesh.triangles)
            fill(points[t.a], points[t.b], points[t.c]);
        frame.depth = std::as_const(depth).view();
    }
    void fill(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
        const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
        if (std::abs(area) < 1e-6F) return;
        const int top = std::max(0, static_cast<int>(std::ceil(std::min({a.y(), b.y(), c.y()}))));
        const int bottom = std::min(479, static_cast<int>(std::floor(std::max({a.y(), b.y(), c.y()}))));
        const int left = std::max(0, static_cast<int>(std::ceil(std::min({a.x(), b.x(), c.x()}))));
        const int right = std::min(639, static_cast<int>(std::floor(std::max({a.x(), b.x(), c.x()}))));
        for (int v = top; v <= bottom; ++v) {
            for (int u = left; u <= right; ++u) {
                const Eigen::Vector2f p(static_cast<float>(u), static_cast<float>(v));
                const float wb = ((p.x() - a.x()) * (c.y() - a.y()) - (p.y() - a.y()) * (c.x() - a.x())) / area;
                const float wc = ((b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x())) / area;
                if (wb < 0.0F || wc < 0.0F || wb + wc > 1.0F) continue;
                const auto z =
                    static_cast<std::uint16_t>(std::lround(a.z() + wb * (b.z() - a.z()) + wc * (c.z() - a.z())));
                std::uint16_t& pixel = depth.view().at(u, v);
                if (pixel != 0 && pixel <= z) continue;
                pixel = z;
                map.view().at(u, v) = 1;
            }
        }
    }
    [[nodiscard]] TrunkView view() const {
        return {.frame = &frame,
                .map = map.view(),
                .label = 1,
                .skeleton = &skeleton,
                .placement = &placement,
                .stands = true};
    }
};

ShapeParameters drawBody(std::mt19937& random, float deviations) {
    std::normal_distribution<float> normal;
    ShapeParameters unit;
    for (Eigen::Index k = 0; k < unit.size(); ++k)
        unit[k] = std::clamp(normal(random), -2.0F, 2.0F) * deviations;
    const Eigen::MatrixXf root = body().shapes.covariance.llt().matrixL();
    return body().shapes.mean + root * unit;
}

}  // namespace

// A visit: faces the sensor, turns to both sides and once round. The readings of stature are those of a tape.
void see(Scene& scene, ShapeFit& fit, const ShapeParameters& truth, std::initializer_list<float> yaws) {
    for (const float yaw : yaws) {
        for (int frame = 0; frame < 4; ++frame) {
            scene.draw(yaw, {0.0F, 0.012F, 2.5F});
            EXPECT_TRUE(fit.add(scene.view())) << "yaw " << yaw;
            const ParameterReading stature{ShapeParameter::stature, truth[0], 0.005F};
            fit.solve(std::span(&stature, 1));
        }
    }
}

TEST(ShapeFit, RecoversTheModelsOwnBodiesFromAllSides) {
    std::mt19937 random(7);
    for (int person = 0; person < 6; ++person) {
        const ShapeParameters truth = drawBody(random, 0.8F);
        Scene scene(truth);
        ShapeFit fit(body());
        see(scene, fit, truth, {0.0F, 0.8F, 1.57F, 0.0F, -0.8F, -1.57F, 3.14F});
        for (const ShapeParameter girth :
             {ShapeParameter::chestGirth, ShapeParameter::waistGirth, ShapeParameter::hipGirth}) {
            const auto i = static_cast<Eigen::Index>(index(girth));
            EXPECT_NEAR(fit.estimate().parameters[i], truth[i], 0.045F) << "person " << person << ", girth " << i;
        }
        EXPECT_LT(fit.misfit().outline, 0.015F);
        EXPECT_GT(fit.misfit().outlinePoints, 20);
    }
}

TEST(ShapeFit, KnowsMoreAfterTheSidesThanFromTheFront) {
    std::mt19937 random(3);
    const ShapeParameters truth = drawBody(random, 0.8F);
    Scene scene(truth);
    ShapeFit fit(body());
    const auto waistDepth = static_cast<Eigen::Index>(index(ShapeParameter::waistDepth));
    const float before = fit.estimate().uncertainty[waistDepth];
    see(scene, fit, truth, {0.0F});
    const float front = fit.estimate().uncertainty[waistDepth];
    see(scene, fit, truth, {1.57F, -1.57F});
    const float sides = fit.estimate().uncertainty[waistDepth];
    EXPECT_LT(front, before);
    EXPECT_LT(sides, 0.8F * front);
    EXPECT_NEAR(fit.estimate().parameters[waistDepth], truth[waistDepth], 0.02F);
}

TEST(ShapeFit, IsNeverSurerOfAGirthThanOfTheClothesOverIt) {
    std::mt19937 random(5);
    const ShapeParameters truth = drawBody(random, 0.5F);
    Scene scene(truth);
    ShapeFit fit(body());
    see(scene, fit, truth, {0.0F, 1.57F, 0.0F, -1.57F, 0.0F});
    const auto waist = static_cast<Eigen::Index>(index(ShapeParameter::waistGirth));
    EXPECT_GT(fit.estimate().uncertainty[waist], 4.0F * fit.estimate().clothesUncertainty);
}

TEST(ShapeFit, MirroredShoppersMeasureTheSame) {
    std::mt19937 random(11);
    const ShapeParameters truth = drawBody(random, 0.8F);
    std::array<ShapeParameters, 2> found;
    for (const int side : {0, 1}) {
        Scene scene(truth);
        ShapeFit fit(body());
        const float sign = side == 0 ? 1.0F : -1.0F;
        see(scene, fit, truth, {0.0F, 0.8F * sign, 1.57F * sign});
        found[static_cast<std::size_t>(side)] = fit.estimate().parameters;
    }
    for (Eigen::Index k = 0; k < truth.size(); ++k) {
        if (k == static_cast<Eigen::Index>(index(ShapeParameter::masculine))) continue;  // Has no unit.
        EXPECT_NEAR(found[0][k], found[1][k], 0.012F) << kShapeParameterNames[static_cast<std::size_t>(k)];
    }
}

TEST(ShapeFit, StartsFromWhatBodiesAreLikeAndReturnsThereWhenReset) {
    std::mt19937 random(13);
    const ShapeParameters truth = drawBody(random, 1.0F);
    Scene scene(truth);
    ShapeFit fit(body());
    EXPECT_TRUE(fit.estimate().parameters.isApprox(body().shapes.mean));
    see(scene, fit, truth, {0.0F});
    EXPECT_FALSE(fit.estimate().parameters.isApprox(body().shapes.mean, 1e-3F));
    fit.reset();
    EXPECT_TRUE(fit.estimate().parameters.isApprox(body().shapes.mean));
    fit.solve({});
    EXPECT_TRUE(fit.estimate().parameters.isApprox(body().shapes.mean, 1e-3F));
}

TEST(ShapeFit, LearnsNothingWithoutATrunkInView) {
    Scene scene(body().shapes.mean);
    ShapeFit fit(body());
    scene.draw(0.0F, {0.0F, 0.012F, 2.5F});
    Scene hidden = scene;
    std::fill(hidden.map.pixels.begin(), hidden.map.pixels.end(), std::uint8_t{0});
    hidden.frame.depth = std::as_const(hidden.depth).view();
    EXPECT_FALSE(fit.add(hidden.view()));
    Scene lost = scene;
    lost.frame.depth = std::as_const(lost.depth).view();
    lost.skeleton[Joint::torso].confidence = 0.2F;
    EXPECT_FALSE(fit.add(lost.view()));
    Scene broken = scene;
    broken.frame.depth = std::as_const(broken.depth).view();
    broken.skeleton[Joint::neck].position.setConstant(std::numeric_limits<float>::quiet_NaN());
    EXPECT_FALSE(fit.add(broken.view()));
    Scene aside = scene;
    aside.frame.depth = std::as_const(aside.depth).view();
    aside.skeleton[Joint::torso].position.x() += 3.0F;
    EXPECT_FALSE(fit.add(aside.view()));
    const ParameterReading nonsense{ShapeParameter::stature, std::numeric_limits<float>::quiet_NaN(), 0.01F};
    fit.solve(std::span(&nonsense, 1));
    EXPECT_TRUE(fit.estimate().parameters.allFinite());
}

TEST(ShapeFit, TakesNoMemoryAfterItsConstruction) {
    Scene scene(body().shapes.mean);
    ShapeFit fit(body());
    scene.draw(0.3F, {0.0F, 0.012F, 2.5F});
    const ParameterReading stature{ShapeParameter::stature, body().shapes.mean[0], 0.01F};
    const test::AllocationCounter counter;
    fit.add(scene.view());
    fit.solve(std::span(&stature, 1));
    EXPECT_EQ(counter.count(), 0U);
}

TEST(BodyShapes, EachParameterChangesItsOwnDimensionAlone) {
    const BodyMeasures measures(body());
    const MeasuredParameters mannequin = measures.measure(body().mesh.positions, body().joints);
    ShapedBody shaped;
    for (std::size_t k = 0; k < kShapeParameterCount; ++k) {
        BodyShape shape{.fitted = 1.0F};
        shape.parameters[static_cast<Eigen::Index>(k)] = 0.01F;
        shapeBody(body(), shape, shaped);
        const MeasuredParameters changed = measures.measure(shaped.positions, shaped.joints) - mannequin;
        for (Eigen::Index i = 0; i < changed.size(); ++i) {
            const float expected = static_cast<std::size_t>(i) == k ? 0.01F : 0.0F;
            EXPECT_NEAR(changed[i], expected, 0.005F)
                << kShapeParameterNames[k] << " on " << kShapeParameterNames[static_cast<std::size_t>(i)];
        }
    }
}

TEST(BodyShapes, AreLinearAndKeepTheBodyMirrorSymmetric) {
    ShapedBody once;
    ShapedBody twice;
    std::mt19937 random(2);
    BodyShape shape{.parameters = drawBody(random, 1.0F), .fitted = 1.0F};
    shapeBody(body(), shape, once);
    shape.parameters *= 2.0F;
    shapeBody(body(), shape, twice);
    for (std::size_t i = 0; i < once.positions.size(); i += 97) {
        const Eigen::Vector3f step = once.positions[i] - body().mesh.positions[i];
        EXPECT_LT((twice.positions[i] - body().mesh.positions[i] - 2.0F * step).norm(), 1e-4F);
    }
    const CageTemplate& cage = body().cageTemplate;
    for (std::size_t i = 0; i < cage.vertexCount(); ++i) {
        const Eigen::Vector3f& a = once.outerCage[i];
        const Eigen::Vector3f& b = once.outerCage[cage.mirrored[i]];
        EXPECT_LT((a - b.cwiseProduct(Eigen::Vector3f(-1, 1, 1))).norm(), 1e-4F);
    }
    for (std::size_t i = 0; i < cage.vertexCount(); ++i)
        EXPECT_LT((once.outerCage[i] - once.outerCage[cage.weld[i]]).norm(), 1e-5F);
}

TEST(BodyShapes, ChangeFromTheScaledMannequinWithoutAJump) {
    std::mt19937 random(4);
    BodyShape shape{.scale = {1.1F, 0.95F, 1.02F}, .parameters = drawBody(random, 1.0F)};
    ShapedBody before;
    ShapedBody after;
    shapeBody(body(), shape, before);
    shape.fitted = 1e-4F;
    shapeBody(body(), shape, after);
    for (std::size_t i = 0; i < before.outerCage.size(); ++i)
        EXPECT_LT((before.outerCage[i] - after.outerCage[i]).norm(), 1e-3F);
}

TEST(TapeLength, IsThePerimeterOfTheConvexHull) {
    std::vector<Eigen::Vector2f> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5F, 0.5F}, {0.5F, 0.9F}};
    std::vector<Eigen::Vector2f> hull;
    EXPECT_NEAR(tapeLength(square, hull), 4.0F, 1e-5F);
    std::vector<Eigen::Vector2f> circle;
    for (int i = 0; i < 360; ++i) {
        const float angle = static_cast<float>(i) * 3.14159265F / 180.0F;
        circle.emplace_back(0.2F * std::cos(angle), 0.2F * std::sin(angle));
    }
    EXPECT_NEAR(tapeLength(circle, hull), 2.0F * 3.14159265F * 0.2F, 1e-3F);
    std::vector<Eigen::Vector2f> line = {{0, 0}, {1, 0}};
    EXPECT_NEAR(tapeLength(line, hull), 2.0F, 1e-5F);
    std::vector<Eigen::Vector2f> nothing;
    EXPECT_EQ(tapeLength(nothing, hull), 0.0F);
}

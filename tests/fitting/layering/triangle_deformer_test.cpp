#include "fitting/layering/triangle_deformer.h"

#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/support/made_body.h"

using namespace cheval::fitting;

namespace {

struct Deformer {
    Body body = cheval::test::makeBody();
    Garment garment = cheval::test::makeGarment(body);
    std::vector<CageVertexSum> sums{body.outerCage.size()};
    std::vector<Eigen::Vector3f> newOuter{body.outerCage.size()};
    std::vector<Eigen::Matrix3f> transforms{body.outerCage.size()};

    TriangleDeformerJob job(const std::vector<Eigen::Vector3f>& below) {
        return {.triangles = body.cageTemplate.triangles,
                .weld = body.cageTemplate.weld,
                .covered = garment.covered,
                .below = below,
                .inner = garment.innerCage,
                .outer = garment.outerCage,
                .sums = sums,
                .newOuter = newOuter,
                .vertexTransforms = transforms};
    }
};

std::vector<Eigen::Vector3f> moved(std::vector<Eigen::Vector3f> points, const Eigen::Affine3f& motion) {
    for (Eigen::Vector3f& point : points)
        point = motion * point;
    return points;
}

}  // namespace

TEST(TriangleDeformer, RefusesSpansOfDifferentLengths) {
    Deformer d;
    auto job = d.job(d.body.outerCage);
    EXPECT_TRUE(job.isValid());
    job.below = job.below.first(job.below.size() - 1);
    EXPECT_FALSE(job.isValid());
    EXPECT_FALSE(job.run());
}

TEST(TriangleDeformer, RefusesATriangleOutsideTheTemplate) {
    Deformer d;
    d.body.cageTemplate.triangles[3].b = static_cast<std::uint32_t>(d.body.outerCage.size());
    EXPECT_FALSE(d.job(d.body.outerCage).isValid());
}

TEST(TriangleDeformer, RefusesAWeldThatIsNotItsOwnTarget) {
    Deformer d;
    d.body.cageTemplate.weld[8] = 3;
    d.body.cageTemplate.weld[3] = 2;
    EXPECT_FALSE(d.job(d.body.outerCage).isValid());
}

TEST(TriangleDeformer, ReturnsTheGarmentOnItsOwnBody) {
    Deformer d;
    ASSERT_TRUE(d.job(d.body.outerCage).run());
    for (std::size_t i = 0; i < d.newOuter.size(); ++i) {
        const Eigen::Vector3f& expected = d.garment.covered[i] != 0 ? d.garment.outerCage[i] : d.body.outerCage[i];
        EXPECT_LE((d.newOuter[i] - expected).norm(), 1e-6F) << i;
    }
}

TEST(TriangleDeformer, FollowsRigidMotion) {
    Deformer d;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> number(-1.0F, 1.0F);
    for (int round = 0; round < 20; ++round) {
        Eigen::Affine3f motion = Eigen::Affine3f::Identity();
        motion.translate(Eigen::Vector3f(number(random), number(random), number(random)));
        motion.rotate(Eigen::Quaternionf(number(random), number(random), number(random), number(random)).normalized());
        const auto below = moved(d.body.outerCage, motion);
        ASSERT_TRUE(d.job(below).run());
        for (std::size_t i = 0; i < d.newOuter.size(); ++i) {
            if (d.garment.covered[i] == 0) continue;
            EXPECT_LE((d.newOuter[i] - motion * d.garment.outerCage[i]).norm(), 1e-4F);
            EXPECT_LE((d.transforms[i] - motion.linear()).norm(), 1e-4F);
        }
    }
}

TEST(TriangleDeformer, KeepsTheThicknessUnderUniformScale) {
    Deformer d;
    for (const float scale : {0.6F, 0.9F, 1.1F, 1.7F}) {
        const auto below = moved(d.body.outerCage, Eigen::Affine3f(Eigen::Scaling(scale)));
        ASSERT_TRUE(d.job(below).run());
        for (std::size_t i = 0; i < d.newOuter.size(); ++i) {
            if (d.garment.covered[i] == 0) continue;
            const float thickness = (d.garment.outerCage[i] - d.garment.innerCage[i]).norm();
            EXPECT_NEAR((d.newOuter[i] - below[i]).norm(), thickness, 0.01F * thickness);
        }
    }
}

TEST(TriangleDeformer, LeavesNoGapInSeamsHoweverTheBodyIsBent) {
    Deformer d;
    auto below = d.body.outerCage;
    for (Eigen::Vector3f& p : below) {
        p = {p.x() * (1.0F + 0.3F * p.y()), p.y() + 0.1F * std::sin(9.0F * p.x()), p.z() + 0.2F * p.x() * p.y()};
    }
    ASSERT_TRUE(d.job(below).run());
    for (std::size_t i = 0; i < below.size(); ++i)
        EXPECT_EQ(d.newOuter[i], d.newOuter[d.body.cageTemplate.weld[i]]);
}

TEST(TriangleDeformer, PassesTheCageThroughWhereNothingIsCovered) {
    Deformer d;
    const auto below = moved(d.body.outerCage, Eigen::Affine3f(Eigen::Translation3f(0.1F, 0.2F, 0.3F)));
    ASSERT_TRUE(d.job(below).run());
    std::size_t uncovered = 0;
    for (std::size_t i = 0; i < below.size(); ++i) {
        if (d.garment.covered[i] != 0) continue;
        ++uncovered;
        EXPECT_EQ(d.newOuter[i], below[i]);
    }
    EXPECT_GT(uncovered, 50U);
}

TEST(TriangleDeformer, StaysFiniteOnCollapsedTriangles) {
    Deformer d;
    auto below = d.body.outerCage;
    for (Eigen::Vector3f& p : below)
        p.z() = 0.0F;  // Flat …
    for (std::size_t i = 0; i < below.size(); i += 3)
        below[i] = below[0];  // … and partly without any area.
    ASSERT_TRUE(d.job(below).run());
    for (std::size_t i = 0; i < below.size(); ++i) {
        EXPECT_TRUE(d.newOuter[i].allFinite());
        if (d.garment.covered[i] == 0) continue;
        EXPECT_LE((d.newOuter[i] - below[d.body.cageTemplate.weld[i]]).norm(), 0.1F);
    }
}

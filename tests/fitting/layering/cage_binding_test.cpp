#include "fitting/layering/cage_binding.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace cheval::fitting {
namespace {

/// A tube of two layers, 30 cm and 34 cm wide, about the y axis.
struct Tube {
    static constexpr std::uint32_t kAround = 24, kRows = 12;
    std::vector<Eigen::Vector3f> inner, outer;
    std::vector<Triangle> triangles;
    std::vector<std::uint8_t> covered;

    Tube() {
        for (std::uint32_t row = 0; row <= kRows; ++row) {
            for (std::uint32_t k = 0; k < kAround; ++k) {
                const float angle = 6.2831853F * static_cast<float>(k) / static_cast<float>(kAround);
                const Eigen::Vector3f out(std::sin(angle), 0.0F, std::cos(angle));
                const Eigen::Vector3f height(0.0F, 0.05F * static_cast<float>(row), 0.0F);
                inner.emplace_back(height + 0.15F * out);
                outer.emplace_back(height + 0.17F * out);
                covered.push_back(row >= 2 ? 1 : 0);
            }
        }
        for (std::uint32_t row = 0; row < kRows; ++row) {
            for (std::uint32_t k = 0; k < kAround; ++k) {
                const std::uint32_t a = row * kAround + k;
                const std::uint32_t b = row * kAround + (k + 1) % kAround;
                triangles.push_back({a, b, b + kAround});
                triangles.push_back({a, b + kAround, a + kAround});
            }
        }
    }
    [[nodiscard]] CagePair cages() const { return {.triangles = triangles, .inner = inner, .outer = outer}; }
    [[nodiscard]] Eigen::Vector3f corner(std::uint32_t i) const { return 0.5F * (inner[i] + outer[i]); }
};

/// Metres from a point to the nearest covered triangle; with a normal, to the nearest that looks its way.
float nearestOf(const Tube& tube, const Eigen::Vector3f& point, const Eigen::Vector3f* normal) {
    float nearest = 1e9F;
    for (const Triangle& t : tube.triangles) {
        if (tube.covered[t.a] == 0 || tube.covered[t.b] == 0 || tube.covered[t.c] == 0) continue;
        const Eigen::Vector3f a = tube.corner(t.a);
        const Eigen::Vector3f b = tube.corner(t.b);
        const Eigen::Vector3f c = tube.corner(t.c);
        if (normal != nullptr && (b - a).cross(c - a).normalized().dot(*normal) <= 0.0F) continue;
        const Eigen::Vector3f w = nearestBarycentric(point, a, b, c);
        nearest = std::min(nearest, (w[0] * a + w[1] * b + w[2] * c - point).norm());
    }
    return nearest;
}

TEST(CageBinding, IsToTheNearestCoveredTriangleThatLooksTheVertexsWay) {
    const Tube tube;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> place(-0.25F, 0.25F);
    std::vector<Eigen::Vector3f> points;
    std::vector<Eigen::Vector3f> normals;
    for (int i = 0; i < 400; ++i) {
        points.emplace_back(place(random), 0.3F + 1.6F * place(random), place(random));
        normals.emplace_back(Eigen::Vector3f(place(random), place(random), place(random)).normalized());
    }
    const std::vector<CageBinding> bindings = bindToCages(tube.cages(), tube.covered, points, normals);
    ASSERT_EQ(bindings.size(), points.size());
    int linings = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Triangle& t = tube.triangles[bindings[i].triangle];
        EXPECT_EQ(tube.covered[t.a] & tube.covered[t.b] & tube.covered[t.c], 1);
        const Eigen::Vector3f& w = bindings[i].barycentric;
        const float away =
            (w[0] * tube.corner(t.a) + w[1] * tube.corner(t.b) + w[2] * tube.corner(t.c) - points[i]).norm();
        const float any = nearestOf(tube, points[i], nullptr);
        const float facing = nearestOf(tube, points[i], &normals[i]);
        // What looks the way of a vertex on the far side of the tube is not what a lining hangs on.
        const bool lining = facing > any + 0.04F;
        if (lining) ++linings;
        EXPECT_NEAR(away, lining ? any : facing, 1e-5F) << i;
    }
    EXPECT_GT(linings, 20);
    EXPECT_LT(linings, 380);
}

TEST(CageBinding, OfABodyOfItsOwnReturnsEveryVertex) {
    const Tube tube;
    const std::vector<Eigen::Vector3f> points = {{0.1F, 0.3F, 0.12F}, {-0.2F, 0.5F, 0.0F}, {0.0F, 0.0F, 0.16F}};
    const std::vector<Eigen::Vector3f> normals(points.size(), Eigen::Vector3f::UnitZ());
    const std::vector<CageBinding> bindings = bindToCages(tube.cages(), tube.covered, points, normals);
    const std::vector<Eigen::Matrix3f> still(tube.inner.size(), Eigen::Matrix3f::Identity());
    std::vector<Eigen::Vector3f> positions(points.size());
    evaluateBindings(tube.cages(), still, bindings, positions);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LT((positions[i] - points[i]).norm(), 1e-6F);
    }
}

TEST(CageBinding, IsEmptyWhereNothingIsCovered) {
    Tube tube;
    tube.covered.assign(tube.covered.size(), 0);
    const std::vector<Eigen::Vector3f> one = {Eigen::Vector3f::UnitX()};
    EXPECT_TRUE(bindToCages(tube.cages(), tube.covered, one, one).empty());
}

}  // namespace
}  // namespace cheval::fitting

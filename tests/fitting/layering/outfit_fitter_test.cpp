#include "fitting/layering/outfit_fitter.h"

#include <gtest/gtest.h>

#include "fitting/layering/cage_binding.h"
#include "fitting/layering/smooth_normals.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/made_body.h"

using namespace cheval::fitting;

namespace {

struct Fitting {
    Body body = cheval::test::makeBody();
    std::vector<Garment> wardrobe = {cheval::test::makeGarment(body), cheval::test::makeGarment(body, {.legs = true}),
                                     cheval::test::makeGarment(body, {.gap = 0.006F, .thickness = 0.03F}),
                                     cheval::test::makeGarment(body, {.gap = 0.002F, .thickness = 0.01F})};
    ShapedBody shaped;
    OutfitFitter fitter{body, wardrobe};

    explicit Fitting(const Eigen::Vector3f& scale = Eigen::Vector3f::Ones()) { shape(scale); }
    void shape(const Eigen::Vector3f& scale) { shapeBody(body, {.scale = scale}, shaped); }
};

Outfit wear(std::initializer_list<std::uint16_t> garments) {
    Outfit outfit;
    for (const std::uint16_t garment : garments)
        outfit.garments[outfit.count++] = garment;
    return outfit;
}

}  // namespace

TEST(OutfitFitter, ReturnsAGarmentOnItsOwnBodyToAMicrometre) {
    Fitting f;
    for (std::uint16_t which = 0; which < f.wardrobe.size(); ++which) {
        const FittedOutfit& fitted = f.fitter.fit(f.shaped, wear({which}));
        ASSERT_EQ(fitted.count, 1U);
        const FittedGarment& layer = fitted.layers[0];
        EXPECT_EQ(layer.garment, &f.wardrobe[which]);
        EXPECT_EQ(layer.material, which + 1U);
        for (std::size_t v = 0; v < layer.positions.size(); ++v) {
            ASSERT_LE((layer.positions[v] - f.wardrobe[which].mesh.positions[v]).norm(), 1e-6F);
            ASSERT_LE((layer.normals[v] - f.wardrobe[which].mesh.normals[v]).norm(), 1e-3F);
        }
    }
}

TEST(OutfitFitter, FollowsTheBodysScaleAndKeepsTheClothsDistance) {
    Fitting f({1.2F, 0.9F, 1.05F});
    const FittedOutfit& fitted = f.fitter.fit(f.shaped, wear({0}));
    const std::vector<Eigen::Vector3f>& cloth = fitted.layers[0].positions;
    const std::vector<Eigen::Vector3f>& rest = f.wardrobe[0].mesh.positions;
    for (std::size_t v = 0; v < cloth.size(); ++v) {
        const Eigen::Vector3f scaled = rest[v].cwiseProduct(Eigen::Vector3f(1.2F, 0.9F, 1.05F));
        // What differs from plain scaling is the thickness and the residual, a few millimetres.
        EXPECT_LE((cloth[v] - scaled).norm(), 0.008F);
    }
}

TEST(OutfitFitter, LeavesSeamsOfTheClothClosed) {
    Fitting f({1.3F, 0.8F, 1.05F});
    const FittedOutfit& fitted = f.fitter.fit(f.shaped, wear({0, 2}));
    for (std::size_t layer = 0; layer < fitted.count; ++layer) {
        const auto weld = weldByPosition(fitted.layers[layer].garment->mesh.positions);
        std::size_t pairs = 0;
        for (std::size_t v = 0; v < weld.size(); ++v) {
            if (weld[v] == v) continue;
            ++pairs;
            EXPECT_EQ(fitted.layers[layer].positions[v], fitted.layers[layer].positions[weld[v]]);
        }
        EXPECT_GT(pairs, 10U);
    }
}

// Where the tubes of sleeve and trunk run into each other there is no outside to be on.
static bool tubesMeet(const Eigen::Vector3f& rest) {
    return rest.y() > 1.25F && std::abs(rest.x()) < 0.27F;
}

TEST(OutfitFitter, PutsEachLayerOutsideTheOneBelow) {
    Fitting f({1.1F, 1.0F, 1.05F});
    const FittedOutfit& fitted = f.fitter.fit(f.shaped, wear({0, 2, 3}));
    ASSERT_EQ(fitted.count, 3U);
    // All three cloths come from one sweep: vertex v is at the same place of the body in each.
    for (std::size_t v = 0; v < fitted.layers[0].positions.size(); ++v) {
        const Eigen::Vector3f& inner = fitted.layers[0].positions[v];
        const Eigen::Vector3f& middle = fitted.layers[1].positions[v];
        const Eigen::Vector3f& outer = fitted.layers[2].positions[v];
        const Eigen::Vector3f& out = f.wardrobe[0].mesh.normals[v];
        if (tubesMeet(f.wardrobe[0].mesh.positions[v])) continue;
        EXPECT_GT((middle - inner).dot(out), 0.01F) << v;
        EXPECT_GT((outer - middle).dot(out), 0.01F) << v;
    }
}

TEST(OutfitFitter, PutsOneGarmentOnTheOuterCageOfAnother) {
    Fitting f;
    const FittedOutfit& fitted = f.fitter.fit(f.shaped, wear({0, 3}));
    // The top of layer one is 20 mm over the body's cage, the cloth of layer two 2 mm over that.
    for (std::size_t v = 0; v < fitted.layers[1].positions.size(); ++v) {
        if (tubesMeet(f.wardrobe[3].mesh.positions[v])) continue;
        const float lifted =
            (fitted.layers[1].positions[v] - f.wardrobe[3].mesh.positions[v]).dot(f.wardrobe[3].mesh.normals[v]);
        EXPECT_NEAR(lifted, 0.02F, 0.004F) << v;
    }
}

TEST(OutfitFitter, LetsLegsPassThroughATop) {
    Fitting f;
    const std::vector<Eigen::Vector3f> alone = f.fitter.fit(f.shaped, wear({1})).layers[0].positions;
    const std::vector<Eigen::Vector3f>& over = f.fitter.fit(f.shaped, wear({0, 1})).layers[1].positions;
    std::size_t legs = 0;
    for (std::size_t v = 0; v < alone.size(); ++v) {
        if (alone[v].y() > 0.7F) continue;
        ++legs;
        EXPECT_LE((over[v] - alone[v]).norm(), 1e-6F);
    }
    EXPECT_GT(legs, 100U);
}

TEST(OutfitFitter, LeavesOutWhatIsNotInTheWardrobe) {
    Fitting f;
    const FittedOutfit& fitted = f.fitter.fit(f.shaped, wear({99, 1}));
    ASSERT_EQ(fitted.count, 1U);
    EXPECT_EQ(fitted.layers[0].garment, &f.wardrobe[1]);
    EXPECT_EQ(f.fitter.fit(f.shaped, Outfit{}).count, 0U);
}

TEST(OutfitFitter, RaisesItsRevisionWithEveryFit) {
    Fitting f;
    const std::uint64_t first = f.fitter.fit(f.shaped, wear({0})).revision;
    EXPECT_EQ(f.fitter.fit(f.shaped, wear({0})).revision, first + 1);
    EXPECT_EQ(f.fitter.fitted().revision, first + 1);
}

TEST(OutfitFitter, TakesNoMemoryWhenItFits) {
    Fitting f;
    const cheval::test::AllocationCounter counter;
    f.fitter.fit(f.shaped, wear({0, 1, 2, 3, 0, 1, 2, 3}));
    f.fitter.fit(f.shaped, wear({2}));
    EXPECT_EQ(counter.count(), 0U);
}

TEST(OutfitFitter, GivesUnitNormalsThatLookOutwards) {
    Fitting f({1.4F, 0.8F, 1.1F});
    const FittedOutfit& fitted = f.fitter.fit(f.shaped, wear({0}));
    for (std::size_t v = 0; v < fitted.layers[0].normals.size(); ++v) {
        EXPECT_NEAR(fitted.layers[0].normals[v].norm(), 1.0F, 1e-4F);
        EXPECT_GT(fitted.layers[0].normals[v].dot(f.wardrobe[0].mesh.normals[v]), 0.8F);
    }
}

TEST(CageBinding, BindsToTheSideThatTheClothLooksTo) {
    // Two parallel sheets back to back, 10 mm apart; a vertex between them, nearer to the wrong one.
    const std::vector<Triangle> triangles = {{0, 1, 2}, {3, 5, 4}};
    const std::vector<Eigen::Vector3f> cage = {{0, 0, 0},     {1, 0, 0},     {0, 1, 0},
                                               {0, 0, 0.01F}, {1, 0, 0.01F}, {0, 1, 0.01F}};
    const std::vector<std::uint8_t> covered(6, 1);
    const std::vector<Eigen::Vector3f> points = {{0.2F, 0.2F, 0.008F}, {0.2F, 0.2F, 0.002F}};
    const std::vector<Eigen::Vector3f> normals = {{0, 0, 1}, {0, 0, -1}};
    const auto bindings = bindToCages({triangles, cage, cage}, covered, points, normals);
    ASSERT_EQ(bindings.size(), 2U);
    EXPECT_EQ(bindings[0].triangle, 0U);
    EXPECT_EQ(bindings[1].triangle, 1U);
}

TEST(CageBinding, FindsTheNearestPointOfATriangle) {
    const Eigen::Vector3f a(0, 0, 0);
    const Eigen::Vector3f b(1, 0, 0);
    const Eigen::Vector3f c(0, 1, 0);
    const auto at = [&](const Eigen::Vector3f& p) {
        const Eigen::Vector3f weights = nearestBarycentric(p, a, b, c);
        EXPECT_NEAR(weights.sum(), 1.0F, 1e-6F);
        return Eigen::Vector3f(weights[0] * a + weights[1] * b + weights[2] * c);
    };
    EXPECT_LE((at({0.2F, 0.3F, 5.0F}) - Eigen::Vector3f(0.2F, 0.3F, 0)).norm(), 1e-6F);
    EXPECT_LE((at({-1, -1, 0}) - a).norm(), 1e-6F);
    EXPECT_LE((at({3, -1, 0}) - b).norm(), 1e-6F);
    EXPECT_LE((at({-1, 3, 0}) - c).norm(), 1e-6F);
    EXPECT_LE((at({0.5F, -2, 1}) - Eigen::Vector3f(0.5F, 0, 0)).norm(), 1e-6F);
    EXPECT_LE((at({-2, 0.5F, 1}) - Eigen::Vector3f(0, 0.5F, 0)).norm(), 1e-6F);
    EXPECT_LE((at({1, 1, 0}) - Eigen::Vector3f(0.5F, 0.5F, 0)).norm(), 1e-6F);
    EXPECT_TRUE(nearestBarycentric({1, 2, 3}, a, a, a).allFinite());
}

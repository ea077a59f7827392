// The wardrobe that the build bakes, through loader, fitter and animator.
#include <cmath>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "fitting/animation/animator.h"
#include "fitting/garment/garment.h"
#include "fitting/layering/outfit_fitter.h"
#include "tests/support/made_body.h"

using namespace cheval;
using namespace cheval::fitting;

namespace {

Body loadedBody() {
    auto body = loadBody(std::string(CHEVAL_ASSETS) + "/body.glb");
    EXPECT_TRUE(body.hasValue()) << body.error().message();
    return std::move(body).value();
}

std::vector<Garment> loadedWardrobe(const Body& body) {
    std::vector<Garment> wardrobe;
    for (const auto& entry : std::filesystem::directory_iterator(CHEVAL_ASSETS)) {
        if (entry.path().extension() != ".glb" || entry.path().stem() == "body") continue;
        auto garment = loadGarment(entry.path().string(), body.cageTemplate);
        EXPECT_TRUE(garment.hasValue()) << garment.error().message();
        if (garment) wardrobe.push_back(std::move(garment).value());
    }
    return wardrobe;
}

}  // namespace

TEST(Wardrobe, LoadsWithAShirtAndTrousers) {
    const Body body = loadedBody();
    bool top = false;
    bool trousers = false;
    for (const Garment& garment : loadedWardrobe(body)) {
        top = top || garment.kind == GarmentKind::top;
        trousers = trousers || garment.kind == GarmentKind::trousers;
        EXPECT_FALSE(garment.material.baseColourTexture.empty() && garment.material.name.empty()) << garment.id;
    }
    EXPECT_TRUE(top);
    EXPECT_TRUE(trousers);
}

TEST(Wardrobe, ReturnsItselfOnItsOwnBody) {
    const Body body = loadedBody();
    const std::vector<Garment> wardrobe = loadedWardrobe(body);
    OutfitFitter fitter(body, wardrobe);
    ShapedBody shaped;
    shapeBody(body, {}, shaped);
    for (std::uint16_t which = 0; which < wardrobe.size(); ++which) {
        const FittedOutfit& fitted = fitter.fit(shaped, {.garments = {which}, .count = 1});
        ASSERT_EQ(fitted.count, 1U) << wardrobe[which].id;
        float farthest = 0.0F;
        for (std::size_t v = 0; v < fitted.layers[0].positions.size(); ++v) {
            farthest = std::max(farthest, (fitted.layers[0].positions[v] - wardrobe[which].mesh.positions[v]).norm());
        }
        EXPECT_LE(farthest, 1e-6F) << wardrobe[which].id;
    }
}

TEST(Wardrobe, LiesOutsideTheBodyOnSlimAndBroadShoppers) {
    const Body body = loadedBody();
    const std::vector<Garment> wardrobe = loadedWardrobe(body);
    OutfitFitter fitter(body, wardrobe);
    ShapedBody shaped;
    for (const Eigen::Vector3f& scale : {Eigen::Vector3f(0.85F, 0.9F, 0.875F), Eigen::Vector3f(1.25F, 1.05F, 1.15F)}) {
        shapeBody(body, {.scale = scale}, shaped);
        for (std::uint16_t which = 0; which < wardrobe.size(); ++which) {
            const FittedOutfit& fitted = fitter.fit(shaped, {.garments = {which}, .count = 1});
            for (std::size_t v = 0; v < fitted.layers[0].positions.size(); ++v) {
                const Eigen::Vector3f scaled = wardrobe[which].mesh.positions[v].cwiseProduct(scale);
                ASSERT_LE((fitted.layers[0].positions[v] - scaled).norm(), 0.02F) << wardrobe[which].id;
            }
        }
    }
}

TEST(Wardrobe, IsPosedWithTheBody) {
    const Body body = loadedBody();
    const std::vector<Garment> wardrobe = loadedWardrobe(body);
    OutfitFitter fitter(body, wardrobe);
    ShapedBody shaped;
    shapeBody(body, {}, shaped);
    Animator animator(body, {});
    PosedMesh posed;
    animator.reserve(posed);
    fitter.fit(shaped, {.garments = {0, 1}, .count = 2});
    animator.pose(shaped, fitter.fitted(), test::restSkeleton(body, {0.0F, 0.0F, 2.0F}), posed);
    ASSERT_EQ(posed.parts.size(), 3U);
    const Eigen::Quaternionf facing(0, 0, 1, 0);
    for (std::size_t v = 0; v < body.mesh.positions.size(); ++v) {
        const Eigen::Vector3f expected = facing * body.mesh.positions[v] + Eigen::Vector3f(0, 0, 2);
        ASSERT_LE((Eigen::Vector3f(posed.vertices[v].x, posed.vertices[v].y, posed.vertices[v].z) - expected).norm(),
                  1e-4F);
    }
}

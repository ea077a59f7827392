#include "fitting/bake/wardrobe.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fitting/bake/bake_fixture.h"

namespace cheval::fitting::bake {
namespace {

class EveryGarment : public testing::TestWithParam<std::string> {
  protected:
    const Garment& worn() const { return garment(GetParam()); }
};

double skinDistance(const Eigen::Vector3f& point) {
    return bodyModel().field.mirrored(point.cast<double>());
}

TEST_P(EveryGarment, ShowsNoSkinThroughTheCloth) {
    const RestMesh& mesh = worn().mesh;
    for (const Eigen::Vector3f& p : mesh.positions) {
        ASSERT_GE(skinDistance(p), 0.001F) << p.transpose();
    }
    // Nor between vertices.
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3f centre = (mesh.positions[t.a] + mesh.positions[t.b] + mesh.positions[t.c]) / 3.0F;
        ASSERT_GE(skinDistance(centre), 0.0005F) << centre.transpose();
    }
}

TEST_P(EveryGarment, HangsLikeClothNotLikePaint) {
    double sum = 0.0;
    for (const Eigen::Vector3f& p : worn().mesh.positions) {
        sum += skinDistance(p);
        ASSERT_LT(skinDistance(p), 0.15) << p.transpose();
    }
    const double mean = sum / static_cast<double>(worn().mesh.positions.size());
    EXPECT_GT(mean, 0.008);
    EXPECT_LT(mean, 0.045);
}

TEST_P(EveryGarment, IsAClosedShellWithoutRawEdges) {
    // Every edge between two faces, except the hidden ends of the turned-in borders, which come in few closed loops.
    const RestMesh& mesh = worn().mesh;
    const auto place = [&](std::uint32_t v) {
        const Eigen::Vector3f& p = mesh.positions[v];
        return std::tuple(p.x(), p.y(), p.z());
    };
    std::map<std::pair<std::tuple<float, float, float>, std::tuple<float, float, float>>, int> edges;
    for (const Triangle& t : mesh.triangles) {
        for (const auto& [a, b] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
            ++edges[{place(a), place(b)}];
        }
    }
    std::size_t open = 0;
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        if (!edges.contains({edge.second, edge.first})) ++open;
    }
    const bool top = worn().kind == GarmentKind::top;
    EXPECT_LE(open, top ? 64U + 64U + 2U * 40U : 64U + 2U * 48U) << "collar, hem and cuffs; or waist and two hems";
}

TEST_P(EveryGarment, LiesBetweenItsCagesWhereCovered) {
    const Garment& g = worn();
    ASSERT_EQ(g.innerCage.size(), bodyModel().body.outerCage.size());
    ASSERT_EQ(g.outerCage.size(), g.innerCage.size());
    ASSERT_EQ(g.covered.size(), g.innerCage.size());
    std::size_t covered = 0;
    for (std::size_t i = 0; i < g.covered.size(); ++i) {
        EXPECT_EQ(g.innerCage[i], bodyModel().body.outerCage[i]) << "on its own body the garment must return itself";
        if (g.covered[i] == 0) {
            EXPECT_EQ(g.outerCage[i], bodyModel().body.outerCage[i]);
            continue;
        }
        ++covered;
        EXPECT_GT(skinDistance(g.outerCage[i]), kCageDistance + 0.002) << i;
    }
    EXPECT_GT(covered, 80U);
    EXPECT_LT(covered, 600U);
}

TEST_P(EveryGarment, KeepsSeamsOfTheCagesTogether) {
    const CageTemplate& cage = bodyModel().body.cageTemplate;
    for (std::size_t i = 0; i < cage.vertexCount(); ++i) {
        EXPECT_EQ(worn().outerCage[i], worn().outerCage[cage.weld[i]]);
        EXPECT_EQ(worn().covered[i], worn().covered[cage.weld[i]]);
    }
}

TEST_P(EveryGarment, HasATextureThatDoesNotStretch) {
    // Texture length over cloth length is the same everywhere, but for shear and the odd dart.
    const RestMesh& mesh = worn().mesh;
    std::vector<float> ratio;
    for (const Triangle& t : mesh.triangles) {
        const float cloth =
            (mesh.positions[t.b] - mesh.positions[t.a]).cross(mesh.positions[t.c] - mesh.positions[t.a]).norm();
        const Eigen::Vector2f a = mesh.uv[t.b] - mesh.uv[t.a];
        const Eigen::Vector2f b = mesh.uv[t.c] - mesh.uv[t.a];
        const float area = std::abs(a.x() * b.y() - a.y() * b.x());
        if (area > 1e-9F && cloth > 1e-7F) ratio.push_back(area / cloth);
    }
    std::sort(ratio.begin(), ratio.end());
    const float median = ratio[ratio.size() / 2];
    EXPECT_GT(ratio[ratio.size() / 10], 0.6F * median);
    EXPECT_LT(ratio[ratio.size() * 9 / 10], 1.6F * median);
    for (const Eigen::Vector2f& uv : mesh.uv) {
        ASSERT_GE(uv.minCoeff(), 0.0F);
        ASSERT_LE(uv.maxCoeff(), 1.0F);
    }
}

TEST_P(EveryGarment, TakesNothingFromBonesThatItDoesNotCover) {
    const bool top = worn().kind == GarmentKind::top;
    for (const SkinningWeights& weights : worn().mesh.weights) {
        float sum = 0.0F;
        for (int i = 0; i < 4; ++i) {
            sum += weights.weight[i];
            if (weights.weight[i] == 0.0F) continue;
            const std::string_view name = kJointNames[weights.joint[i]];
            const bool leg = name.ends_with("knee") || name.ends_with("foot");
            const bool arm = name.ends_with("shoulder") || name.ends_with("elbow") || name.ends_with("hand");
            EXPECT_FALSE(top ? leg : arm) << name;
        }
        EXPECT_NEAR(sum, 1.0F, 1e-5F);
    }
}

TEST_P(EveryGarment, IsOfAUsableSize) {
    EXPECT_GT(worn().mesh.positions.size(), 2000U);
    EXPECT_LT(worn().mesh.positions.size(), 12'000U);
    EXPECT_EQ(worn().layerOrder, worn().kind == GarmentKind::top ? 2 : 1);
    EXPECT_FALSE(worn().material.baseColourTexture.empty());
}

std::vector<std::string> everyId() {
    std::vector<std::string> ids;
    for (const GarmentSpecification& specification : wardrobe()) {
        ids.emplace_back(specification.id);
    }
    return ids;
}

INSTANTIATE_TEST_SUITE_P(Wardrobe, EveryGarment, testing::ValuesIn(everyId()), [](const auto& instance) {
    std::string name = instance.param;
    std::erase(name, '-');
    return name;
});

TEST(Wardrobe, BeginsWithTheTShirtAndHasTrousers) {
    ASSERT_GE(wardrobe().size(), 2U);
    EXPECT_EQ(wardrobe()[0].id, "tshirt");
    ASSERT_NE(findGarment("trousers"), nullptr);
    EXPECT_EQ(findGarment("trousers")->kind, GarmentKind::trousers);
    EXPECT_EQ(findGarment("cape"), nullptr);
}

TEST(Wardrobe, WearsShirtsOverTrousers) {
    // Both lie on the same body: at the hips the shirt's hem must be outside the trousers' waist.
    const Garment& shirt = garment("tshirt");
    const Garment& trousers = garment("trousers");
    for (std::size_t i = 0; i < shirt.covered.size(); ++i) {
        if (shirt.covered[i] == 0 || trousers.covered[i] == 0) continue;
        EXPECT_GT(skinDistance(shirt.outerCage[i]), skinDistance(trousers.outerCage[i])) << i;
    }
}

}  // namespace
}  // namespace cheval::fitting::bake

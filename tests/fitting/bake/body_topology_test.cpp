#include "fitting/bake/body_topology.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cheval::fitting::bake {
namespace {

const BodyTopology& topology() {
    static const BodyTopology kTopology = makeTopology();
    return kTopology;
}

// The template is frozen: every cage in every asset out there stands on it. If this fails, do not change the number;
// change back what moved it.
TEST(CageTemplate, IsFrozen) {
    EXPECT_EQ(topology().cageTemplate.hash, 0x33b92009e3005057ULL);
    EXPECT_EQ(topology().cageTemplate.vertexCount(), 1187U);
    EXPECT_EQ(topology().cageTemplate.triangles.size(), 2264U);
}

TEST(CageTemplate, CarriesTheHashOfItsOwnContent) {
    EXPECT_EQ(topology().cageTemplate.hash, hashCageTemplate(topology().cageTemplate));
}

TEST(CageTemplate, HashNoticesAnyChange) {
    const CageTemplate& original = topology().cageTemplate;
    CageTemplate moved = original;
    moved.uv[17].x() += 1e-4F;
    EXPECT_NE(hashCageTemplate(moved), original.hash);
    CageTemplate turned = original;
    std::swap(turned.triangles[5].a, turned.triangles[5].b);
    EXPECT_NE(hashCageTemplate(turned), original.hash);
    CageTemplate unwelded = original;
    unwelded.weld.back() = static_cast<std::uint16_t>(unwelded.weld.size() - 1);
    unwelded.weld[0] = 1;
    EXPECT_NE(hashCageTemplate(unwelded), original.hash);
    CageTemplate relabelled = original;
    relabelled.part[3] = BodyPart::leftFoot;
    EXPECT_NE(hashCageTemplate(relabelled), original.hash);
}

TEST(CageTemplate, StaysWithinTheLimit) {
    EXPECT_LE(topology().cageTemplate.vertexCount(), kMaximumCageVertices);
}

TEST(CageTemplate, UvIsUniqueWithRoomForTheMatchingTolerance) {
    const auto& uv = topology().cageTemplate.uv;
    for (std::size_t i = 0; i < uv.size(); ++i) {
        EXPECT_GT(uv[i].minCoeff(), 0.0F);
        EXPECT_LT(uv[i].maxCoeff(), 1.0F);
        for (std::size_t k = i + 1; k < uv.size(); ++k) {
            ASSERT_GE((uv[i] - uv[k]).norm(), 1e-3F) << i << " and " << k;
        }
    }
}

TEST(CageTemplate, IsWatertightAndOrientedOnceWelded) {
    const CageTemplate& cage = topology().cageTemplate;
    std::map<std::pair<std::uint16_t, std::uint16_t>, int> edges;
    for (const Triangle& t : cage.triangles) {
        const std::uint16_t corner[3] = {cage.weld[t.a], cage.weld[t.b], cage.weld[t.c]};
        for (int i = 0; i < 3; ++i) {
            ASSERT_NE(corner[i], corner[(i + 1) % 3]);
            ++edges[{corner[i], corner[(i + 1) % 3]}];
        }
    }
    std::set<std::uint16_t> vertices;
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(edges.contains({edge.second, edge.first}));
        vertices.insert(edge.first);
    }
    // One closed surface without handles: V − E + F = 2.
    const auto euler = static_cast<long>(vertices.size()) - static_cast<long>(edges.size() / 2) +
                       static_cast<long>(cage.triangles.size());
    EXPECT_EQ(euler, 2);
}

TEST(CageTemplate, WeldsToTheLowestVertexOfAPlace) {
    const CageTemplate& cage = topology().cageTemplate;
    std::size_t seams = 0;
    for (std::size_t i = 0; i < cage.vertexCount(); ++i) {
        EXPECT_LE(cage.weld[i], i);
        EXPECT_EQ(cage.weld[cage.weld[i]], cage.weld[i]);
        EXPECT_EQ(topology().meshVertexOf[i], topology().meshVertexOf[cage.weld[i]]);
        if (cage.weld[i] != i) ++seams;
    }
    EXPECT_EQ(seams, cage.vertexCount() - topology().places.size());
}

TEST(CageTemplate, MirrorsOntoItself) {
    const CageTemplate& cage = topology().cageTemplate;
    const auto key = [](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        std::array<std::uint32_t, 3> corners = {a, b, c};
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        return corners;
    };
    std::set<std::array<std::uint32_t, 3>> triangles;
    for (const Triangle& t : cage.triangles) {
        triangles.insert(key(t.a, t.b, t.c));
    }
    for (const Triangle& t : cage.triangles) {
        EXPECT_TRUE(triangles.contains(key(cage.mirrored[t.a], cage.mirrored[t.c], cage.mirrored[t.b])));
    }
    for (std::size_t i = 0; i < cage.vertexCount(); ++i) {
        EXPECT_EQ(cage.mirrored[cage.mirrored[i]], i);
        EXPECT_EQ(cage.weld[cage.mirrored[cage.weld[i]]], cage.weld[cage.mirrored[i]]);
    }
}

TEST(CageTemplate, HasEveryBodyPartOnItsOwnSide) {
    const CageTemplate& cage = topology().cageTemplate;
    std::array<int, kBodyPartCount> count{};
    for (const BodyPart part : cage.part) {
        ++count[static_cast<std::size_t>(part)];
    }
    for (std::size_t p = 0; p < kBodyPartCount; ++p) {
        EXPECT_GT(count[p], 10) << p;
    }
    const auto of = [&](BodyPart part) { return count[static_cast<std::size_t>(part)]; };
    EXPECT_EQ(of(BodyPart::leftUpperArm), of(BodyPart::rightUpperArm));
    EXPECT_EQ(of(BodyPart::leftHand), of(BodyPart::rightHand));
    EXPECT_EQ(of(BodyPart::leftShin), of(BodyPart::rightShin));
    EXPECT_EQ(of(BodyPart::leftFoot), of(BodyPart::rightFoot));
}

}  // namespace
}  // namespace cheval::fitting::bake

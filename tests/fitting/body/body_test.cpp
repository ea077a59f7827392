#include "fitting/body/body.h"

#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"
#include "tests/support/glb_builder.h"
#include "tests/support/made_body.h"

using namespace cheval;
using namespace cheval::fitting;
using testing::HasSubstr;

namespace {

void expectRefusal(const Expected<Body>& loaded, const std::string& what) {
    ASSERT_FALSE(loaded.hasValue());
    EXPECT_THAT(loaded.error().message(), HasSubstr(what));
    EXPECT_FALSE(loaded.error().mend.empty());
}

}  // namespace

TEST(BodyLoader, ReadsBackWhatWasWritten) {
    const Body body = test::makeBody();
    const auto loaded = parseBody(test::bodyGlb(body).bytes(), "body.glb");
    ASSERT_TRUE(loaded.hasValue()) << loaded.error().message();
    EXPECT_EQ(loaded->cageTemplate.hash, body.cageTemplate.hash);
    EXPECT_EQ(loaded->cageTemplate.weld, body.cageTemplate.weld);
    EXPECT_EQ(loaded->cageTemplate.mirrored, body.cageTemplate.mirrored);
    EXPECT_EQ(loaded->cageTemplate.part, body.cageTemplate.part);
    EXPECT_EQ(loaded->outerCage, body.outerCage);
    EXPECT_EQ(loaded->mesh.positions, body.mesh.positions);
    for (std::size_t i = 0; i < kJointCount; ++i) {
        EXPECT_LE((loaded->joints[i] - body.joints[i]).norm(), 1e-6F) << kJointNames[i];
    }
}

TEST(BodyLoader, RefusesACageThatIsNotTheOneItsHashNames) {
    const Body body = test::makeBody();
    test::GlbBuilder glb = test::bodyGlb(body);
    float moved = body.cageTemplate.uv[40].x() + 0.001F;
    std::memcpy(glb.data("Body_OuterCage", "TEXCOORD_0") + 8 * 40, &moved, sizeof moved);
    expectRefusal(parseBody(glb.bytes(), "body.glb"), "hash");
}

TEST(BodyLoader, RefusesAWeldThatLeadsElsewhere) {
    test::GlbBuilder glb = test::bodyGlb(test::makeBody());
    const float elsewhere = 0.0F;
    std::memcpy(glb.data("Body_OuterCage", "_WELD") + 4 * 40, &elsewhere, sizeof elsewhere);
    expectRefusal(parseBody(glb.bytes(), "body.glb"), "_WELD");
}

TEST(BodyLoader, RefusesAMirrorMapThatDoesNotLeadBack) {
    test::GlbBuilder glb = test::bodyGlb(test::makeBody());
    const float other = 3.0F;
    std::memcpy(glb.data("Body_OuterCage", "_MIRRORED") + 4 * 40, &other, sizeof other);
    expectRefusal(parseBody(glb.bytes(), "body.glb"), "_MIRRORED");
}

TEST(BodyLoader, RefusesABodyPartThatThereIsNot) {
    test::GlbBuilder glb = test::bodyGlb(test::makeBody());
    const float part = 17.0F;
    std::memcpy(glb.data("Body_OuterCage", "_PART") + 4 * 40, &part, sizeof part);
    expectRefusal(parseBody(glb.bytes(), "body.glb"), "_PART");
}

TEST(BodyLoader, NamesTheJointThatIsMissing) {
    test::GlbBuilder glb = test::bodyGlb(test::makeBody());
    glb.json["skins"][0]["joints"].erase(glb.json["skins"][0]["joints"].size() - 1);
    for (auto& node : glb.json["nodes"]) {
        if (node["name"] == "right_foot") node["name"] = "x";
    }
    expectRefusal(parseBody(glb.bytes(), "body.glb"), "");
}

TEST(ShapeBody, ScalesAboutTheFloorWithCageAndJoints) {
    const Body body = test::makeBody();
    ShapedBody shaped;
    const Eigen::Vector3f scale(1.2F, 0.9F, 1.05F);
    shapeBody(body, {.scale = scale, .revision = 7}, shaped);
    EXPECT_EQ(shaped.revision, 7U);
    ASSERT_EQ(shaped.positions.size(), body.mesh.positions.size());
    ASSERT_EQ(shaped.outerCage.size(), body.outerCage.size());
    EXPECT_EQ(shaped.positions[9], body.mesh.positions[9].cwiseProduct(scale));
    EXPECT_EQ(shaped.outerCage[9], body.outerCage[9].cwiseProduct(scale));
    EXPECT_EQ(shaped.joints[index(Joint::neck)], body.joints[index(Joint::neck)].cwiseProduct(scale));
}

TEST(ShapeBody, KeepsNormalsAtRightAnglesToTheSurface) {
    const Body body = test::makeBody();
    ShapedBody shaped;
    const Eigen::Vector3f scale(1.5F, 0.7F, 1.1F);
    shapeBody(body, {.scale = scale}, shaped);
    for (std::size_t i = 0; i < body.mesh.normals.size(); i += 5) {
        const Eigen::Vector3f tangent = body.mesh.normals[i].unitOrthogonal();
        EXPECT_NEAR(shaped.normals[i].norm(), 1.0F, 1e-5F);
        EXPECT_NEAR(shaped.normals[i].dot(tangent.cwiseProduct(scale)), 0.0F, 1e-5F);
    }
}

TEST(ShapeBody, TakesNoMemoryTheSecondTime) {
    const Body body = test::makeBody();
    ShapedBody shaped;
    shapeBody(body, {}, shaped);
    const test::AllocationCounter counter;
    shapeBody(body, {.scale = {1.1F, 1.0F, 1.05F}, .revision = 2}, shaped);
    EXPECT_EQ(counter.count(), 0U);
}

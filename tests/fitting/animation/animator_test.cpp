#include "fitting/animation/animator.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"
#include "tests/support/made_body.h"

using namespace cheval;
using namespace cheval::fitting;

namespace {

const Eigen::Quaternionf kFacing(0, 0, 1, 0);

struct Stage {
    Body body = test::makeBody();
    std::vector<Garment> wardrobe = {test::makeGarment(body), test::makeGarment(body, {.legs = true})};
    ShapedBody shaped;
    OutfitFitter fitter{body, wardrobe};
    Animator animator{body, {}};
    PosedMesh posed;

    Stage() {
        shapeBody(body, BodyShape{}, shaped);
        wear({0});
        animator.reserve(posed);
    }
    void wear(std::initializer_list<std::uint16_t> garments) {
        Outfit outfit;
        for (const std::uint16_t garment : garments)
            outfit.garments[outfit.count++] = garment;
        fitter.fit(shaped, outfit);
    }
    const PosedMesh& pose(const Skeleton& skeleton) {
        animator.pose(shaped, fitter.fitted(), skeleton, posed);
        return posed;
    }
    [[nodiscard]] Eigen::Vector3f vertex(std::size_t i) const {
        return {posed.vertices[i].x, posed.vertices[i].y, posed.vertices[i].z};
    }
};

bool allFinite(const PosedMesh& posed) {
    for (const PosedVertex& v : posed.vertices) {
        for (const float number : {v.x, v.y, v.z, v.nx, v.ny, v.nz}) {
            if (!std::isfinite(number)) return false;
        }
    }
    return true;
}

// Turns what hangs below a joint about it.
void bend(Skeleton& skeleton, std::initializer_list<Joint> joints, Joint about, const Eigen::Quaternionf& turn) {
    const Eigen::Vector3f centre = skeleton[about].position;
    for (const Joint joint : joints) {
        skeleton[joint].position = centre + turn * (skeleton[joint].position - centre);
        skeleton[joint].orientation = turn * skeleton[joint].orientation;
    }
}

}  // namespace

TEST(Animator, ReturnsTheRestPoseFacingTheGlass) {
    Stage stage;
    stage.pose(test::restSkeleton(stage.body, {0.1F, 0.0F, 2.0F}));
    ASSERT_EQ(stage.posed.vertices.size(), stage.body.mesh.positions.size() + stage.wardrobe[0].mesh.positions.size());
    for (std::size_t i = 0; i < stage.body.mesh.positions.size(); ++i) {
        const Eigen::Vector3f expected = kFacing * stage.body.mesh.positions[i] + Eigen::Vector3f(0.1F, 0.0F, 2.0F);
        ASSERT_LE((stage.vertex(i) - expected).norm(), 1e-5F) << i;
        const PosedVertex& v = stage.posed.vertices[i];
        ASSERT_LE((Eigen::Vector3f(v.nx, v.ny, v.nz) - kFacing * stage.body.mesh.normals[i]).norm(), 1e-4F);
        ASSERT_EQ(v.u, stage.body.mesh.uv[i].x());
    }
}

TEST(Animator, MovesEveryVertexRigidlyWithTheWholeSkeleton) {
    Stage stage;
    Eigen::Isometry3f motion = Eigen::Isometry3f::Identity();
    motion.translate(Eigen::Vector3f(0.4F, 0.1F, 1.7F));
    motion.rotate(Eigen::AngleAxisf(0.8F, Eigen::Vector3f(0.2F, 1.0F, -0.1F).normalized()));
    stage.pose(test::restSkeleton(stage.body));
    const PosedMesh rest = stage.posed;
    stage.pose(test::movedSkeleton(stage.body, motion));
    for (std::size_t i = 0; i < rest.vertices.size(); ++i) {
        const Eigen::Vector3f expected =
            motion * Eigen::Vector3f(rest.vertices[i].x, rest.vertices[i].y, rest.vertices[i].z);
        ASSERT_LE((stage.vertex(i) - expected).norm(), 1e-4F) << i;
    }
}

TEST(Animator, LaysBonesOnTheTrackedJoints) {
    Stage stage;
    Skeleton skeleton = test::restSkeleton(stage.body);
    bend(skeleton, {Joint::leftElbow, Joint::leftHand}, Joint::leftShoulder,
         Eigen::Quaternionf(Eigen::AngleAxisf(1.2F, Eigen::Vector3f::UnitZ())));
    skeleton[Joint::leftHand].position += Eigen::Vector3f(0.0F, 0.03F, -0.02F);  // A longer forearm.
    stage.pose(skeleton);
    // Rings of the forearm tube are centred on the line from elbow to hand.
    const Eigen::Vector3f elbow = skeleton[Joint::leftElbow].position;
    const Eigen::Vector3f along = (skeleton[Joint::leftHand].position - elbow).normalized();
    std::size_t checked = 0;
    for (std::size_t i = 0; i < stage.body.mesh.positions.size(); ++i) {
        const SkinningWeights& weights = stage.body.mesh.weights[i];
        if (weights.joint[0] != index(Joint::leftElbow) || weights.weight[0] < 1.0F) continue;
        const Eigen::Vector3f away = stage.vertex(i) - elbow;
        EXPECT_LE((away - along * along.dot(away)).norm(), 0.045F);
        ++checked;
    }
    EXPECT_GT(checked, 50U);
}

TEST(Animator, KeepsTheLastRotationOfABoneThatIsNotSeen) {
    Stage stage;
    Skeleton raised = test::restSkeleton(stage.body);
    bend(raised, {Joint::leftElbow, Joint::leftHand}, Joint::leftShoulder,
         Eigen::Quaternionf(Eigen::AngleAxisf(-1.0F, Eigen::Vector3f::UnitZ())));
    stage.pose(raised);
    const PosedMesh before = stage.posed;
    Skeleton lost = raised;
    for (const Joint joint : {Joint::leftElbow, Joint::leftHand}) {
        lost[joint].position = {5, 5, 5};
        lost[joint].confidence = 0.49F;
    }
    stage.pose(lost);
    for (std::size_t i = 0; i < before.vertices.size(); ++i) {
        const Eigen::Vector3f was(before.vertices[i].x, before.vertices[i].y, before.vertices[i].z);
        ASSERT_LE((stage.vertex(i) - was).norm(), 1e-4F);
    }
}

TEST(Animator, TurnsAnUnseenArmWithTheBody) {
    Stage stage;
    const Skeleton facing = test::restSkeleton(stage.body);
    stage.pose(facing);
    Eigen::Isometry3f turn = Eigen::Isometry3f::Identity();
    turn.rotate(Eigen::AngleAxisf(1.0F, Eigen::Vector3f::UnitY()));
    Skeleton turned = test::movedSkeleton(stage.body, turn);
    stage.pose(turned);
    const PosedMesh seen = stage.posed;
    stage.animator.reset();
    stage.pose(facing);
    for (const Joint joint : {Joint::rightElbow, Joint::rightHand})
        turned[joint].confidence = 0.0F;
    stage.pose(turned);
    for (std::size_t i = 0; i < seen.vertices.size(); ++i) {
        ASSERT_LE(
            (stage.vertex(i) - Eigen::Vector3f(seen.vertices[i].x, seen.vertices[i].y, seen.vertices[i].z)).norm(),
            1e-4F);
    }
}

TEST(Animator, TreatsANumberThatIsNotFiniteAsUnseen) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = 0; i < kJointCount; ++i) {
        Stage stage;
        Skeleton skeleton = test::restSkeleton(stage.body);
        stage.pose(skeleton);
        skeleton.joints[i].position.y() = nan;
        EXPECT_TRUE(allFinite(stage.pose(skeleton))) << kJointNames[i];
        skeleton = test::restSkeleton(stage.body);
        skeleton.joints[i].orientation.coeffs().setConstant(nan);
        EXPECT_TRUE(allFinite(stage.pose(skeleton))) << kJointNames[i];
        skeleton.joints[i].orientation.coeffs().setZero();
        EXPECT_TRUE(allFinite(stage.pose(skeleton))) << kJointNames[i];
    }
}

TEST(Animator, StaysWholeWhenOneJointJumpsAway) {
    for (std::size_t i = 0; i < kJointCount; ++i) {
        Stage stage;
        Skeleton skeleton = test::restSkeleton(stage.body);
        stage.pose(skeleton);
        skeleton.joints[i].position += Eigen::Vector3f(0.5F, -0.3F, 0.8F);
        stage.pose(skeleton);
        // The trunk neither turns over nor tears: its box stays about as large as it was.
        Eigen::AlignedBox3f box;
        for (std::size_t v = 0; v < stage.body.mesh.positions.size(); ++v) {
            if (stage.body.mesh.weights[v].joint[0] == index(Joint::torso)) box.extend(stage.vertex(v));
        }
        EXPECT_LT(box.diagonal().norm(), 1.2F) << kJointNames[i];
    }
}

TEST(Animator, PosesWithNobodyAndWithCoincidentJoints) {
    Stage stage;
    EXPECT_TRUE(allFinite(stage.pose(Skeleton{})));
    Skeleton collapsed = test::restSkeleton(stage.body);
    for (JointState& joint : collapsed.joints)
        joint.position = {0, 1, 2};
    EXPECT_TRUE(allFinite(stage.pose(collapsed)));
}

TEST(Animator, PosesMirroredSkeletonsAsMirrorImages) {
    Stage stage;
    Skeleton left = test::restSkeleton(stage.body);
    const Eigen::AngleAxisf turn(0.9F, Eigen::Vector3f(0.3F, 0.2F, 1.0F).normalized());
    bend(left, {Joint::leftElbow, Joint::leftHand}, Joint::leftShoulder, Eigen::Quaternionf(turn));
    Skeleton right = test::restSkeleton(stage.body);
    const Eigen::AngleAxisf opposite(-0.9F, Eigen::Vector3f(-0.3F, 0.2F, 1.0F).normalized());
    bend(right, {Joint::rightElbow, Joint::rightHand}, Joint::rightShoulder, Eigen::Quaternionf(opposite));
    stage.pose(left);
    const PosedMesh first = stage.posed;
    stage.animator.reset();
    stage.pose(right);
    const auto touches = [&](const Eigen::Vector3f& point) {
        for (std::size_t i = 0; i < stage.body.mesh.positions.size(); ++i) {
            if ((stage.vertex(i) - point).squaredNorm() < 1e-8F) return true;
        }
        return false;
    };
    for (std::size_t i = 0; i < stage.body.mesh.positions.size(); i += 7) {
        ASSERT_TRUE(touches({-first.vertices[i].x, first.vertices[i].y, first.vertices[i].z})) << i;
    }
}

TEST(Animator, RewritesTopologyOnlyWhenTheGarmentsChange) {
    Stage stage;
    const Skeleton skeleton = test::restSkeleton(stage.body);
    stage.pose(skeleton);
    const std::uint64_t first = stage.posed.topologyRevision;
    stage.wear({0});  // Fitted anew, same garments.
    stage.pose(skeleton);
    EXPECT_EQ(stage.posed.topologyRevision, first);
    stage.wear({1});
    stage.pose(skeleton);
    EXPECT_GT(stage.posed.topologyRevision, first);
    ASSERT_EQ(stage.posed.parts.size(), 2U);
    EXPECT_EQ(stage.posed.parts[0].kind, PartKind::body);
    EXPECT_EQ(stage.posed.parts[0].material, 0U);
    EXPECT_EQ(stage.posed.parts[1].kind, PartKind::garment);
    EXPECT_EQ(stage.posed.parts[1].material, 2U);
    EXPECT_EQ(stage.posed.parts[1].layer, 1U);
}

TEST(Animator, BringsEachMeshOfATripleBufferUpToDate) {
    Stage stage;
    const Skeleton skeleton = test::restSkeleton(stage.body);
    std::array<PosedMesh, 3> buffers;
    for (PosedMesh& mesh : buffers) {
        stage.animator.reserve(mesh);
        stage.animator.pose(stage.shaped, stage.fitter.fitted(), skeleton, mesh);
    }
    stage.wear({0, 1});
    for (PosedMesh& mesh : buffers) {
        stage.animator.pose(stage.shaped, stage.fitter.fitted(), skeleton, mesh);
        ASSERT_EQ(mesh.parts.size(), 3U);
        EXPECT_EQ(mesh.topologyRevision, buffers[0].topologyRevision);
        EXPECT_EQ(mesh.indices, buffers[0].indices);
        for (const std::uint32_t i : mesh.indices)
            ASSERT_LT(i, mesh.vertices.size());
        std::size_t covered = 0;
        for (const MeshPart& part : mesh.parts) {
            EXPECT_EQ(part.firstIndex, covered);
            covered += part.indexCount;
        }
        EXPECT_EQ(covered, mesh.indices.size());
    }
}

TEST(Animator, HidesTheBodyWellUnderGarmentsAndNowhereElse) {
    Stage stage;
    stage.wear({});
    stage.pose(test::restSkeleton(stage.body));
    EXPECT_EQ(stage.posed.parts[0].indexCount, 3 * stage.body.mesh.triangles.size());
    stage.wear({1});
    stage.pose(test::restSkeleton(stage.body));
    std::size_t drawn = 0;
    Eigen::AlignedBox3f box;
    for (std::size_t k = 0; k < stage.posed.parts[0].indexCount; ++k, ++drawn) {
        box.extend(stage.vertex(stage.posed.indices[k]));
    }
    EXPECT_LT(drawn, 3 * stage.body.mesh.triangles.size());
    EXPECT_GT(drawn, stage.body.mesh.triangles.size());
    // Head and feet's ends are bare of trousers and drawn.
    EXPECT_GT(box.max().y(), 1.7F);
}

TEST(Animator, LeavesOutWhatIsOverItsLimits) {
    Stage stage;
    const std::size_t bodyVertices = stage.body.mesh.positions.size();
    Animator small(stage.body, {.maximumVertices = bodyVertices + 10});
    PosedMesh mesh;
    small.reserve(mesh);
    small.pose(stage.shaped, stage.fitter.fitted(), test::restSkeleton(stage.body), mesh);
    EXPECT_EQ(mesh.vertices.size(), bodyVertices);
    EXPECT_EQ(mesh.parts.size(), 1U);
}

TEST(Animator, TakesNoMemoryAfterReserve) {
    Stage stage;
    stage.wear({0, 1});
    Skeleton skeleton = test::restSkeleton(stage.body);
    const test::AllocationCounter counter;
    stage.pose(skeleton);
    stage.wear({1});
    skeleton[Joint::leftHand].confidence = 0.1F;
    stage.pose(skeleton);
    stage.shaped.revision += 1;
    stage.pose(skeleton);
    EXPECT_EQ(counter.count(), 0U);
}

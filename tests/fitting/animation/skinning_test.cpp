#include "fitting/animation/skinning.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

using namespace cheval::fitting;

namespace {

struct Mesh {
    std::vector<float> x, y, z, nx, ny, nz, u, v;
    std::vector<SkinningWeights> weights;
    std::vector<BoneMatrix> bones;
    std::vector<PosedVertex> out;

    void add(const Eigen::Vector3f& p, const Eigen::Vector3f& n, const SkinningWeights& w) {
        x.push_back(p.x());
        y.push_back(p.y());
        z.push_back(p.z());
        nx.push_back(n.x());
        ny.push_back(n.y());
        nz.push_back(n.z());
        u.push_back(0.25F);
        v.push_back(0.75F);
        weights.push_back(w);
        out.emplace_back();
    }
    SkinningJob job() {
        return {.source = {.x = x, .y = y, .z = z, .nx = nx, .ny = ny, .nz = nz, .u = u, .v = v, .weights = weights},
                .bones = bones,
                .vertices = out};
    }
};

Eigen::Affine3f randomBone(std::mt19937& random) {
    std::uniform_real_distribution<float> number(-1.0F, 1.0F);
    Eigen::Affine3f bone = Eigen::Affine3f::Identity();
    bone.translate(Eigen::Vector3f(number(random), number(random), number(random)));
    bone.rotate(Eigen::Quaternionf(1.5F + number(random), number(random), number(random), number(random)).normalized());
    bone.scale(1.0F + 0.2F * number(random));
    return bone;
}

Mesh randomMesh(unsigned seed, int vertices) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> number(-1.0F, 1.0F);
    Mesh mesh;
    for (int i = 0; i < 15; ++i)
        mesh.bones.emplace_back(randomBone(random));
    for (int i = 0; i < vertices; ++i) {
        SkinningWeights weights;
        float sum = 0.0F;
        for (std::size_t k = 0; k < 4; ++k) {
            weights.joint[k] = static_cast<std::uint8_t>(random() % 15U);
            weights.weight[k] = std::abs(number(random)) + 0.01F;
            sum += weights.weight[k];
        }
        for (float& weight : weights.weight)
            weight /= sum;
        mesh.add({number(random), number(random), number(random)},
                 Eigen::Vector3f(number(random), number(random), number(random) + 2.0F).normalized(), weights);
    }
    return mesh;
}

}  // namespace

TEST(Skinning, RefusesLengthsThatDiffer) {
    Mesh mesh = randomMesh(1, 5);
    EXPECT_TRUE(mesh.job().isValid());
    mesh.nz.pop_back();
    EXPECT_FALSE(mesh.job().isValid());
    EXPECT_FALSE(mesh.job().run());
}

TEST(Skinning, RefusesToRunWithoutBones) {
    Mesh mesh = randomMesh(1, 5);
    mesh.bones.clear();
    EXPECT_FALSE(mesh.job().isValid());
    EXPECT_FALSE(mesh.job().run());
}

TEST(Skinning, FindsAJointThatIsNotThere) {
    Mesh mesh = randomMesh(1, 5);
    mesh.weights[2].joint[3] = 15;
    EXPECT_FALSE(mesh.job().isValid());
}

TEST(Skinning, AgreesWithTheDefinitionInDoublePrecision) {
    Mesh mesh = randomMesh(2, 500);
    ASSERT_TRUE(mesh.job().run());
    for (std::size_t i = 0; i < mesh.out.size(); ++i) {
        Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
        for (std::size_t k = 0; k < 4; ++k) {
            const BoneMatrix& bone = mesh.bones[mesh.weights[i].joint[k]];
            const Eigen::Map<const Eigen::Matrix4f> matrix(bone.columns.data());
            blend += static_cast<double>(mesh.weights[i].weight[k]) * matrix.topRows<3>().cast<double>();
        }
        const Eigen::Vector3d p =
            blend * Eigen::Vector4d(static_cast<double>(mesh.x[i]), static_cast<double>(mesh.y[i]),
                                    static_cast<double>(mesh.z[i]), 1.0);
        Eigen::Matrix3d linear = blend.leftCols<3>();
        const Eigen::Vector3d n = (linear.determinant() * linear.inverse().transpose() *
                                   Eigen::Vector3f(mesh.nx[i], mesh.ny[i], mesh.nz[i]).cast<double>())
                                      .normalized();
        const PosedVertex& out = mesh.out[i];
        EXPECT_LE((Eigen::Vector3f(out.x, out.y, out.z).cast<double>() - p).norm(), 1e-5);
        EXPECT_LE((Eigen::Vector3f(out.nx, out.ny, out.nz).cast<double>() - n).norm(), 1e-3);
        EXPECT_EQ(out.u, 0.25F);
        EXPECT_EQ(out.v, 0.75F);
    }
}

TEST(Skinning, KeepsAVertexWithinWhatItsBonesSay) {
    Mesh mesh = randomMesh(3, 500);
    ASSERT_TRUE(mesh.job().run());
    for (std::size_t i = 0; i < mesh.out.size(); ++i) {
        Eigen::AlignedBox3f box;
        for (std::size_t k = 0; k < 4; ++k) {
            const Eigen::Map<const Eigen::Matrix4f> bone(mesh.bones[mesh.weights[i].joint[k]].columns.data());
            box.extend(Eigen::Vector3f((bone * Eigen::Vector4f(mesh.x[i], mesh.y[i], mesh.z[i], 1.0F)).head<3>()));
        }
        const Eigen::Vector3f p(mesh.out[i].x, mesh.out[i].y, mesh.out[i].z);
        EXPECT_LE(box.exteriorDistance(p), 1e-5F);
    }
}

TEST(Skinning, KeepsTheRestNormalWhereBonesFoldAVertexFlat) {
    Mesh mesh;
    Eigen::Affine3f flat = Eigen::Affine3f::Identity();
    flat.linear().setZero();
    mesh.bones.emplace_back(flat);
    mesh.add({1, 2, 3}, {0, 1, 0}, SkinningWeights{});
    ASSERT_TRUE(mesh.job().run());
    EXPECT_EQ(mesh.out[0].ny, 1.0F);
    EXPECT_EQ(mesh.out[0].nx, 0.0F);
}

#include "fitting/bake/body_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fitting/bake/bake_fixture.h"

namespace cheval::fitting::bake {
namespace {

const Body& body() {
    return bodyModel().body;
}

bool sameBits(float a, float b) {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

/// The tape's length round the trunk at a height: the convex hull of the cut, arms left out.
double girth(double y, double halfBreadthLimit) {
    std::vector<Vec2> points;
    for (int i = 0; i < 360; ++i) {
        const double angle = i * std::numbers::pi / 180.0;
        const Vec3 direction(std::abs(std::sin(angle)), 0.0, std::cos(angle));
        const Field field = [&](const Vec3& p) { return bodyModel().field.trunk(p); };
        Vec3 p = castOut(field, Vec3(0.0, y, bodyModel().field.trunkLoft().centre(y).z()), direction, 0.4);
        p.x() = std::min(p.x(), halfBreadthLimit);
        points.emplace_back(i <= 180 ? p.x() : -p.x(), p.z());
    }
    std::sort(points.begin(), points.end(),
              [](const Vec2& a, const Vec2& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
    std::vector<Vec2> hull;
    for (int pass = 0; pass < 2; ++pass) {
        const std::size_t base = hull.size();
        for (const Vec2& p : points) {
            const auto turnsLeft = [&] {
                const Vec2 a = hull[hull.size() - 1] - hull[hull.size() - 2];
                const Vec2 b = p - hull[hull.size() - 1];
                return a.x() * b.y() - a.y() * b.x() > 0.0;
            };
            while (hull.size() >= base + 2 && !turnsLeft()) {
                hull.pop_back();
            }
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    double length = 0.0;
    for (std::size_t i = 0; i < hull.size(); ++i) {
        length += (hull[i] - hull[(i + 1) % hull.size()]).norm();
    }
    return length;
}

TEST(Mannequin, IsAsTallAsAPersonAndStandsOnTheFloor) {
    float low = 1.0F;
    float high = 0.0F;
    for (const Eigen::Vector3f& p : body().mesh.positions) {
        low = std::min(low, p.y());
        high = std::max(high, p.y());
    }
    EXPECT_NEAR(low, 0.0F, 0.002F);
    EXPECT_NEAR(high, 1.75F, 0.01F);
}

TEST(Mannequin, HasHumanGirths) {
    EXPECT_NEAR(girth(1.28, 0.19), 0.93, 0.05);
    EXPECT_NEAR(girth(1.09, 0.19), 0.74, 0.05);
    double hips = 0.0;
    for (double y = 0.85; y < 0.94; y += 0.01) {
        hips = std::max(hips, girth(y, 0.2));
    }
    EXPECT_NEAR(hips, 0.95, 0.05);
    EXPECT_NEAR(girth(1.515, 0.2), 0.365, 0.03);
}

TEST(Mannequin, HasHumanLimbs) {
    const auto& j = body().joints;
    const auto at = [&](Joint joint) { return j[index(joint)]; };
    EXPECT_NEAR((at(Joint::leftShoulder) - at(Joint::rightShoulder)).norm(), 0.345F, 0.03F);
    EXPECT_NEAR((at(Joint::leftShoulder) - at(Joint::leftElbow)).norm(), 0.29F, 0.02F);
    EXPECT_NEAR((at(Joint::leftHip) - at(Joint::leftKnee)).norm(), 0.415F, 0.03F);
    EXPECT_NEAR((at(Joint::leftKnee) - at(Joint::leftFoot)).norm(), 0.405F, 0.03F);
    const Eigen::Vector3f upperArm = (at(Joint::leftElbow) - at(Joint::leftShoulder)).normalized();
    EXPECT_NEAR(upperArm.x(), std::sqrt(0.5F), 0.02F) << "the arm hangs 45° down";
    EXPECT_NEAR(upperArm.y(), -std::sqrt(0.5F), 0.02F);
    EXPECT_GT(at(Joint::leftHand).x(), 0.0F) << "its left is at +X";
    EXPECT_NEAR(at(Joint::torso).y(), 0.5F * (at(Joint::neck).y() + at(Joint::leftHip).y()), 1e-5F);
}

TEST(Mannequin, HasItsJointsInsideTheFlesh) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
        EXPECT_LT(bodyModel().field.mirrored(body().joints[j].cast<double>()), -0.010) << kJointNames[j];
    }
}

TEST(Mannequin, HasJointsMirroredBitForBit) {
    const auto& j = body().joints;
    for (const auto& [left, right] :
         {std::pair(Joint::leftShoulder, Joint::rightShoulder), std::pair(Joint::leftElbow, Joint::rightElbow),
          std::pair(Joint::leftHand, Joint::rightHand), std::pair(Joint::leftHip, Joint::rightHip),
          std::pair(Joint::leftKnee, Joint::rightKnee), std::pair(Joint::leftFoot, Joint::rightFoot)}) {
        EXPECT_TRUE(sameBits(j[index(left)].x(), -j[index(right)].x()));
        EXPECT_TRUE(sameBits(j[index(left)].y(), j[index(right)].y()));
        EXPECT_TRUE(sameBits(j[index(left)].z(), j[index(right)].z()));
    }
}

TEST(Mannequin, HasACageMirroredBitForBitAndWeldedInPlace) {
    const CageTemplate& cage = body().cageTemplate;
    for (std::size_t i = 0; i < cage.vertexCount(); ++i) {
        const Eigen::Vector3f& p = body().outerCage[i];
        const Eigen::Vector3f& q = body().outerCage[cage.mirrored[i]];
        EXPECT_TRUE(p.x() == -q.x() && sameBits(p.y(), q.y()) && sameBits(p.z(), q.z())) << i;
        EXPECT_EQ(p, body().outerCage[cage.weld[i]]) << i;
    }
}

TEST(Mannequin, WearsItsCageJustOutsideTheSkin) {
    for (const Eigen::Vector3f& p : body().outerCage) {
        EXPECT_NEAR(bodyModel().field.mirrored(p.cast<double>()), kCageDistance, 2e-4);
    }
}

TEST(Mannequin, HasItsSkinOnTheSurfaceWithNormalsOutwards) {
    const RestMesh& mesh = body().mesh;
    const Field field = [&](const Vec3& p) { return bodyModel().field.mirrored(p); };
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3 p = mesh.positions[v].cast<double>();
        ASSERT_NEAR(field(p), 0.0, 2e-4) << v;
        ASSERT_NEAR(mesh.normals[v].norm(), 1.0F, 1e-4F) << v;
        EXPECT_GT(mesh.normals[v].cast<double>().dot(gradient(field, p)), 0.0) << v << " at " << p.transpose();
    }
}

TEST(Mannequin, HasNoDegenerateOrFlippedTriangles) {
    const RestMesh& mesh = body().mesh;
    for (const Triangle& t : mesh.triangles) {
        const Eigen::Vector3f cross =
            (mesh.positions[t.b] - mesh.positions[t.a]).cross(mesh.positions[t.c] - mesh.positions[t.a]);
        EXPECT_GT(cross.norm(), 1e-8F);
        const Eigen::Vector3f normal = mesh.normals[t.a] + mesh.normals[t.b] + mesh.normals[t.c];
        EXPECT_GT(cross.dot(normal), 0.0F) << mesh.positions[t.a].transpose();
    }
}

TEST(Mannequin, HasWeightsThatSumToOneLargestFirst) {
    const auto check = [](const std::vector<SkinningWeights>& all) {
        for (const SkinningWeights& weights : all) {
            float sum = 0.0F;
            for (int i = 0; i < 4; ++i) {
                EXPECT_LT(weights.joint[i], kJointCount);
                EXPECT_GE(weights.weight[i], 0.0F);
                if (i > 0) {
                    EXPECT_LE(weights.weight[i], weights.weight[i - 1]);
                }
                sum += weights.weight[i];
            }
            EXPECT_NEAR(sum, 1.0F, 1e-5F);
        }
    };
    check(body().mesh.weights);
    check(body().cageWeights);
}

TEST(Mannequin, HasSymmetricWeights) {
    const auto onOtherSide = [](std::size_t joint) {
        std::string name(kJointNames[joint]);
        const bool left = name.starts_with("left_");
        if (!left && !name.starts_with("right_")) return joint;
        name = (left ? "right_" : "left_") + name.substr(name.find('_') + 1);
        return static_cast<std::size_t>(std::find(kJointNames.begin(), kJointNames.end(), name) - kJointNames.begin());
    };
    const auto share = [](const SkinningWeights& weights, std::size_t joint) {
        float sum = 0.0F;
        for (int i = 0; i < 4; ++i) {
            if (weights.joint[i] == joint) sum += weights.weight[i];
        }
        return sum;
    };
    const CageTemplate& cage = body().cageTemplate;
    for (std::size_t i = 0; i < cage.vertexCount(); ++i) {
        for (std::size_t j = 0; j < kJointCount; ++j) {
            EXPECT_NEAR(share(body().cageWeights[i], j), share(body().cageWeights[cage.mirrored[i]], onOtherSide(j)),
                        1e-6F);
        }
    }
}

TEST(Mannequin, MovesEachPartWithItsBone) {
    const auto main = [](BodyPart part) {
        switch (part) {
            case BodyPart::head:
                return Joint::head;
            case BodyPart::chest:
            case BodyPart::waist:
                return Joint::torso;
            case BodyPart::leftForearm:
                return Joint::leftElbow;
            case BodyPart::leftHand:
                return Joint::leftHand;
            case BodyPart::rightUpperArm:
                return Joint::rightShoulder;
            case BodyPart::leftThigh:
                return Joint::leftHip;
            case BodyPart::rightShin:
                return Joint::rightKnee;
            case BodyPart::rightFoot:
                return Joint::rightFoot;
            default:
                return Joint::neck;
        }
    };
    for (const BodyPart part :
         {BodyPart::head, BodyPart::chest, BodyPart::waist, BodyPart::leftForearm, BodyPart::leftHand,
          BodyPart::rightUpperArm, BodyPart::leftThigh, BodyPart::rightShin, BodyPart::rightFoot}) {
        int mine = 0;
        int all = 0;
        for (std::size_t i = 0; i < body().outerCage.size(); ++i) {
            if (body().cageTemplate.part[i] != part) continue;
            ++all;
            if (body().cageWeights[i].joint[0] == index(main(part))) ++mine;
        }
        EXPECT_GT(mine, all * 6 / 10) << static_cast<int>(part);
    }
}

TEST(Mannequin, IsTheSameEveryTime) {
    const BodyModel again = makeBody();
    EXPECT_EQ(again.body.outerCage, body().outerCage);
    EXPECT_EQ(again.body.mesh.positions, body().mesh.positions);
    EXPECT_EQ(again.body.mesh.normals, body().mesh.normals);
}

}  // namespace
}  // namespace cheval::fitting::bake

#include "fitting/animation/weight_transfer.h"

#include <numeric>

#include <gtest/gtest.h>

#include "tests/support/made_body.h"

using namespace cheval::fitting;

namespace {

float shareOf(const SkinningWeights& weights, std::initializer_list<Joint> joints) {
    float share = 0.0F;
    for (std::size_t k = 0; k < 4; ++k) {
        for (const Joint joint : joints) {
            if (weights.joint[k] == index(joint)) share += weights.weight[k];
        }
    }
    return share;
}

}  // namespace

TEST(WeightTransfer, SumsToOneWithNothingNegative) {
    const Body body = cheval::test::makeBody();
    const Garment garment = cheval::test::makeGarment(body);
    for (const SkinningWeights& weights : transferWeights(body.mesh, garment.mesh.positions, garment.mesh.normals)) {
        EXPECT_NEAR(std::accumulate(std::begin(weights.weight), std::end(weights.weight), 0.0F), 1.0F, 1e-5F);
        for (std::size_t k = 0; k < 4; ++k) {
            EXPECT_GE(weights.weight[k], 0.0F);
            EXPECT_LT(weights.joint[k], kJointCount);
        }
    }
}

TEST(WeightTransfer, GivesClothOnTheSkinTheSkinsOwnWeights) {
    const Body body = cheval::test::makeBody();
    const auto weights = transferWeights(body.mesh, body.mesh.positions, body.mesh.normals, {.neighbours = 1});
    ASSERT_EQ(weights.size(), body.mesh.positions.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
        for (const Joint joint : {Joint::torso, Joint::leftElbow, Joint::rightKnee}) {
            EXPECT_NEAR(shareOf(weights[i], {joint}), shareOf(body.mesh.weights[i], {joint}), 1e-4F);
        }
    }
}

TEST(WeightTransfer, TakesNothingFromTheOtherLeg) {
    const Body body = cheval::test::makeBody();
    const Garment trousers = cheval::test::makeGarment(body, {.gap = 0.02F, .thickness = 0.04F, .legs = true});
    const auto weights = transferWeights(body.mesh, trousers.mesh.positions, trousers.mesh.normals);
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (trousers.mesh.positions[i].y() > 0.80F) continue;
        const bool left = shareOf(trousers.mesh.weights[i], {Joint::leftHip, Joint::leftKnee, Joint::leftFoot}) > 0.5F;
        const float other = left ? shareOf(weights[i], {Joint::rightHip, Joint::rightKnee, Joint::rightFoot})
                                 : shareOf(weights[i], {Joint::leftHip, Joint::leftKnee, Joint::leftFoot});
        EXPECT_EQ(other, 0.0F);
    }
}

TEST(WeightTransfer, TakesNothingFromTheFlankForASleeve) {
    const Body body = cheval::test::makeBody();
    const Garment top = cheval::test::makeGarment(body, {.gap = 0.03F, .thickness = 0.05F});
    const auto weights = transferWeights(body.mesh, top.mesh.positions, top.mesh.normals);
    std::size_t sleeve = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const bool arm = shareOf(top.mesh.weights[i], {Joint::leftShoulder, Joint::leftElbow, Joint::rightShoulder,
                                                       Joint::rightElbow}) > 0.5F;
        // Below the armpit, where sleeve and flank stand apart.
        if (!arm || top.mesh.positions[i].y() > 1.30F) continue;
        ++sleeve;
        EXPECT_LT(shareOf(weights[i], {Joint::torso, Joint::neck}), 0.05F) << i;
    }
    EXPECT_GT(sleeve, 20U);
}

TEST(WeightTransfer, HasNothingToGiveWithoutABody) {
    const std::vector<Eigen::Vector3f> one = {Eigen::Vector3f::UnitX()};
    EXPECT_TRUE(transferWeights(RestMesh{}, one, one).empty());
}

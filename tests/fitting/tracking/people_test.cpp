#include "fitting/tracking/people.h"

#include <gtest/gtest.h>

namespace cheval::fitting::tracking {
namespace {

/// A rough surface on the floor, wholly in view, that hides what is behind it. Metres.
Component standing(float width, float height, float depth) {
    Component component;
    component.cells = 4000;
    component.area = 0.6F * width * height;
    component.lower = {-0.5F * width, 0.05F, 2.4F};
    component.upper = {0.5F * width, 0.05F + height, 2.4F + depth};
    component.centroid = 0.5F * (component.lower + component.upper);
    component.topWidth = 0.2F;
    component.topArea = 0.02F;
    component.before = 300;
    component.roughness = 0.05F;
    return component;
}

TEST(LooksLikePerson, AdultsChildrenAndWheelchairUsersDo) {
    EXPECT_TRUE(looksLikePerson(standing(0.5F, 1.75F, 0.3F), true));
    Component spread = standing(1.6F, 1.75F, 0.3F);
    spread.area = 0.7F;
    EXPECT_TRUE(looksLikePerson(spread, true)) << "arms spread";
    EXPECT_TRUE(looksLikePerson(standing(0.3F, 0.85F, 0.2F), true)) << "two years old";
    EXPECT_TRUE(looksLikePerson(standing(0.65F, 1.25F, 0.8F), true)) << "in a wheelchair";
}

TEST(LooksLikePerson, DogsDoNot) {
    EXPECT_FALSE(looksLikePerson(standing(0.95F, 0.70F, 0.25F), true)) << "from the side";
    EXPECT_FALSE(looksLikePerson(standing(0.70F, 0.80F, 0.70F), true)) << "askew";
    Component half = standing(0.45F, 0.90F, 0.25F);
    half.touchesLeft = true;
    EXPECT_FALSE(looksLikePerson(half, true)) << "half in view";
}

TEST(LooksLikePerson, SceneryDoesNot) {
    EXPECT_FALSE(looksLikePerson(standing(2.6F, 1.9F, 0.1F), true)) << "a wall";
    Component hangs = standing(0.5F, 1.0F, 0.2F);
    hangs.lower.y() = 0.6F;
    hangs.upper.y() = 1.6F;
    EXPECT_FALSE(looksLikePerson(hangs, true)) << "clothes on a rail";
    Component flat = standing(0.5F, 1.7F, 0.1F);
    flat.roughness = 0.002F;
    EXPECT_FALSE(looksLikePerson(flat, true)) << "a board";
}

}  // namespace
}  // namespace cheval::fitting::tracking

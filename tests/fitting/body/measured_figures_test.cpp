#include "tests/fitting/body/measured_figures.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/made_body.h"

namespace cheval::fitting::test {
namespace {

constexpr auto kChest = static_cast<std::size_t>(Dimension::chestGirth);

/// A visit whose chest is told as 1 m wide of `error` at every moment.
MeasuredVisit visitWith(float error, float uncertainty, MeasurementDoubt doubt = MeasurementDoubt::none) {
    MeasuredVisit visit;
    visit.faced = true;
    visit.truth.fill(1.0F);
    Measurements measured{.converged = true, .doubt = doubt};
    measured[Dimension::chestGirth] = {.value = 1.0F + error, .uncertainty = uncertainty, .valid = true};
    visit.facing.fill(measured);
    visit.facingCount = 8;
    visit.end = measured;
    visit.converged = 0.5;
    return visit;
}

TEST(MeasuredFigures, AddsUpErrors) {
    DimensionErrors errors;
    for (const float error : {0.01F, -0.03F, 0.02F, 0.04F})
        errors.add({.value = 1.0F + error, .uncertainty = 0.0155F, .valid = true}, 1.0);
    errors.add({}, 1.0);
    EXPECT_NEAR(errors.meanAbsolute(), 0.025, 1e-6);
    EXPECT_NEAR(errors.bias(), 0.01, 1e-6);
    EXPECT_NEAR(errors.deviation(), 0.029439, 1e-5);
    EXPECT_NEAR(errors.absoluteQuantile(1.0), 0.04, 1e-6);
    EXPECT_EQ(errors.told.hits, 4);
    EXPECT_EQ(errors.told.count, 5);
    EXPECT_EQ(errors.covered.hits, 3);
    EXPECT_EQ(errors.covered.count, 4);
}

TEST(MeasuredFigures, HaveNothingToSayOfNothing) {
    const DimensionErrors none;
    EXPECT_EQ(none.meanAbsolute(), 0.0);
    EXPECT_EQ(none.deviation(), 0.0);
    EXPECT_NE(tableOf(figuresOf({}, false)).find("converged: 0 of 0"), std::string::npos);
    EXPECT_EQ(nlohmann::json::parse(jsonOf({})).size(), 0U);
}

TEST(MeasuredFigures, ReadTheMomentThatIsAskedFor) {
    MeasuredVisit visit = visitWith(0.0F, 0.01F);
    for (std::size_t i = 0; i < kFacingReadings; ++i)
        visit.facing[i].frames = static_cast<int>(i);
    // A quarter of a second apart, the first after a quarter.
    EXPECT_EQ(at(visit, Moment::half)->frames, 1);
    EXPECT_EQ(at(visit, Moment::two)->frames, 7);
    // This one left before the third second and showed no side.
    EXPECT_EQ(at(visit, Moment::three), nullptr);
    EXPECT_EQ(at(visit, Moment::sides), nullptr);
    EXPECT_EQ(at(visit, Moment::end), &visit.end);
    visit.faced = false;
    EXPECT_EQ(at(visit, Moment::end), nullptr);
}

TEST(MeasuredFigures, LeaveDoubtsOutWhenAsked) {
    std::vector<MeasuredVisit> visits = {visitWith(0.01F, 0.01F),
                                         visitWith(0.09F, 0.01F, MeasurementDoubt::looseClothes)};
    visits.emplace_back();  // Never faced the glass.
    const auto end = static_cast<std::size_t>(Moment::end);
    EXPECT_EQ(figuresOf(visits, false).errors[end][kChest].told.hits, 2);
    const MeasuredFigures sure = figuresOf(visits, true);
    EXPECT_EQ(sure.errors[end][kChest].told.hits, 1);
    EXPECT_NEAR(sure.errors[end][kChest].meanAbsolute(), 0.01, 1e-6);
    EXPECT_EQ(sure.notFaced, 1);
    EXPECT_EQ(sure.converging.hits, 2);
    EXPECT_EQ(sure.doubts.at("loose clothes"), 1);
}

TEST(MeasuredFigures, GiveProgramsWhatPeopleRead) {
    const std::vector<MeasuredVisit> visits = {visitWith(0.02F, 0.015F)};
    const nlohmann::json written = nlohmann::json::parse(jsonOf(visits));
    ASSERT_EQ(written.size(), 1U);
    const nlohmann::json& visit = written[0];
    EXPECT_NEAR(visit["moments"]["end"]["values"]["chest_girth"][0].get<double>(), 1.02, 1e-5);
    EXPECT_NEAR(visit["moments"]["end"]["values"]["chest_girth"][1].get<double>(), 0.015, 1e-5);
    EXPECT_FALSE(visit["moments"]["end"]["values"].contains("waist_girth"));
    EXPECT_FALSE(visit["moments"].contains("3"));
    EXPECT_EQ(visit["facing"].size(), 8U);
    EXPECT_EQ(visit["facing"][1]["seconds"].get<double>(), 0.5);
    EXPECT_EQ(visit["converged"].get<double>(), 0.5);
}

TEST(MeasuredVisit, ReadsTheMirrorFromTheFirstStand) {
    const Body body = cheval::test::makeBody();
    const MeasuredVisit visit =
        measureVisit(body, {.seed = 7, .clothing = hal::sim::Clothing::tight, .facingSeconds = 1.01});
    ASSERT_TRUE(visit.faced);
    EXPECT_EQ(visit.facingCount, 4U);
    EXPECT_GT(visit.trackedFrames, 25U);
    EXPECT_FALSE(visit.sides.has_value());
    EXPECT_GT(visit.truth[kChest], 0.6F);
    EXPECT_FALSE(visit.child);
}

}  // namespace
}  // namespace cheval::fitting::test

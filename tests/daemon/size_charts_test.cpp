#include "daemon/size_charts.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/wardrobe.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

using fitting::Dimension;
using fitting::SizesFor;

constexpr std::string_view kWomen = R"(system = "EN 13402-3 letters"
region = "Europe"
for = "women"
source = "a test"
date = 2026-01-31
unit = "cm"
hip_girth = [{ size = "S", over = 90, to = 98 }, { size = "M", over = 98, to = 106 }]
)";

TEST(SizeCharts, areTheTablesInMetresByDimension) {
    const auto table = config::parseSizeTable(kWomen, "women.toml");
    ASSERT_TRUE(table.hasValue()) << table.error().message();
    const fitting::SizeChart chart = sizeChart(*table);
    EXPECT_EQ(chart.sizesFor, SizesFor::women);
    ASSERT_EQ(chart.sizes.size(), 2U);
    EXPECT_EQ(chart.sizes[1].view(), "M");
    EXPECT_THAT(chart.of(Dimension::hipGirth),
                testing::ElementsAre(testing::FloatEq(0.90F), testing::FloatEq(0.98F), testing::FloatEq(1.06F)));
    EXPECT_TRUE(chart.of(Dimension::chestGirth).empty());
}

TEST(SizeCharts, knowEveryDimensionThatATableMayHave) {
    for (const config::SizedDimension& dimension : config::kSizedDimensions)
        EXPECT_NE(std::find(fitting::kDimensionNames.begin(), fitting::kDimensionNames.end(), dimension.name),
                  fitting::kDimensionNames.end())
            << dimension.name;
}

TEST(SizeCharts, thatComeWithTheProgramAreThereForWomenAndMen) {
    const SizeCharts sizes = loadSizeCharts(shippedSizesFolder(), SizesFor::men);
    EXPECT_TRUE(sizes.refusals.empty());
    for (const std::optional<fitting::SizeChart>& chart : sizes.charts) {
        ASSERT_TRUE(chart.has_value());
        EXPECT_EQ(chart->sizes.size(), 6U);
        EXPECT_FALSE(chart->of(Dimension::chestGirth).empty());
    }
}

TEST(SizeCharts, sayWhenThereIsNoneForThoseWhoAreAskedFor) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.path() / "women.toml") << kWomen;
    EXPECT_TRUE(loadSizeCharts(folder.path().string(), SizesFor::women).refusals.empty());
    EXPECT_TRUE(loadSizeCharts(folder.path().string(), {}).refusals.empty());
    const SizeCharts sizes = loadSizeCharts(folder.path().string(), SizesFor::men);
    ASSERT_EQ(sizes.refusals.size(), 1U);
    EXPECT_THAT(sizes.refusals.front().message(), testing::HasSubstr("fitting.sizes"));
}

TEST(SizeCharts, ofAGarmentAreItsOwnThenThoseOfWhomItIsCutForThenTheShops) {
    Wardrobe wardrobe;
    for (const SizesFor people : {SizesFor::women, SizesFor::men})
        wardrobe.charts[static_cast<std::size_t>(people)] = fitting::SizeChart{.sizesFor = people};
    fitting::Garment garment;
    EXPECT_EQ(sizeChartOf(wardrobe, garment), nullptr);
    wardrobe.sizesFor = SizesFor::women;
    EXPECT_EQ(sizeChartOf(wardrobe, garment), &*wardrobe.charts[0]);
    garment.cutFor = SizesFor::men;
    EXPECT_EQ(sizeChartOf(wardrobe, garment), &*wardrobe.charts[1]);
    wardrobe.charts[1].reset();
    EXPECT_EQ(sizeChartOf(wardrobe, garment), nullptr) << "a man's garment is not sized as a woman's";
    garment.sizes = fitting::SizeChart{.sizesFor = SizesFor::men};
    EXPECT_EQ(sizeChartOf(wardrobe, garment), &*garment.sizes);
}

TEST(SizeCharts, thatAreRefusedLeaveTheWardrobeAsItIs) {
    const test::TemporaryFolder folder;
    std::string gap(kWomen);
    gap.replace(gap.find("over = 98"), 9, "over = 99");
    std::ofstream(folder.path() / "women.toml") << gap;
    const Wardrobe wardrobe = loadWardrobe({.folder = CHEVAL_ASSETS,
                                            .garments = {"tshirt"},
                                            .outfits = {"tshirt"},
                                            .startOutfit = "tshirt",
                                            .sizesFolder = folder.path().string(),
                                            .sizesFor = SizesFor::women});
    EXPECT_TRUE(wardrobe.body.has_value());
    EXPECT_EQ(wardrobe.outfits.size(), 1U);
    ASSERT_EQ(wardrobe.refusals.size(), 1U);
    EXPECT_EQ(wardrobe.refusals.front().line, 7);
    EXPECT_EQ(wardrobe.refusals.front().key, "hip_girth");
    EXPECT_EQ(sizeChartOf(wardrobe, wardrobe.garments.front()), nullptr);
}

}  // namespace
}  // namespace cheval::daemon

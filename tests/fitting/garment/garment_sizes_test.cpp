#include "fitting/garment/garment_sizes.h"

#include <ostream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/glb_builder.h"
#include "tests/support/made_body.h"

namespace cheval::fitting {
namespace {

/// The good chart of FORMAT.md, with a second dimension.
nlohmann::json goodSizes() {
    return nlohmann::json::parse(R"({
        "for": "men", "unit": "cm", "ease": {"chest_girth": 10, "waist_girth": 4.5},
        "chest_girth": [{"size": "S", "over": 92, "to": 100}, {"size": "M", "over": 100, "to": 108}],
        "waist_girth": [{"size": "S", "over": 80, "to": 88}, {"size": "M", "over": 88, "to": 96}]})");
}

Expected<Garment> load(const nlohmann::json& sizes) {
    static const Body body = test::makeBody();
    test::GlbBuilder glb = test::garmentGlb(test::makeGarment(body), body);
    if (!sizes.is_null()) glb.json["asset"]["extras"]["cheval"]["sizes"] = sizes;
    return parseGarment(glb.bytes(), "shop/top.glb", body.cageTemplate);
}

TEST(GarmentSizes, mayBeLeftToTheShop) {
    const auto garment = load(nullptr);
    ASSERT_TRUE(garment.hasValue()) << garment.error().message();
    EXPECT_FALSE(garment->cutFor.has_value());
    EXPECT_FALSE(garment->sizes.has_value());
}

TEST(GarmentSizes, maySayWhomItIsCutFor) {
    for (const auto& [word, people] : {std::pair("women", SizesFor::women), std::pair("men", SizesFor::men)}) {
        const auto garment = load(word);
        ASSERT_TRUE(garment.hasValue()) << garment.error().message();
        EXPECT_EQ(garment->cutFor, people);
        EXPECT_FALSE(garment->sizes.has_value());
    }
}

TEST(GarmentSizes, ofItsOwnAreThoseOfTheBodiesThatFitInWithEase) {
    const auto garment = load(goodSizes());
    ASSERT_TRUE(garment.hasValue()) << garment.error().message();
    EXPECT_EQ(garment->cutFor, SizesFor::men);
    ASSERT_TRUE(garment->sizes.has_value());
    const SizeChart& chart = *garment->sizes;
    EXPECT_EQ(chart.sizesFor, SizesFor::men);
    ASSERT_EQ(chart.sizes.size(), 2U);
    EXPECT_EQ(chart.sizes[0].view(), "S");
    EXPECT_EQ(chart.sizes[1].view(), "M");
    EXPECT_THAT(chart.of(Dimension::chestGirth),
                testing::ElementsAre(testing::FloatEq(0.82F), testing::FloatEq(0.90F), testing::FloatEq(0.98F)));
    EXPECT_THAT(chart.of(Dimension::waistGirth),
                testing::ElementsAre(testing::FloatEq(0.755F), testing::FloatEq(0.835F), testing::FloatEq(0.915F)));
    EXPECT_TRUE(chart.of(Dimension::hipGirth).empty());
}

TEST(GarmentSizes, mayBeSmallerThanTheBodyWhereClothStretches) {
    nlohmann::json sizes = goodSizes();
    sizes["ease"]["chest_girth"] = -6;
    const auto garment = load(sizes);
    ASSERT_TRUE(garment.hasValue()) << garment.error().message();
    EXPECT_FLOAT_EQ(garment->sizes->of(Dimension::chestGirth)[0], 0.98F);
}

struct BadSizes {
    const char* name;
    void (*spoil)(nlohmann::json&);
    const char* key;
    const char* cause;  ///< Part of it.
};

void PrintTo(const BadSizes& bad, std::ostream* stream) {
    *stream << bad.name;
}

class BadGarmentSizes : public testing::TestWithParam<BadSizes> {};

TEST_P(BadGarmentSizes, areRefusedWithFileAndKey) {
    nlohmann::json sizes = goodSizes();
    GetParam().spoil(sizes);
    const auto garment = load(sizes);
    ASSERT_FALSE(garment.hasValue());
    EXPECT_EQ(garment.error().code, ErrorCode::invalidInput);
    EXPECT_EQ(garment.error().file, "shop/top.glb");
    EXPECT_EQ(garment.error().key, "asset.extras.cheval.sizes" + std::string(GetParam().key));
    EXPECT_THAT(garment.error().cause, testing::HasSubstr(GetParam().cause));
    EXPECT_FALSE(garment.error().mend.empty());
    EXPECT_FALSE(garment.error().why.empty());
}

INSTANTIATE_TEST_SUITE_P(
    GarmentSizes, BadGarmentSizes,
    testing::Values(
        BadSizes{"children", [](nlohmann::json& s) { s = "children"; }, "", "neither"},
        BadSizes{"aNumber", [](nlohmann::json& s) { s = 38; }, "", "neither"},
        BadSizes{"aList", [](nlohmann::json& s) { s = nlohmann::json::array({"women"}); }, "", "neither"},
        BadSizes{"forNobody", [](nlohmann::json& s) { s.erase("for"); }, ".for", "neither"},
        BadSizes{"noUnit", [](nlohmann::json& s) { s.erase("unit"); }, ".unit", "missing or unknown"},
        BadSizes{"unknownUnit", [](nlohmann::json& s) { s["unit"] = "m"; }, ".unit", "missing or unknown"},
        BadSizes{"unknownDimension", [](nlohmann::json& s) { s["bust_girth"] = s["chest_girth"]; }, ".bust_girth",
                 "no such dimension"},
        BadSizes{"noDimension",
                 [](nlohmann::json& s) {
                     s.erase("chest_girth");
                     s.erase("waist_girth");
                 },
                 "", "no sizes"},
        BadSizes{"dimensionIsNumber", [](nlohmann::json& s) { s["chest_girth"] = 94; }, ".chest_girth", "no list"},
        BadSizes{"tooManySizes",
                 [](nlohmann::json& s) {
                     for (int i = 0; i < 20; ++i)
                         s["chest_girth"].push_back(s["chest_girth"][0]);
                 },
                 ".chest_girth", "no list"},
        BadSizes{"fewerInOneDimension", [](nlohmann::json& s) { s["waist_girth"].erase(1); }, ".waist_girth",
                 "as many as"},
        BadSizes{"otherSizeInOneDimension", [](nlohmann::json& s) { s["waist_girth"][1]["size"] = "L"; },
                 ".waist_girth[1]", "dimension before"},
        BadSizes{"noEase", [](nlohmann::json& s) { s["ease"].erase("waist_girth"); }, ".ease.waist_girth", "missing"},
        BadSizes{"easeAsText", [](nlohmann::json& s) { s["ease"]["chest_girth"] = "10"; }, ".ease.chest_girth",
                 "missing"},
        BadSizes{"easeOfATent", [](nlohmann::json& s) { s["ease"]["chest_girth"] = 100; }, ".ease.chest_girth",
                 "no ease"},
        BadSizes{"sizeTwice", [](nlohmann::json& s) { s["chest_girth"][1]["size"] = "S"; }, ".chest_girth[1]", "twice"},
        BadSizes{"noName", [](nlohmann::json& s) { s["chest_girth"][0].erase("size"); }, ".chest_girth[0]", "missing"},
        BadSizes{"longName", [](nlohmann::json& s) { s["chest_girth"][0]["size"] = "Mediumish"; }, ".chest_girth[0]",
                 "too long"},
        BadSizes{"nameThatIsNotPlain", [](nlohmann::json& s) { s["chest_girth"][0]["size"] = "\x1b[m"; },
                 ".chest_girth[0]", "not plain"},
        BadSizes{"bandIsNumber", [](nlohmann::json& s) { s["chest_girth"][0] = 94; }, ".chest_girth[0]", "missing"},
        BadSizes{"noEnd", [](nlohmann::json& s) { s["chest_girth"][0].erase("to"); }, ".chest_girth[0]", "missing"},
        BadSizes{"upsideDown",
                 [](nlohmann::json& s) { std::swap(s["chest_girth"][0]["over"], s["chest_girth"][0]["to"]); },
                 ".chest_girth[0]", "do not rise"},
        BadSizes{"otherUnit", [](nlohmann::json& s) { s["unit"] = "mm"; }, ".chest_girth[0]", "belong to no body"},
        BadSizes{"gap", [](nlohmann::json& s) { s["chest_girth"][1]["over"] = 101; }, ".chest_girth[1]", "gap"},
        BadSizes{"overlap", [](nlohmann::json& s) { s["chest_girth"][1]["over"] = 99; }, ".chest_girth[1]",
                 "overlaps"}),
    [](const auto& parameters) { return parameters.param.name; });

}  // namespace
}  // namespace cheval::fitting

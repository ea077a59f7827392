#include "config/nearest_name.h"

#include <array>
#include <string>

#include <gtest/gtest.h>

namespace cheval::config {
namespace {

TEST(EditDistance, countsTheFewestChanges) {
    EXPECT_EQ(editDistance("", ""), 0U);
    EXPECT_EQ(editDistance("", "abc"), 3U);
    EXPECT_EQ(editDistance("height", "heigth"), 1U);
    EXPECT_EQ(editDistance("kitten", "sitting"), 3U);
    EXPECT_EQ(editDistance("display", "dispaly"), 1U);
}

TEST(EditDistance, isTheSameBothWaysAndZeroForEquals) {
    const std::array<std::string, 5> texts = {"sensor", "sensr", "nsesor", "", "render.context"};
    for (const std::string& a : texts) {
        EXPECT_EQ(editDistance(a, a), 0U);
        for (const std::string& b : texts)
            EXPECT_EQ(editDistance(a, b), editDistance(b, a)) << a << ' ' << b;
    }
}

TEST(EditDistance, isBoundedForEndlessTexts) {
    EXPECT_EQ(editDistance(std::string(100'000, 'a'), std::string(100'000, 'b')), 64U);
}

TEST(NearestName, findsTheNearestAndTheFirstOfEquals) {
    const std::array<std::string_view, 3> names = {"tshirt", "trousers", "tshort"};
    EXPECT_EQ(nearestName("trouser", names), "trousers");
    EXPECT_EQ(nearestName("tsh_rt", names), "tshirt");
    EXPECT_EQ(nearestName("anything", std::span<const std::string_view>()), "");
}

}  // namespace
}  // namespace cheval::config

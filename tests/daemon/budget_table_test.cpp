#include "daemon/budget_table.h"

#include <chrono>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cheval::daemon {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

BudgetTable example() {
    return {.title = "One visit",
            .frames = 600,
            .visit = milliseconds(20'000),
            .tasks = {{.name = "tracking",
                       .budget = milliseconds(6),
                       .runs = 600,
                       .skips = 2,
                       .overruns = 3,
                       .minimum = microseconds(1500),
                       .mean = microseconds(2350),
                       .p99 = microseconds(5500),
                       .maximum = microseconds(7125)},
                      {.name = "layering", .budget = milliseconds(3)}}};
}

TEST(BudgetTable, MarkdownHasOneRowATaskInMilliseconds) {
    const std::string text = budgetMarkdown(example());
    EXPECT_EQ(text.find("# One visit: frame budget\n"), 0U) << text;
    EXPECT_NE(text.find("600 frames shown in 20.0 s."), std::string::npos) << text;
    EXPECT_NE(text.find("\n| tracking | 6.00 | 2.35 | 5.50 | 7.12 | 600 | 3 | 2 |\n"), std::string::npos) << text;
}

TEST(BudgetTable, ATaskThatNeverRanHasNoTimes) {
    EXPECT_NE(budgetMarkdown(example()).find("\n| layering | 3.00 | – | – | – | 0 | 0 | 0 |\n"), std::string::npos);
    EXPECT_TRUE(nlohmann::json::parse(budgetJson(example()))["tasks"][1]["mean_ms"].is_null());
}

TEST(BudgetTable, JsonSaysTheSame) {
    const auto root = nlohmann::json::parse(budgetJson(example()));
    EXPECT_EQ(root["frames"], 600);
    EXPECT_DOUBLE_EQ(root["visit_s"], 20.0);
    ASSERT_EQ(root["tasks"].size(), 2U);
    const auto& tracking = root["tasks"][0];
    EXPECT_EQ(tracking["name"], "tracking");
    EXPECT_DOUBLE_EQ(tracking["budget_ms"], 6.0);
    EXPECT_DOUBLE_EQ(tracking["min_ms"], 1.5);
    EXPECT_DOUBLE_EQ(tracking["mean_ms"], 2.35);
    EXPECT_DOUBLE_EQ(tracking["p99_ms"], 5.5);
    EXPECT_DOUBLE_EQ(tracking["max_ms"], 7.125);
    EXPECT_EQ(tracking["overruns"], 3);
    EXPECT_EQ(tracking["skips"], 2);
}

TEST(BudgetTable, ATitleThatIsNotUtf8IsStillJson) {
    BudgetTable table = example();
    table.title = "caf\xC3";
    EXPECT_TRUE(nlohmann::json::accept(budgetJson(table)));
}

}  // namespace
}  // namespace cheval::daemon

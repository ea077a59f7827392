#include "daemon/status_report.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cheval::daemon {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::Not;

MirrorReport report() {
    return {.version = "1.2.3",
            .uptimeSeconds = 7500,
            .state = "wearing",
            .outfit = "tshirt",
            .view = "avatar",
            .outfits = {{.id = "tshirt", .name = "T-shirt"}},
            .framesPerSecond = 29.94,
            .visits = 3,
            .frames = 100,
            .pictures = 101,
            .renderer = "a renderer",
            .overall = "at fault",
            .health = {{.part = "sensor", .state = "ok", .age = seconds(1)},
                       {.part = "buttons",
                        .state = "at fault",
                        .reason = "the chip is gone",
                        .since = std::chrono::system_clock::time_point(seconds(1'000'000'000)),
                        .age = minutes(12)}},
            .tasks = {{.name = "draw",
                       .budget = milliseconds(18),
                       .mean = milliseconds(9),
                       .p99 = milliseconds(12),
                       .maximum = milliseconds(13),
                       .runs = 100,
                       .overruns = 4,
                       .skips = 5},
                      {.name = "layering", .budget = milliseconds(3)}},
            .recovery = {{"reopen device", 2}}};
}

TEST(StatusForPeople, SaysEachThingOnALineOfItsOwn) {
    const std::string text = statusForPeople(report(), false);
    EXPECT_THAT(text, HasSubstr("Cheval 1.2.3, running for 2 h 5 min: at fault\n"));
    EXPECT_THAT(text, HasSubstr("  now       wearing, T-shirt (tshirt), on the mannequin\n"));
    EXPECT_THAT(text, HasSubstr("  pictures  29.9 a second, all details\n"));
    EXPECT_THAT(text, HasSubstr("  sensor    ok                just now\n"));
    EXPECT_THAT(text, HasSubstr("  buttons   at fault          12 min ago      the chip is gone\n"));
    EXPECT_THAT(text,
                HasSubstr("  draw                     18.0 ms   9.00 ms  12.00 ms         4         5     100\n"));
    EXPECT_THAT(text,
                HasSubstr("  layering                  3.0 ms         -         -         0         0       0\n"));
    EXPECT_THAT(text, HasSubstr("  reopen device                  2\n"));
    EXPECT_THAT(text, Not(HasSubstr("\033"))) << "colour is for terminals";
}

TEST(StatusForPeople, ColoursTellAFaultFromWhatIsAbsentByDesign) {
    MirrorReport absent = report();
    absent.overall = "ok";
    absent.health[1].state = "absent by design";
    const std::string fault = statusForPeople(report(), true);
    const std::string fine = statusForPeople(absent, true);
    EXPECT_THAT(fault, HasSubstr("\033[1;31mat fault          \033[0m"));
    EXPECT_THAT(fine, Not(HasSubstr("\033[1;31m")));
    EXPECT_THAT(fine, HasSubstr("\033[2mabsent by design  \033[0m"));
}

TEST(StatusForPeople, AgesAreAsLongAsPeopleWantToKnow) {
    EXPECT_EQ(ageInWords(milliseconds(500)), "just now");
    EXPECT_EQ(ageInWords(seconds(12)), "12 s");
    EXPECT_EQ(ageInWords(seconds(150)), "2 min");
    EXPECT_EQ(ageInWords(hours(3) + minutes(5)), "3 h 5 min");
    EXPECT_EQ(ageInWords(hours(24 * 40)), "40 days");
}

TEST(StatusAsJson, HasTheKeysThatItsDocumentationPromises) {
    const nlohmann::json root = nlohmann::json::parse(statusAsJson(report()));
    for (const char* key : {"version", "uptime_s", "state", "outfit", "view", "outfits", "frames_per_second", "degrade",
                            "visits", "frames", "pictures", "renderer", "overall", "health", "tasks", "recovery"})
        EXPECT_TRUE(root.contains(key)) << key;
    EXPECT_EQ(root.size(), 16U) << "a new key is added to the documentation and here";
    EXPECT_EQ(root["health"][1]["since"], "2001-09-09T01:46:40Z");
    EXPECT_EQ(root["health"][1]["for_s"], 720.0);
    EXPECT_EQ(root["tasks"][0]["p99_ms"], 12.0);
    EXPECT_EQ(root["tasks"][0]["overruns"], 4);
    EXPECT_TRUE(root["tasks"][1]["mean_ms"].is_null());
    EXPECT_EQ(root["recovery"]["reopen device"], 2);
    EXPECT_EQ(root["outfits"][0]["id"], "tshirt");
}

}  // namespace
}  // namespace cheval::daemon

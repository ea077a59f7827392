// Recordings that are not ours, through the whole pipeline.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "config/settings_table.h"
#include "daemon/replay_run.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

namespace fs = std::filesystem;

class ReplayRecordings : public testing::Test {
  protected:
    [[nodiscard]] static Expected<ReplayReport> replay(const std::string& source, const fs::path& tracks) {
        config::Settings settings = config::defaultSettings();
        settings.wardrobe.folder = CHEVAL_ASSETS;
        return replayRecording(settings,
                               {.source = std::string(CHEVAL_DATA) + "/" + source, .tracks = tracks.string()});
    }
    [[nodiscard]] static std::string read(const fs::path& path) {
        std::stringstream text;
        text << std::ifstream(path).rdbuf();
        return text.str();
    }

    test::TemporaryFolder temporary_;
    fs::path folder_ = temporary_.path();
};

TEST_F(ReplayRecordings, theSameReplayTwiceGivesTheSameBytes) {
    const Expected<ReplayReport> first = replay("shoppers/seq01", folder_ / "a.jsonl");
    ASSERT_TRUE(first) << first.error().message();
    ASSERT_TRUE(replay("shoppers/seq01", folder_ / "b.jsonl"));
    EXPECT_EQ(first->frames, 105U);
    EXPECT_GT(first->dressed, 80U);
    const std::string tracks = read(folder_ / "a.jsonl");
    EXPECT_GT(tracks.size(), 10'000U);
    EXPECT_EQ(tracks, read(folder_ / "b.jsonl"));
}

TEST_F(ReplayRecordings, everyRealStillIsDressed) {
    const Expected<ReplayReport> report = replay("real-upper-body", folder_ / "t.jsonl");
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->frames, 8U);
    EXPECT_EQ(report->dressed, 8U);
}

}  // namespace
}  // namespace cheval::daemon

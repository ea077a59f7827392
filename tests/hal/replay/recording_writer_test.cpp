#include "hal/replay/recording_writer.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <limits>
#include <map>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hal/png/png.h"
#include "hal/replay/replay_camera.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/temporary_folder.h"

namespace cheval::hal {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr Duration kLong = std::chrono::seconds(100);
constexpr int kWidth = 32;
constexpr int kHeight = 24;

/// Pixels that no coder makes small.
std::uint16_t noise(std::uint64_t number, std::size_t pixel) {
    std::uint64_t x = number * 0x9e3779b97f4a7c15ULL + pixel + 1;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return static_cast<std::uint16_t>(x >> 40U);
}

class RecordingWriterTest : public testing::Test {
  protected:
    [[nodiscard]] RecordingWriterOptions options() const {
        return {.folder = folder_.string(),
                .sensor = {.intrinsics = {.width = kWidth,
                                          .height = kHeight,
                                          .fx = 28.525F,
                                          .fy = 28.475F,
                                          .cx = 15.25F,
                                          .cy = 11.75F},
                           .framesPerSecond = 15.0,
                           .mount = {.heightMm = 1834.5F, .tiltDeg = -7.25F, .rollDeg = 90.5F, .known = true}},
                .leaveFreeBytes = 0};
    }

    std::unique_ptr<RecordingWriter> create(const RecordingWriterOptions& options) {
        auto writer = RecordingWriter::create(options);
        if (writer) return std::move(*writer);
        ADD_FAILURE() << writer.error().message();
        return nullptr;
    }

    /// The same picture for the same number, and another for every other.
    DepthFrame frame(std::uint64_t number) {
        for (std::size_t i = 0; i < depth_.pixels.size(); ++i) {
            depth_.pixels[i] = noise(number, i);
            colour_.pixels[i] = {static_cast<std::uint8_t>(noise(number, i) >> 8U), static_cast<std::uint8_t>(number),
                                 7};
        }
        return {.sequence = number, .depth = std::as_const(depth_).view(), .colour = std::as_const(colour_).view()};
    }

    /// What a replay of the folder delivers: pixels by sequence number, counted from the first.
    struct Played {
        std::map<std::uint64_t, std::vector<std::uint16_t>> depth;
        std::map<std::uint64_t, std::vector<Rgb8>> colour;
        CameraInfo info;
        std::vector<std::string> warnings;
    };
    Played play() const {
        Played played;
        VirtualClock clock;
        auto camera = makeReplayCamera({.folder = folder_.string()}, clock);
        if (!camera || !(*camera)->open()) {
            ADD_FAILURE() << "it cannot be played";
            return played;
        }
        played.info = (*camera)->info();
        DepthFrame frame;
        while ((*camera)->waitFrame(kLong, frame) == FrameStatus::frame) {
            Image<std::uint16_t> depth;
            copyInto(frame.depth, depth);
            played.depth[frame.sequence] = depth.pixels;
            if (frame.colour.empty()) continue;
            Image<Rgb8> colour;
            copyInto(frame.colour, colour);
            played.colour[frame.sequence] = colour.pixels;
        }
        played.warnings = (*camera)->warnings();
        return played;
    }

    [[nodiscard]] std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(folder_))
            all.push_back(entry.path().filename().string());
        std::sort(all.begin(), all.end());
        return all;
    }

    test::TemporaryFolder temporary_;
    fs::path folder_ = temporary_.path() / "visit" / "one";
    Image<std::uint16_t> depth_{kWidth, kHeight};
    Image<Rgb8> colour_{kWidth, kHeight};
};

TEST_F(RecordingWriterTest, WhatIsRecordedIsPlayedBackToTheLastBit) {
    const auto writer = create(options());
    ASSERT_NE(writer, nullptr);
    for (std::uint64_t number = 0; number < 40; ++number)
        ASSERT_TRUE(writer->add(number, frame(number), kLong));
    ASSERT_TRUE(writer->finish());
    EXPECT_EQ(writer->counts().written, 40U);
    EXPECT_EQ(writer->counts().dropped, 0U);

    const Played played = play();
    ASSERT_THAT(played.depth, SizeIs(40));
    for (const auto& [number, pixels] : played.depth) {
        frame(number);
        EXPECT_EQ(pixels, depth_.pixels) << number;
    }
    const SensorDescription sensor = options().sensor;
    EXPECT_EQ(played.info.intrinsics.fx, sensor.intrinsics.fx);
    EXPECT_EQ(played.info.intrinsics.fy, sensor.intrinsics.fy);
    EXPECT_EQ(played.info.intrinsics.cx, sensor.intrinsics.cx);
    EXPECT_EQ(played.info.intrinsics.cy, sensor.intrinsics.cy);
    EXPECT_EQ(played.info.framesPerSecond, 15.0);
    EXPECT_TRUE(played.info.mount.known);
    EXPECT_EQ(played.info.mount.heightMm, sensor.mount.heightMm);
    EXPECT_EQ(played.info.mount.tiltDeg, sensor.mount.tiltDeg);
    EXPECT_EQ(played.info.mount.rollDeg, sensor.mount.rollDeg);
    EXPECT_THAT(played.warnings, IsEmpty());
}

TEST_F(RecordingWriterTest, ALostFrameIsAGapInTime) {
    const auto writer = create(options());
    ASSERT_NE(writer, nullptr);
    for (const std::uint64_t number : {99U, 100U, 103U, 104U})
        ASSERT_TRUE(writer->add(number, frame(number), kLong));
    ASSERT_TRUE(writer->finish());
    EXPECT_THAT(names(), ElementsAre("depth-000099.png", "depth-000100.png", "depth-000103.png", "depth-000104.png",
                                     "sensor.json"));
    const Played played = play();
    std::vector<std::uint64_t> sequence;
    for (const auto& [number, pixels] : played.depth)
        sequence.push_back(number);
    EXPECT_THAT(sequence, ElementsAre(0, 1, 4, 5));
    EXPECT_THAT(played.warnings, ElementsAre(HasSubstr("2 picture(s) missing")));
}

TEST_F(RecordingWriterTest, ColourIsWrittenOnlyWhenItIsAskedFor) {
    {
        const auto writer = create(options());
        ASSERT_NE(writer, nullptr);
        ASSERT_TRUE(writer->add(0, frame(0)));
        ASSERT_TRUE(writer->finish());
        EXPECT_THAT(names(), ElementsAre("depth-000000.png", "sensor.json"));
        EXPECT_FALSE(play().info.colour);
    }
    folder_ = temporary_.path() / "with colour";
    RecordingWriterOptions withColour = options();
    withColour.colour = true;
    const auto writer = create(withColour);
    ASSERT_NE(writer, nullptr);
    ASSERT_TRUE(writer->add(0, frame(0)));
    ASSERT_TRUE(writer->finish());
    EXPECT_THAT(names(), ElementsAre("color-000000.png", "depth-000000.png", "sensor.json"));
    const Played played = play();
    ASSERT_THAT(played.colour, SizeIs(1));
    frame(0);
    EXPECT_EQ(played.colour.at(0), colour_.pixels);
    EXPECT_EQ(played.depth.at(0), depth_.pixels);
}

TEST_F(RecordingWriterTest, WhatTheDiskCannotTakeInTimeIsDroppedAndLeavesItsNumber) {
    RecordingWriterOptions two = options();
    two.slots = 2;
    const auto writer = create(two);
    ASSERT_NE(writer, nullptr);
    // A disk that stands still: the thread's first file is a pipe that nobody reads yet.
    const std::string pipe = (folder_ / "depth-000000.png.part").string();
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_TRUE(writer->add(0, frame(0)));
    EXPECT_TRUE(writer->add(1, frame(1)));
    EXPECT_FALSE(writer->add(2, frame(2)));
    EXPECT_FALSE(writer->add(3, frame(3), std::chrono::milliseconds(5)));
    EXPECT_EQ(writer->counts().dropped, 2U);
    EXPECT_EQ(writer->counts().written, 0U);

    const int reader = ::open(pipe.c_str(), O_RDONLY | O_CLOEXEC);  // NOLINT(cppcoreguidelines-pro-type-vararg)
    ASSERT_GE(reader, 0);
    EXPECT_TRUE(writer->add(4, frame(4), kLong));
    ASSERT_TRUE(writer->finish());
    ::close(reader);
    EXPECT_EQ(writer->counts().written, 3U);
    EXPECT_EQ(writer->counts().dropped, 2U);
    EXPECT_THAT(names(), ElementsAre("depth-000000.png", "depth-000001.png", "depth-000004.png", "sensor.json"));
}

TEST_F(RecordingWriterTest, AddingTakesNoMemory) {
    const auto writer = create(options());
    ASSERT_NE(writer, nullptr);
    const DepthFrame one = frame(1);
    const test::AllocationCounter counter;
    for (std::uint64_t number = 0; number < 40; ++number)
        (void)writer->add(number, one, kLong);
    EXPECT_EQ(counter.count(), 0U);
    ASSERT_TRUE(writer->finish());
}

TEST_F(RecordingWriterTest, ANumberThatDoesNotRiseIsDropped) {
    const auto writer = create(options());
    ASSERT_NE(writer, nullptr);
    EXPECT_TRUE(writer->add(7, frame(7), kLong));
    EXPECT_FALSE(writer->add(7, frame(8), kLong));
    EXPECT_FALSE(writer->add(6, frame(6), kLong));
    EXPECT_TRUE(writer->add(8, frame(8), kLong));
    ASSERT_TRUE(writer->finish());
    EXPECT_FALSE(writer->add(9, frame(9)));
    EXPECT_EQ(writer->counts().written, 2U);
    EXPECT_EQ(writer->counts().dropped, 3U);
}

TEST_F(RecordingWriterTest, AFolderWithAnythingInItIsRefusedAndLeftAlone) {
    fs::create_directories(folder_);
    ASSERT_TRUE(writeBytes((folder_ / "depth-000003.png").string(), {}));
    const auto writer = RecordingWriter::create(options());
    ASSERT_FALSE(writer);
    EXPECT_EQ(writer.error().code, ErrorCode::invalidInput);
    EXPECT_THAT(writer.error().cause, HasSubstr("not empty"));
    EXPECT_EQ(writer.error().file, folder_.string());
    EXPECT_THAT(names(), ElementsAre("depth-000003.png"));
}

TEST_F(RecordingWriterTest, AFileInPlaceOfTheFolderIsRefused) {
    fs::create_directories(folder_.parent_path());
    ASSERT_TRUE(writeBytes(folder_.string(), {}));
    const auto writer = RecordingWriter::create(options());
    ASSERT_FALSE(writer);
    EXPECT_FALSE(writer.error().mend.empty());
}

TEST_F(RecordingWriterTest, AFolderThatMayNotBeWrittenIsRefused) {
    fs::create_directories(folder_);
    fs::permissions(temporary_.path(), fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
    fs::permissions(folder_,
                    fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
    // Root may write anywhere, so it steps down for a moment.
    constexpr uid_t kNobody = 65534;
    const bool root = ::geteuid() == 0;
    if (root) {
        ASSERT_EQ(::seteuid(kNobody), 0);
    }
    const auto writer = RecordingWriter::create(options());
    if (root) {
        ASSERT_EQ(::seteuid(0), 0);
    }
    fs::permissions(folder_, fs::perms::owner_all);
    ASSERT_FALSE(writer);
    EXPECT_EQ(writer.error().code, ErrorCode::resource);
    EXPECT_THAT(writer.error().cause, HasSubstr("ermission"));
    EXPECT_FALSE(writer.error().mend.empty());
    EXPECT_THAT(names(), IsEmpty());
}

TEST_F(RecordingWriterTest, ADiskThatIsNearlyFullIsLeftToTheMirror) {
    RecordingWriterOptions greedy = options();
    greedy.leaveFreeBytes = std::numeric_limits<std::uint64_t>::max();
    const auto writer = RecordingWriter::create(greedy);
    ASSERT_FALSE(writer);
    EXPECT_EQ(writer.error().code, ErrorCode::resource);
    EXPECT_THAT(writer.error().cause, HasSubstr("MiB are left"));
    EXPECT_FALSE(writer.error().mend.empty());
}

TEST_F(RecordingWriterTest, WhenTheDiskFillsUpWhatWasWrittenCanBePlayed) {
    const auto writer = create(options());
    ASSERT_NE(writer, nullptr);
    const Image<std::uint16_t> wall(kWidth, kHeight, 3000);
    const DepthFrame small{.depth = wall.view()};
    ASSERT_TRUE(writer->add(0, small, kLong));
    ASSERT_TRUE(writer->add(1, small, kLong));
    // A disk with room for plain walls alone: longer files end halfway through.
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    rlimit tight = before;
    tight.rlim_cur = 700;
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
    EXPECT_TRUE(writer->add(2, frame(2), kLong));
    const Expected<void> finished = writer->finish();
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, handler);

    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().code, ErrorCode::resource);
    EXPECT_EQ(finished.error().file, (folder_ / "depth-000002.png").string());
    ASSERT_TRUE(writer->fault().has_value());
    EXPECT_EQ(writer->counts().written, 2U);
    EXPECT_EQ(writer->counts().dropped, 1U);
    EXPECT_THAT(names(), ElementsAre("depth-000000.png", "depth-000001.png", "sensor.json"));
    const Played played = play();
    ASSERT_THAT(played.depth, SizeIs(2));
    EXPECT_EQ(played.depth.at(1), wall.pixels);
}

TEST_F(RecordingWriterTest, AFrameOfAnotherSizeEndsTheRecording) {
    const auto writer = create(options());
    ASSERT_NE(writer, nullptr);
    ASSERT_TRUE(writer->add(0, frame(0), kLong));
    const Image<std::uint16_t> other(kWidth * 2, kHeight);
    EXPECT_FALSE(writer->add(1, {.depth = other.view()}, kLong));
    EXPECT_FALSE(writer->add(2, frame(2), kLong));
    const Expected<void> finished = writer->finish();
    ASSERT_FALSE(finished);
    EXPECT_THAT(finished.error().cause, HasSubstr("size"));
}

TEST_F(RecordingWriterTest, ASensorThatReplayWouldRefuseIsNotRecorded) {
    RecordingWriterOptions odd = options();
    odd.sensor.intrinsics.fx = 0.0F;
    const auto writer = RecordingWriter::create(odd);
    ASSERT_FALSE(writer);
    EXPECT_EQ(writer.error().key, "fx");
    EXPECT_FALSE(fs::exists(folder_));
}

}  // namespace
}  // namespace cheval::hal

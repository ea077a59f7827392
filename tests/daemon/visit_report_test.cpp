#include "daemon/visit_report.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <webp/demux.h>

#include "daemon/scheduler.h"
#include "hal/png/png.h"
#include "tests/support/temporary_folder.h"

namespace cheval::daemon {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

class Report : public ::testing::Test {
  protected:
    void SetUp() override {
        options_.folder = root_ / "demo" / "report";
        options_.pictureWidth = 60;
    }

    /// A portrait frame whose red says which one it is.
    static hal::Image<hal::Rgba8> frame(int index, int width = 180, int height = 320) {
        hal::Image<hal::Rgba8> image(width, height);
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                image.view().at(x, y) = {static_cast<std::uint8_t>(index % 256),
                                         static_cast<std::uint8_t>(y * 255 / height),
                                         static_cast<std::uint8_t>(x * 255 / width), 255};
            }
        }
        return image;
    }
    /// Runs a visit of so many frames at 30 Hz, each brighter by `step`, and writes its report.
    Expected<void> visit(int frames, int step = 1) {
        auto report = VisitReport::create(options_);
        if (!report) return report.error();
        for (int i = 0; i < frames; ++i) {
            const auto shown = frame(i * step);
            (*report)->addFrame(shown.view(), hal::TimePoint(milliseconds(2000) + i * hal::fromSeconds(1.0 / 30.0)),
                                "wearing");
        }
        return (*report)->finish({{.name = "tracking", .budget = milliseconds(6)}});
    }
    [[nodiscard]] hal::Image<hal::Rgba8> sheet() const {
        hal::Image<hal::Rgba8> image;
        const auto read = hal::readPng((options_.folder / VisitReport::kSheetFile).string(), image);
        EXPECT_TRUE(read.hasValue());
        return image;
    }
    WebPBitstreamFeatures features(int* pictures) const {
        std::vector<std::byte> bytes;
        EXPECT_TRUE(
            hal::readBytes((options_.folder / VisitReport::kAnimationFile).string(), 1U << 24U, bytes).hasValue());
        const WebPData data{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
        const std::unique_ptr<WebPDemuxer, void (*)(WebPDemuxer*)> demuxer(WebPDemux(&data), WebPDemuxDelete);
        EXPECT_NE(demuxer, nullptr);
        *pictures = demuxer ? static_cast<int>(WebPDemuxGetI(demuxer.get(), WEBP_FF_FRAME_COUNT)) : 0;
        WebPBitstreamFeatures result{};
        WebPGetFeatures(data.bytes, data.size, &result);
        return result;
    }

    test::TemporaryFolder temporary_;
    fs::path root_ = temporary_.path();
    VisitReportOptions options_;
};

TEST_F(Report, LeavesFourFilesInAFolderThatItMakes) {
    const auto written = visit(90);
    ASSERT_TRUE(written.hasValue()) << written.error().message();
    for (const auto name :
         {VisitReport::kSheetFile, VisitReport::kAnimationFile, VisitReport::kTableFile, VisitReport::kTableDataFile}) {
        EXPECT_GT(fs::file_size(options_.folder / name), 40U) << name;
    }
}

TEST_F(Report, TheAnimationHasTenPicturesASecondAtTheWidthAskedFor) {
    ASSERT_TRUE(visit(91, 7).hasValue());
    int pictures = 0;
    const WebPBitstreamFeatures picture = features(&pictures);
    EXPECT_EQ(pictures, 31);
    EXPECT_EQ(picture.width, 60);
    EXPECT_EQ(picture.height, 107);
    EXPECT_NE(picture.has_animation, 0);
}

TEST_F(Report, ALongVisitStaysWithinThePicturesAskedFor) {
    options_.animationPictures = 20;
    ASSERT_TRUE(visit(600, 7).hasValue());
    int pictures = 0;
    features(&pictures);
    EXPECT_LT(pictures, 20);
    EXPECT_GE(pictures, 10);
}

TEST_F(Report, TheSheetShowsTheVisitFromItsFirstPictureToItsEnd) {
    options_.sheetPictures = 4;
    options_.sheetColumns = 4;
    ASSERT_TRUE(visit(240).hasValue());
    const hal::Image<hal::Rgba8> image = sheet();
    // Red counts frames: the darkest and the brightest that pictures show. The paper is brighter, so look for the green
    // and blue of a frame's middle, 127 each.
    int least = 255;
    int most = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const hal::Rgba8 pixel = image.view().at(x, y);
            if (std::abs(pixel.g - 127) < 3 && std::abs(pixel.b - 127) < 3 && std::abs(pixel.r - 127) > 3) {
                least = std::min<int>(least, pixel.r);
                most = std::max<int>(most, pixel.r);
            }
        }
    }
    EXPECT_EQ(least, 0);
    EXPECT_GT(most, 200);
    EXPECT_LT(most, 240);
}

TEST_F(Report, ShrinksWithoutChangingColours) {
    options_.sheetPictures = 1;
    auto report = VisitReport::create(options_);
    ASSERT_TRUE(report.hasValue());
    const hal::Image<hal::Rgba8> plain(181, 319, {13, 77, 201, 0});
    (*report)->addFrame(plain.view(), hal::TimePoint{}, "");
    ASSERT_TRUE((*report)->finish({}).hasValue());
    const hal::Image<hal::Rgba8> image = sheet();
    int same = 0;
    for (const hal::Rgba8 pixel : image.pixels) {
        same += pixel == hal::Rgba8{13, 77, 201, 255} ? 1 : 0;
    }
    EXPECT_EQ(same, 60 * 106);
}

TEST_F(Report, LeavesOutFramesThatAreEmptyOldOrTooSmall) {
    auto report = VisitReport::create(options_);
    ASSERT_TRUE(report.hasValue());
    const auto large = frame(10);
    const auto other = frame(200);
    const auto small = frame(20, 30, 50);
    (*report)->addFrame({}, hal::TimePoint(milliseconds(0)), "");
    (*report)->addFrame(large.view(), hal::TimePoint(milliseconds(1000)), "");
    (*report)->addFrame(large.view(), hal::TimePoint(milliseconds(500)), "");
    (*report)->addFrame(small.view(), hal::TimePoint(milliseconds(1500)), "");
    (*report)->addFrame(other.view(), hal::TimePoint(milliseconds(2000)), "");
    ASSERT_TRUE((*report)->finish({}).hasValue());
    int pictures = 0;
    features(&pictures);
    EXPECT_EQ(pictures, 2);
}

TEST_F(Report, AVisitWithoutAPictureIsAnErrorThatSaysSo) {
    const auto written = visit(0);
    ASSERT_FALSE(written.hasValue());
    EXPECT_EQ(written.error().code, ErrorCode::invalidInput);
}

TEST_F(Report, RefusesOptionsOutOfTheirRangeByName) {
    options_.animationRate = std::nan("");
    EXPECT_EQ(VisitReport::create(options_).error().key, "animationRate");
    options_ = {.folder = root_, .pictureWidth = 5000};
    EXPECT_EQ(VisitReport::create(options_).error().key, "pictureWidth");
    options_ = {.folder = root_, .sheetPictures = 0};
    EXPECT_EQ(VisitReport::create(options_).error().key, "sheetPictures");
}

TEST_F(Report, AFolderThatCannotBeMadeIsAnErrorThatNamesIt) {
    ASSERT_TRUE(hal::writeBytes((root_ / "file").string(), {}).hasValue());
    options_.folder = root_ / "file" / "below";
    const auto report = VisitReport::create(options_);
    ASSERT_FALSE(report.hasValue());
    EXPECT_EQ(report.error().file, options_.folder.string());
}

}  // namespace
}  // namespace cheval::daemon

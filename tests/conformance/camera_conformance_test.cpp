// What every depth camera does, whatever it is.
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "tests/conformance/camera_back_ends.h"
#include "tests/conformance/process_use.h"

namespace cheval::test {
namespace {

using hal::DepthCamera;
using hal::DepthFrame;
using hal::Duration;
using hal::FrameStatus;
using hal::SteadyClock;
using hal::TimePoint;
using hal::VirtualClock;

constexpr Duration kLong = std::chrono::hours(1);
constexpr int kFrames = 20;

// A number that differs when any pixel does (FNV-1a).
template <typename Pixel>
void addToHash(std::uint64_t& hash, hal::ImageView<const Pixel> picture) {
    for (int y = 0; y < picture.height; ++y) {
        const auto* bytes = reinterpret_cast<const unsigned char*>(picture.row(y));
        for (std::size_t i = 0; i < static_cast<std::size_t>(picture.width) * sizeof(Pixel); ++i) {
            hash = (hash ^ bytes[i]) * 1099511628211ULL;
        }
    }
}

std::uint64_t hashOf(const DepthFrame& frame) {
    std::uint64_t hash = 14695981039346656037ULL;
    addToHash(hash, frame.depth);
    addToHash(hash, frame.colour);
    return hash;
}

struct Seen {
    std::uint64_t sequence = 0;
    std::uint64_t sourceIndex = 0;
    TimePoint time{};
    bool restart = false;
    bool lastOfStill = false;
    std::uint64_t hash = 0;
    friend bool operator==(const Seen&, const Seen&) = default;
};

std::vector<Seen> watch(DepthCamera& camera, int frames) {
    std::vector<Seen> seen;
    DepthFrame frame;
    while (static_cast<int>(seen.size()) < frames && camera.waitFrame(kLong, frame) == FrameStatus::frame) {
        seen.push_back({.sequence = frame.sequence,
                        .sourceIndex = frame.sourceIndex,
                        .time = frame.captureTime,
                        .restart = frame.restart,
                        .lastOfStill = frame.lastOfStill,
                        .hash = hashOf(frame)});
    }
    return seen;
}

class CameraConformanceTest : public testing::TestWithParam<CameraBackEnd> {
  protected:
    void SetUp() override {
        rig_ = GetParam().rig();
        camera_ = rig_->make(clock_);
        ASSERT_NE(camera_, nullptr);
    }
    void TearDown() override { camera_.reset(); }

    VirtualClock virtual_;
    SteadyClock steady_;
    hal::Clock& clock_ = GetParam().live ? static_cast<hal::Clock&>(steady_) : virtual_;
    std::unique_ptr<CameraRig> rig_;
    std::unique_ptr<DepthCamera> camera_;
};

// Those that have an end, can be taken away, or can be made to wait: not every back end is in these lists.
class RecordingConformanceTest : public CameraConformanceTest {};
class LossConformanceTest : public CameraConformanceTest {};
class WaitConformanceTest : public CameraConformanceTest {};
// Those whose frames wait for their reader, and those that do not.
class PatientConformanceTest : public CameraConformanceTest {};
class LiveConformanceTest : public CameraConformanceTest {};
// A program whose list has none of a kind leaves that kind's tests out.
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(RecordingConformanceTest);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LossConformanceTest);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(WaitConformanceTest);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PatientConformanceTest);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LiveConformanceTest);

std::vector<CameraBackEnd> backEndsWith(bool CameraBackEnd::*ability, bool has = true) {
    std::vector<CameraBackEnd> chosen;
    for (const CameraBackEnd& backEnd : cameraBackEnds()) {
        if (backEnd.*ability == has) chosen.push_back(backEnd);
    }
    return chosen;
}

TEST_P(CameraConformanceTest, FramesComeInOrderAtTheirRateAndSizeAndNeverEarly) {
    ASSERT_TRUE(camera_->open());
    const hal::CameraInfo info = camera_->info();
    EXPECT_FALSE(info.name.empty());
    ASSERT_GT(info.framesPerSecond, 0.0);
    DepthFrame first;
    DepthFrame before;
    for (int i = 0; i < kFrames; ++i) {
        DepthFrame frame;
        ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
        EXPECT_LE(frame.captureTime, clock_.now());
        EXPECT_EQ(frame.depth.width, info.intrinsics.width);
        EXPECT_EQ(frame.depth.height, info.intrinsics.height);
        EXPECT_EQ(frame.intrinsics.width, info.intrinsics.width);
        EXPECT_EQ(frame.intrinsics.fx, info.intrinsics.fx);
        EXPECT_EQ(frame.intrinsics.cy, info.intrinsics.cy);
        if (!frame.colour.empty()) {
            EXPECT_TRUE(info.colour);
            EXPECT_EQ(frame.colour.width, frame.depth.width);
            EXPECT_EQ(frame.colour.height, frame.depth.height);
        }
        if (i == 0) {
            EXPECT_TRUE(frame.restart);
            first = frame;
        } else {
            EXPECT_GT(frame.sequence, before.sequence);
            EXPECT_GT(frame.captureTime, before.captureTime);
            const double expected = static_cast<double>(frame.sequence - first.sequence) / info.framesPerSecond;
            const double elapsed = hal::seconds(frame.captureTime - first.captureTime);
            EXPECT_LE(elapsed, expected + (GetParam().live ? 0.02 : 0.001));
            // A live device's time is found out from arrivals: where a busy machine took the first frame late, the
            // frames after it seem nearer to it than they are.
            if (!GetParam().live) {
                EXPECT_GE(elapsed, expected - 0.001);
            }
            if (!info.independent) {
                EXPECT_FALSE(frame.restart);
                EXPECT_TRUE(frame.lastOfStill);
            }
        }
        before = frame;
    }
}

TEST_P(CameraConformanceTest, AStillStartsAnewAndSaysWhenItIsOver) {
    ASSERT_TRUE(camera_->open());
    const std::vector<Seen> seen = watch(*camera_, kFrames);
    ASSERT_EQ(seen.size(), static_cast<std::size_t>(kFrames));
    for (std::size_t i = 1; i < seen.size(); ++i) {
        const bool newSource = seen[i].sourceIndex != seen[i - 1].sourceIndex;
        if (camera_->info().independent) {
            EXPECT_EQ(seen[i].restart, newSource);
            EXPECT_EQ(seen[i - 1].lastOfStill, newSource);
        }
        if (!newSource) {
            EXPECT_EQ(seen[i].hash, seen[i - 1].hash);
        }
    }
}

TEST_P(CameraConformanceTest, AWaitNeverLastsLongerThanItsLimit) {
    ASSERT_TRUE(camera_->open());
    std::mt19937 random(7);  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same on every run.
    int timedOut = 0;
    int frames = 0;
    for (int i = 0; i < 100; ++i) {
        const Duration limit = std::chrono::microseconds(random() % 40000);
        const TimePoint before = clock_.now();
        DepthFrame frame;
        const FrameStatus status = camera_->waitFrame(limit, frame);
        // Real time says nothing of who took it; there, that the suite ends is the proof.
        if (!GetParam().live) {
            EXPECT_LE(clock_.now() - before, limit);
        }
        if (status == FrameStatus::timedOut) {
            ++timedOut;
            if (!GetParam().live) {
                EXPECT_EQ(clock_.now() - before, limit);
            }
        } else {
            ASSERT_TRUE(status == FrameStatus::frame || (GetParam().ends && status == FrameStatus::ended));
            ++frames;
        }
    }
    EXPECT_GT(timedOut, 0);
    EXPECT_GT(frames, 0);
}

TEST_P(WaitConformanceTest, ATimeOutIsNoLoss) {
    camera_.reset();
    SteadyClock steady;
    const auto camera = rig_->makeSlow(steady);
    ASSERT_NE(camera, nullptr);
    ASSERT_TRUE(camera->open());
    DepthFrame frame;
    camera->waitFrame(std::chrono::milliseconds(10), frame);
    for (int i = 0; i < 5; ++i) {
        ASSERT_EQ(camera->waitFrame(std::chrono::milliseconds(10), frame), FrameStatus::timedOut);
        ASSERT_EQ(camera->waitFrame(Duration::zero(), frame), FrameStatus::timedOut);
    }
}

TEST_P(PatientConformanceTest, ATimeOutLosesNothing) {
    ASSERT_TRUE(camera_->open());
    const Duration period = hal::fromSeconds(1.0 / camera_->info().framesPerSecond);
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    for (int i = 0; i < 5; ++i) {
        const std::uint64_t sequence = frame.sequence;
        ASSERT_EQ(camera_->waitFrame(period / 2, frame), FrameStatus::timedOut);
        ASSERT_EQ(camera_->waitFrame(Duration::zero(), frame), FrameStatus::timedOut);
        ASSERT_EQ(camera_->waitFrame(period, frame), FrameStatus::frame);
        EXPECT_EQ(frame.sequence, sequence + 1);
    }
}

TEST_P(RecordingConformanceTest, ARecordingEndsAndPlaysAgainWhenReopened) {
    ASSERT_TRUE(camera_->open());
    const std::vector<Seen> first = watch(*camera_, 1 << 20);
    DepthFrame frame;
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::ended);
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::ended);
    camera_->close();
    ASSERT_TRUE(camera_->open());
    const std::vector<Seen> second = watch(*camera_, 1 << 20);
    ASSERT_EQ(second.size(), first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ(second[i].hash, first[i].hash);
        EXPECT_EQ(second[i].sequence, first[i].sequence);
    }
}

TEST_P(LossConformanceTest, ALostDeviceSaysSoUntilItIsBackAndReopened) {
    ASSERT_TRUE(camera_->open());
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    for (int round = 0; round < 3; ++round) {
        rig_->lose();
        FrameStatus status = FrameStatus::frame;
        for (int i = 0; i < 10 && status != FrameStatus::lost; ++i)
            status = camera_->waitFrame(kLong, frame);
        EXPECT_EQ(status, FrameStatus::lost);
        EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::lost);
        rig_->bringBack();
        camera_->close();
        ASSERT_TRUE(camera_->open());
        ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
        EXPECT_TRUE(frame.restart);
    }
}

TEST_P(CameraConformanceTest, OpeningAnOpenCameraIsAnErrorAndHarmless) {
    ASSERT_TRUE(camera_->open());
    const auto again = camera_->open();
    ASSERT_FALSE(again);
    EXPECT_FALSE(again.error().cause.empty());
    DepthFrame frame;
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
}

TEST_P(CameraConformanceTest, AClosedCameraSaysSo) {
    DepthFrame frame;
    EXPECT_FALSE(camera_->isOpen());
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::closed);
    camera_->close();
    ASSERT_TRUE(camera_->open());
    EXPECT_TRUE(camera_->isOpen());
    camera_->close();
    camera_->close();
    EXPECT_FALSE(camera_->isOpen());
    EXPECT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::closed);
    EXPECT_EQ(virtual_.now(), TimePoint{});
}

TEST_P(CameraConformanceTest, MayBeDestroyedWhileOpen) {
    ASSERT_TRUE(camera_->open());
    DepthFrame frame;
    ASSERT_EQ(camera_->waitFrame(kLong, frame), FrameStatus::frame);
    camera_.reset();
}

TEST_P(WaitConformanceTest, ClosingEndsAWaitInAnotherThread) {
    camera_.reset();
    SteadyClock steady;
    const auto camera = rig_->makeSlow(steady);
    ASSERT_NE(camera, nullptr);
    for (int round = 0; round < 5; ++round) {
        ASSERT_TRUE(camera->open());
        std::mutex mutex;
        std::condition_variable changed;
        bool waiting = false;
        // A slow frame may be due at once, at the start; the one after it is ten seconds away.
        std::vector<FrameStatus> statuses;
        std::thread waiter([&] {
            DepthFrame frame;
            {
                const std::lock_guard lock(mutex);
                waiting = true;
            }
            changed.notify_one();
            do {
                statuses.push_back(camera->waitFrame(kLong, frame));
            } while (statuses.back() == FrameStatus::frame);
        });
        {
            std::unique_lock lock(mutex);
            changed.wait(lock, [&] { return waiting; });
        }
        camera->close();
        waiter.join();
        EXPECT_EQ(statuses.back(), FrameStatus::closed);
        EXPECT_LE(statuses.size(), 2U);
    }
}

TEST_P(CameraConformanceTest, OpensAHundredTimesWithoutGrowth) {
    const auto use = [&] {
        ASSERT_TRUE(camera_->open());
        EXPECT_FALSE(watch(*camera_, 2).empty());
        camera_->close();
    };
    for (int i = 0; i < 3; ++i)
        use();
    const ProcessUse before;
    for (int i = 0; i < 100; ++i)
        use();
    const ProcessUse after;
    EXPECT_EQ(after.descriptors, before.descriptors);
    EXPECT_EQ(after.threads, before.threads);
    EXPECT_LE(after.heapBytes, before.heapBytes + kHeapSlack);
}

TEST_P(LiveConformanceTest, TheSameFrameHasTheSameBytesTwice) {
    ASSERT_TRUE(camera_->open());
    const auto otherRig = GetParam().rig();
    const auto other = otherRig->make(clock_);
    ASSERT_NE(other, nullptr);
    ASSERT_TRUE(other->open());
    // Each skips other frames; what both saw is compared.
    std::map<std::uint64_t, std::uint64_t> hashes;
    int compared = 0;
    for (int i = 0; i < 300 && compared < 5; ++i) {
        for (DepthCamera* camera : {camera_.get(), other.get()}) {
            DepthFrame frame;
            ASSERT_EQ(camera->waitFrame(kLong, frame), FrameStatus::frame);
            const auto [known, fresh] = hashes.try_emplace(frame.sequence, hashOf(frame));
            if (fresh) continue;
            EXPECT_EQ(known->second, hashOf(frame)) << "frame " << frame.sequence;
            ++compared;
        }
    }
    EXPECT_GE(compared, 5);
}

TEST_P(PatientConformanceTest, SameInputGivesTheSameBytesTwice) {
    ASSERT_TRUE(camera_->open());
    const std::vector<Seen> first = watch(*camera_, kFrames);
    VirtualClock otherClock;
    const auto otherRig = GetParam().rig();
    const auto other = otherRig->make(otherClock);
    ASSERT_NE(other, nullptr);
    ASSERT_TRUE(other->open());
    const std::vector<Seen> second = watch(*other, kFrames);
    ASSERT_EQ(first.size(), static_cast<std::size_t>(kFrames));
    EXPECT_EQ(first, second);
}

std::string nameOf(const testing::TestParamInfo<CameraBackEnd>& test) {
    return test.param.name;
}
INSTANTIATE_TEST_SUITE_P(All, CameraConformanceTest, testing::ValuesIn(cameraBackEnds()), nameOf);
INSTANTIATE_TEST_SUITE_P(All, RecordingConformanceTest, testing::ValuesIn(backEndsWith(&CameraBackEnd::ends)), nameOf);
INSTANTIATE_TEST_SUITE_P(All, LossConformanceTest, testing::ValuesIn(backEndsWith(&CameraBackEnd::canBeLost)), nameOf);
INSTANTIATE_TEST_SUITE_P(All, WaitConformanceTest, testing::ValuesIn(backEndsWith(&CameraBackEnd::canBeSlow)), nameOf);
INSTANTIATE_TEST_SUITE_P(All, LiveConformanceTest, testing::ValuesIn(backEndsWith(&CameraBackEnd::live)), nameOf);
INSTANTIATE_TEST_SUITE_P(All, PatientConformanceTest, testing::ValuesIn(backEndsWith(&CameraBackEnd::live, false)),
                         nameOf);

}  // namespace
}  // namespace cheval::test

#include "hal/sensor_process/frame_ring.h"

#include <atomic>
#include <functional>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "hal/sensor_process/ring_layout.h"
#include "tests/support/allocation_counter.h"

namespace cheval::hal {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

/// Both ends of one ring, as two processes would map it.
class FrameRingTest : public testing::Test {
  protected:
    void SetUp() override {
        auto made = RingMemory::create();
        ASSERT_TRUE(made);
        auto other = RingMemory::attach(Descriptor(::dup(made->descriptor())));
        ASSERT_TRUE(other);
        memory_ = other->data();
        reader_.emplace(std::move(*made));
        writer_.emplace(std::move(*other));
    }

    DepthFrame frameOf(std::uint64_t sequence) {
        std::fill(depth_.pixels.begin(), depth_.pixels.end(), static_cast<std::uint16_t>(sequence));
        std::fill(colour_.pixels.begin(), colour_.pixels.end(), Rgb8{static_cast<std::uint8_t>(sequence), 1, 2});
        return {.sequence = sequence,
                .sourceIndex = sequence + 5,
                .captureTime = TimePoint(Duration(sequence * 1000)),
                .depth = std::as_const(depth_).view(),
                .colour = std::as_const(colour_).view()};
    }

    static bool isWhole(const DepthFrame& frame) {
        const auto expected = static_cast<std::uint16_t>(frame.sequence);
        for (int y = 0; y < frame.depth.height; ++y) {
            for (int x = 0; x < frame.depth.width; ++x) {
                if (frame.depth.at(x, y) != expected) return false;
                if (!frame.colour.empty() && frame.colour.at(x, y).r != static_cast<std::uint8_t>(expected))
                    return false;
            }
        }
        return true;
    }

    Image<std::uint16_t> depth_{kWidth, kHeight};
    Image<Rgb8> colour_{kWidth, kHeight};
    std::byte* memory_ = nullptr;
    std::optional<RingReader> reader_;
    std::optional<RingWriter> writer_;
};

TEST_F(FrameRingTest, NothingWasWrittenIsNothing) {
    DepthFrame frame;
    EXPECT_EQ(reader_->take(frame), RingReader::Status::nothing);
}

TEST_F(FrameRingTest, EverythingOfAFrameComesAcrossOnce) {
    ASSERT_TRUE(writer_->write(frameOf(7), 3));
    DepthFrame frame;
    ASSERT_EQ(reader_->take(frame), RingReader::Status::frame);
    EXPECT_EQ(frame.sequence, 7U);
    EXPECT_EQ(frame.sourceIndex, 12U);
    EXPECT_EQ(frame.captureTime, TimePoint(Duration(7000)));
    EXPECT_EQ(frame.depth.width, kWidth);
    EXPECT_EQ(frame.colour.height, kHeight);
    EXPECT_EQ(reader_->meta().opening, 3U);
    EXPECT_GT(reader_->meta().publishedNs, 0);
    EXPECT_TRUE(isWhole(frame));
    EXPECT_EQ(reader_->take(frame), RingReader::Status::nothing);
}

TEST_F(FrameRingTest, ALateReaderGetsTheNewest) {
    for (std::uint64_t i = 1; i <= 20; ++i)
        ASSERT_TRUE(writer_->write(frameOf(i), 1));
    DepthFrame frame;
    ASSERT_EQ(reader_->take(frame), RingReader::Status::frame);
    EXPECT_EQ(frame.sequence, 20U);
}

TEST_F(FrameRingTest, WhatIsOnLoanIsNeverWrittenOver) {
    ASSERT_TRUE(writer_->write(frameOf(1), 1));
    DepthFrame frame;
    ASSERT_EQ(reader_->take(frame), RingReader::Status::frame);
    for (std::uint64_t i = 2; i <= 50; ++i) {
        ASSERT_TRUE(writer_->write(frameOf(i), 1));
        ASSERT_TRUE(isWhole(frame)) << "after frame " << i;
    }
}

TEST_F(FrameRingTest, DepthAloneIsDepthAlone) {
    DepthFrame given = frameOf(4);
    given.colour = {};
    ASSERT_TRUE(writer_->write(given, 1));
    DepthFrame frame;
    ASSERT_EQ(reader_->take(frame), RingReader::Status::frame);
    EXPECT_TRUE(frame.colour.empty());
}

TEST_F(FrameRingTest, ARacingWriterNeverTearsAFrame) {
    std::atomic<bool> stop{false};
    std::thread writing([&] {
        for (std::uint64_t i = 1; !stop; ++i)
            ASSERT_TRUE(writer_->write(frameOf(i), 1));
    });
    int taken = 0;
    std::uint64_t last = 0;
    while (taken < 3000) {
        DepthFrame frame;
        const RingReader::Status status = reader_->take(frame);
        ASSERT_NE(status, RingReader::Status::broken);
        if (status == RingReader::Status::nothing) continue;
        ASSERT_TRUE(isWhole(frame)) << "frame " << frame.sequence;
        ASSERT_GT(frame.sequence, last);
        last = frame.sequence;
        ++taken;
    }
    stop = true;
    writing.join();
}

TEST_F(FrameRingTest, AQuickWriterNeverLooksBrokenToASlowReader) {
    const Image<std::uint16_t> tiny(4, 4, 7);
    std::atomic<bool> stop{false};
    std::thread writing([&] {
        for (std::uint64_t i = 1; !stop; ++i)
            ASSERT_TRUE(writer_->write({.sequence = i, .depth = tiny.view()}, 1));
    });
    for (int taken = 0; taken < 200'000;) {
        DepthFrame frame;
        const RingReader::Status status = reader_->take(frame);
        if (status == RingReader::Status::broken) {
            ADD_FAILURE() << "after " << taken << " frames";
            break;
        }
        taken += status == RingReader::Status::frame ? 1 : 0;
    }
    stop = true;
    writing.join();
}

TEST_F(FrameRingTest, APictureThatDoesNotFitIsRefused) {
    const Image<std::uint16_t> large(static_cast<int>(kRingMaxWidth) + 1, 4);
    EXPECT_FALSE(writer_->write({.depth = large.view()}, 1));
    EXPECT_FALSE(writer_->write({}, 1));
    DepthFrame mixed = frameOf(1);
    mixed.colour.width = kWidth / 2;
    EXPECT_FALSE(writer_->write(mixed, 1));
    DepthFrame frame;
    EXPECT_EQ(reader_->take(frame), RingReader::Status::nothing);
}

TEST_F(FrameRingTest, TakesNoMemory) {
    const DepthFrame given = frameOf(1);
    const cheval::test::AllocationCounter counter;
    for (int i = 0; i < 10; ++i) {
        DepthFrame frame;
        ASSERT_TRUE(writer_->write(given, 1));
        ASSERT_EQ(reader_->take(frame), RingReader::Status::frame);
    }
    EXPECT_EQ(counter.count(), 0U);
}

// What a writer that went mad can do to the memory that it shares.

TEST_F(FrameRingTest, AWriterThatDiesInMidFrameLeavesTheLastWholeOne) {
    ASSERT_TRUE(writer_->write(frameOf(1), 1));
    // It had begun on every other slot.
    for (std::uint32_t i = 0; i < kRingSlots; ++i) {
        const auto newest = ring_layout::header(memory_).newest.load() & 0xffU;
        if (i != newest) ring_layout::slot(memory_, i).lock.fetch_add(1);
    }
    DepthFrame frame;
    ASSERT_EQ(reader_->take(frame), RingReader::Status::frame);
    EXPECT_TRUE(isWhole(frame));
    EXPECT_EQ(reader_->take(frame), RingReader::Status::nothing);
}

TEST_F(FrameRingTest, APublishedSlotThatStaysLockedIsBrokenAndEndsNoWait) {
    ASSERT_TRUE(writer_->write(frameOf(1), 1));
    const auto newest = static_cast<std::uint32_t>(ring_layout::header(memory_).newest.load() & 0xffU);
    ring_layout::slot(memory_, newest).lock.fetch_add(1);
    DepthFrame frame;
    EXPECT_EQ(reader_->take(frame), RingReader::Status::broken);
}

TEST_F(FrameRingTest, LiesAboutSizesAndSlotsAreFoundOut) {
    struct Lie {
        const char* what;
        std::function<void(std::byte*, std::uint32_t)> tell;
    };
    const std::vector<Lie> lies = {
        {"a width beyond the memory",
         [](std::byte* m, std::uint32_t s) { ring_layout::slot(m, s).frame.width = 0x7fffffffU; }},
        {"a height beyond the memory",
         [](std::byte* m, std::uint32_t s) { ring_layout::slot(m, s).frame.height = kRingMaxHeight + 1; }},
        {"no width", [](std::byte* m, std::uint32_t s) { ring_layout::slot(m, s).frame.width = 0; }},
        {"another slot than there is",
         [](std::byte* m, std::uint32_t) { ring_layout::header(m).newest.store(9U << 8U | 200U); }},
        {"a serial number that is not the slot's",
         [](std::byte* m, std::uint32_t s) { ring_layout::slot(m, s).serial = 99; }},
    };
    for (const Lie& lie : lies) {
        SetUp();
        ASSERT_TRUE(writer_->write(frameOf(1), 1));
        lie.tell(memory_, static_cast<std::uint32_t>(ring_layout::header(memory_).newest.load() & 0xffU));
        DepthFrame frame;
        EXPECT_EQ(reader_->take(frame), RingReader::Status::broken) << lie.what;
    }
}

TEST_F(FrameRingTest, WritingOverWhatIsOnLoanIsFoundOut) {
    ASSERT_TRUE(writer_->write(frameOf(1), 1));
    DepthFrame frame;
    ASSERT_EQ(reader_->take(frame), RingReader::Status::frame);
    const auto lent = static_cast<std::uint32_t>(ring_layout::header(memory_).newest.load() & 0xffU);
    ring_layout::slot(memory_, lent).lock.fetch_add(2);
    EXPECT_EQ(reader_->take(frame), RingReader::Status::broken);
}

TEST_F(FrameRingTest, NobodyCanShrinkTheMemory) {
    EXPECT_NE(::ftruncate(reader_->descriptor(), 0), 0);
    EXPECT_NE(::ftruncate(reader_->descriptor(), 1 << 30), 0);
}

TEST(RingMemory, OtherMemoryIsRefusedWithWords) {
    const int small = ::memfd_create("small", MFD_CLOEXEC);
    const auto refused = RingMemory::attach(Descriptor(small));
    ASSERT_FALSE(refused);
    EXPECT_FALSE(refused.error().mend.empty());
    const int blank = ::memfd_create("blank", MFD_CLOEXEC);
    ASSERT_EQ(::ftruncate(blank, static_cast<off_t>(ring_layout::kSize)), 0);
    EXPECT_FALSE(RingMemory::attach(Descriptor(blank)));
    EXPECT_FALSE(RingMemory::attach(Descriptor(::open("/dev/null", O_RDWR | O_CLOEXEC))));
}

}  // namespace
}  // namespace cheval::hal

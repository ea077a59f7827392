// Frames from one process to another through shared memory: a few slots, each behind a sequence lock. The reader
// creates the memory and fixes every size, so that the writer can neither grow it, shrink it nor lie about it; the
// reader borrows a slot in place, and a writer that dies in mid-frame leaves a slot that was never published.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "hal/descriptor.h"
#include "hal/expected.h"
#include "hal/frame.h"

namespace cheval::hal {

/// What a frame carries besides its pixels. Fixed layout: it lies in shared memory.
struct RingFrame {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t colour = 0;   ///< 1: the colour picture is there.
    std::uint32_t restart = 0;  ///< As DepthFrame.
    std::uint32_t opening = 0;  ///< Which opening of the device it belongs to.
    std::uint32_t reserved = 0;
    std::uint64_t sequence = 0;      ///< As DepthFrame.
    std::uint64_t sourceIndex = 0;   ///< As DepthFrame.
    std::int64_t captureTimeNs = 0;  ///< On CLOCK_MONOTONIC; of a recording: from its first frame.
    std::int64_t publishedNs = 0;    ///< CLOCK_MONOTONIC when it was handed over.
};

/// The largest picture that fits: what the largest mode of an OpenNI2 sensor needs.
constexpr std::uint32_t kRingMaxWidth = 1280;
constexpr std::uint32_t kRingMaxHeight = 1024;
constexpr std::uint32_t kRingSlots = 4;

/// The memory, mapped into this process.
class RingMemory {
  public:
    /// Makes sealed memory for the reader's side. Errors: resource.
    static Expected<RingMemory> create();
    /// Maps what a parent handed down. Takes the descriptor. Errors: invalidInput where it is no ring of this version.
    static Expected<RingMemory> attach(Descriptor memory);
    ~RingMemory();
    RingMemory(RingMemory&& other) noexcept;
    RingMemory& operator=(RingMemory&& other) noexcept;
    RingMemory(const RingMemory&) = delete;
    RingMemory& operator=(const RingMemory&) = delete;

    [[nodiscard]] int descriptor() const { return descriptor_.get(); }
    [[nodiscard]] std::byte* data() const { return data_; }

  private:
    RingMemory(Descriptor descriptor, std::byte* data) : descriptor_(std::move(descriptor)), data_(data) {}
    Descriptor descriptor_;
    std::byte* data_ = nullptr;
};

/// The writing end. Thread-bound.
class RingWriter {
  public:
    explicit RingWriter(RingMemory memory) : memory_(std::move(memory)) {}

    /// Copies a frame into a slot that nobody reads and publishes it. Never waits. Errors: invalidInput for a picture
    /// that does not fit, or colour of another size than depth.
    Expected<void> write(const DepthFrame& frame, std::uint32_t opening);

  private:
    RingMemory memory_;
    std::uint64_t serial_ = 0;
};

/// The reading end. Thread-bound. No call takes heap memory.
class RingReader {
  public:
    enum class Status : std::uint8_t {
        frame,    ///< A new frame is on loan until the next call.
        nothing,  ///< None since the last one.
        broken,   ///< The writer breaks the rules: sizes, slots or locks that cannot be. Use this memory no more.
    };

    explicit RingReader(RingMemory memory) : memory_(std::move(memory)) {}

    /// The newest frame that was not lent before; older ones are passed over. `frame`'s views are lent until the next
    /// call; its intrinsics are not set.
    Status take(DepthFrame& frame);
    /// What came with the frame on loan.
    [[nodiscard]] const RingFrame& meta() const { return meta_; }
    [[nodiscard]] int descriptor() const { return memory_.descriptor(); }

  private:
    [[nodiscard]] bool lentWasLeftAlone() const;

    RingMemory memory_;
    std::uint64_t lastSerial_ = 0;
    RingFrame meta_;
    std::optional<std::uint32_t> lent_;
    std::uint32_t lentLock_ = 0;
};

}  // namespace cheval::hal

// How the shared memory of a frame ring looks. Both ends include it; nobody else but the tests that break its rules.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "hal/sensor_process/frame_ring.h"

namespace cheval::hal::ring_layout {

constexpr std::uint32_t kMagic = 0x4c564843;  ///< "CHVL"
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kNoSlot = ~std::uint32_t{0};
constexpr unsigned kSlotBits = 8;  ///< Of Header::newest: serial number above, slot below.

static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free,
              "a lock would not reach the other process");

struct alignas(64) Header {
    std::uint32_t magic;
    std::uint32_t version;
    std::uint32_t slots;
    std::uint32_t maxWidth;
    std::uint32_t maxHeight;
    std::atomic<std::uint32_t> claimed;  ///< The slot that the reader looks at, or kNoSlot.
    std::atomic<std::uint64_t> newest;   ///< serial << kSlotBits | slot; 0: nothing yet.
};

struct alignas(64) Slot {
    std::atomic<std::uint32_t> lock;  ///< Odd while it is being written.
    std::uint32_t reserved;
    std::uint64_t serial;
    RingFrame frame;
};

constexpr std::size_t kPage = 4096;
constexpr std::size_t kPixels = std::size_t{kRingMaxWidth} * kRingMaxHeight;
constexpr std::size_t kDepthBytes = kPixels * sizeof(std::uint16_t);
constexpr std::size_t kColourBytes = kPixels * sizeof(Rgb8);
constexpr std::size_t kSlotBytes = kPage + kDepthBytes + kColourBytes;
static_assert(kDepthBytes % kPage == 0 && kColourBytes % kPage == 0 && sizeof(Slot) <= kPage);
constexpr std::size_t kSize = kPage + kRingSlots * kSlotBytes;

inline Header& header(std::byte* memory) {
    return *reinterpret_cast<Header*>(memory);
}
inline std::byte* slotAt(std::byte* memory, std::uint32_t index) {
    return memory + kPage + index * kSlotBytes;
}
inline Slot& slot(std::byte* memory, std::uint32_t index) {
    return *reinterpret_cast<Slot*>(slotAt(memory, index));
}
inline std::uint16_t* depth(std::byte* memory, std::uint32_t index) {
    return reinterpret_cast<std::uint16_t*>(slotAt(memory, index) + kPage);
}
inline Rgb8* colour(std::byte* memory, std::uint32_t index) {
    return reinterpret_cast<Rgb8*>(slotAt(memory, index) + kPage + kDepthBytes);
}

}  // namespace cheval::hal::ring_layout

// Hands the newest value from one thread to another without a lock and without waiting: one slot is written, one is
// read, one lies between.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace cheval::daemon {

/// One writer thread, one reader thread. What the reader misses is overwritten, never queued. No call waits or takes
/// memory, if T's own assignments do not.
template <typename T>
class TripleBuffer {
  public:
    TripleBuffer() = default;
    TripleBuffer(const TripleBuffer&) = delete;
    TripleBuffer& operator=(const TripleBuffer&) = delete;

    /// Writer: the slot to fill. It holds whatever was in it two or more publications ago.
    [[nodiscard]] T& back() { return slots_[back_]; }
    /// Writer: makes the back slot the newest. Returns true when the value before it was never taken.
    bool publish() {
        const std::uint8_t before =
            middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel);
        back_ = before & kIndex;
        return (before & kFresh) != 0;
    }
    /// Reader: takes the newest value if there is one; false: front() is what it was.
    bool take() {
        if ((middle_.load(std::memory_order_acquire) & kFresh) == 0) return false;
        front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
        return true;
    }
    /// Reader: what was taken last.
    [[nodiscard]] const T& front() const { return slots_[front_]; }
    /// Before the threads start: every slot, to reserve memory in.
    template <typename Function>
    void forEachSlot(Function&& function) {
        for (T& slot : slots_)
            function(slot);
    }

  private:
    static constexpr std::uint8_t kFresh = 4;
    static constexpr std::uint8_t kIndex = 3;

    std::array<T, 3> slots_{};
    std::uint8_t back_ = 0;
    std::atomic<std::uint8_t> middle_{1};
    std::uint8_t front_ = 2;
};

}  // namespace cheval::daemon

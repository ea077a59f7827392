// Buttons whose presses come from other threads.
#pragma once

#include <array>
#include <atomic>
#include <mutex>

#include "hal/buttons.h"

namespace cheval::hal {

/// A queue of 64 presses between the threads that press and the one that polls; the oldest give way. Takes no memory
/// after construction. Thread-safe.
class ButtonQueue final : public Buttons {
  public:
    static constexpr std::size_t kCapacity = 64;

    void press(const ButtonEvent& event);
    [[nodiscard]] std::uint64_t dropped() const override { return dropped_.load(std::memory_order_relaxed); }
    /// Events pressed since the start, the dropped ones included.
    [[nodiscard]] std::uint64_t pressed() const { return pressed_.load(std::memory_order_relaxed); }

  protected:
    Expected<std::size_t> doPoll(std::span<ButtonEvent> events) override;

  private:
    std::mutex mutex_;
    std::array<ButtonEvent, kCapacity> events_{};
    std::size_t first_ = 0;
    std::size_t count_ = 0;
    std::atomic<std::uint64_t> dropped_{0};
    std::atomic<std::uint64_t> pressed_{0};
};

}  // namespace cheval::hal

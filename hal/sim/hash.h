// Counter-based noise: every value is a pure function of what it belongs to, so that a frame needs no frame before it.
#pragma once

#include <cstdint>

namespace cheval::hal::sim {

/// A bijection of 32 bits in which each input bit changes about half of the output bits.
constexpr std::uint32_t scramble(std::uint32_t value) {
    value ^= value >> 16;
    value *= 0x7feb352dU;
    value ^= value >> 15;
    value *= 0x846ca68bU;
    value ^= value >> 16;
    return value;
}

/// A key for a pair, e.g. of a seed and a frame.
constexpr std::uint32_t scramble(std::uint32_t first, std::uint32_t second) {
    return scramble(scramble(first + 0x9e3779b9U) ^ (second * 0x85ebca6bU + 0xc2b2ae35U));
}

/// Uniform in [0, 1).
constexpr float unitInterval(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * (1.0F / 16777216.0F);
}

/// Draws one after another from a key; for what is decided once, such as a shopper.
class Draw {
  public:
    explicit constexpr Draw(std::uint32_t key) : key_(key) {}
    /// Uniform in [low, high).
    constexpr float between(float low, float high) {
        return low + (high - low) * unitInterval(scramble(key_, counter_++));
    }
    /// One of `count` with equal chances, 0 … count − 1.
    constexpr std::uint32_t choice(std::uint32_t count) { return scramble(key_, counter_++) % count; }

  private:
    std::uint32_t key_;
    std::uint32_t counter_ = 0;
};

}  // namespace cheval::hal::sim

// What the shopper wears, by name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace cheval::fitting {

inline constexpr std::size_t kMaximumLayers = 8;

/// Garments by their index in the wardrobe, innermost first.
struct Outfit {
    std::array<std::uint16_t, kMaximumLayers> garments{};
    std::size_t count = 0;

    friend bool operator==(const Outfit& a, const Outfit& b) {
        if (a.count != b.count) return false;
        for (std::size_t i = 0; i < a.count; ++i) {
            if (a.garments[i] != b.garments[i]) return false;
        }
        return true;
    }
};

}  // namespace cheval::fitting

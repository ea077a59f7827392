// What the head-up display shows in one frame. Plain values of fixed size: handing it over takes no memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "fitting/hands.h"

namespace cheval::render {

/// Text of bounded length, UTF-8, cut at a whole character.
template <std::size_t Capacity>
struct FixedText {
    std::array<char, Capacity> bytes{};
    std::size_t length = 0;

    void assign(std::string_view text) {
        length = text.size() < Capacity ? text.size() : Capacity;
        while (length < text.size() && length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U)
            --length;
        for (std::size_t i = 0; i < length; ++i)
            bytes[i] = text[i];
    }
    [[nodiscard]] std::string_view view() const { return {bytes.data(), length}; }
};

enum class Screen : std::uint8_t {
    attract,    ///< Nobody is there.
    acquiring,  ///< Somebody is; "please stand here".
    wearing,    ///< Dressed.
    service,    ///< For technicians: something is wrong, with its reason.
};

inline constexpr std::size_t kMaximumCarousel = 16;

/// One garment or outfit in the carousel.
struct CarouselItem {
    FixedText<48> name;
};

struct HandCursor {
    bool visible = false;
    Eigen::Vector2f position = Eigen::Vector2f::Zero();  ///< Of the mirrored display, 0…1 from the top left.
    fitting::HandState state = fitting::HandState::unknown;
};

struct HudState {
    Screen screen = Screen::attract;
    std::array<CarouselItem, kMaximumCarousel> carousel{};
    std::size_t carouselCount = 0;
    std::size_t carouselSelected = 0;
    std::array<HandCursor, fitting::kSideCount> cursors{};
    FixedText<160> prompt;   ///< What to do now.
    FixedText<160> advice;   ///< Size advice.
    FixedText<512> service;  ///< Cause and mend; service screen only.
};

}  // namespace cheval::render

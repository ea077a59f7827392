// Cuts garments from the mannequin's skin: takes the quads that a garment covers, lets the cloth hang from where the
// body carries it, and turns the edges in.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fitting/bake/body_builder.h"

namespace cheval::fitting::bake {

/// A place in a garment's own grid: quarter rings and quarter columns, rows growing downwards or towards the hand.
struct GridPlace {
    int row = 0, column = 0;
    friend bool operator==(const GridPlace&, const GridPlace&) = default;
    friend bool operator<(const GridPlace& a, const GridPlace& b) {
        return a.row != b.row ? a.row < b.row : a.column < b.column;
    }
};

/// Pieces as a tailor has them. Tops: front, back, sleeves. Trousers: one front and one back a leg.
enum class Panel : std::uint8_t { front, back, leftSleeve, rightSleeve, leftFront, leftBack, rightFront, rightBack };
inline constexpr std::size_t kPanelCount = 8;

/// A garment's surface before it is laid out in a texture.
struct Cloth {
    struct Face {
        std::array<std::uint32_t, 4> vertex{};
        std::array<GridPlace, 4> at{};
        Panel panel = Panel::front;
        bool turned = false;  ///< On the inside of an edge.
    };
    std::vector<Vec3> positions;
    std::vector<SkinningWeights> weights;
    std::vector<Face> faces;
    std::vector<std::uint8_t> coveredSkin;   ///< Per fine body vertex: 1 where the cloth lies over it.
    std::vector<std::uint32_t> clothOnSkin;  ///< Per fine body vertex: the cloth's vertex above it where covered.
};

struct TopCut {
    double sleeveRing = 5.5;    ///< Arm ring at which the sleeve ends.
    double hemHeight = 0.838;   ///< Metres above the floor.
    double ease = 0.016;        ///< Metres at the chest.
    double sleeveEase = 0.020;  ///< Metres below the arm at the sleeve's hem.
    double foldDepth = 0.0100;  ///< Metres.
};
Cloth cutTop(const BodyModel& model, const TopCut& cut);

struct TrousersCut {
    double hemRing = 12.75;     ///< Leg ring at which they end, or from which they hang on.
    double hang = 0.045;        ///< Metres below that ring.
    double extraWidth = 0.0;    ///< Metres added to the leg's radius.
    double foldDepth = 0.0060;  ///< Metres.
};
Cloth cutTrousers(const BodyModel& model, const TrousersCut& cut);

/// The least distance between cloth and skin, metres.
inline constexpr double kClearance = 0.0055;

}  // namespace cheval::fitting::bake

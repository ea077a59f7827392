// What a hand's outline says about its fingers (D3, steps 5 to 7).
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fitting/tracking/binary_image.h"

namespace cheval::fitting::tracking {

/// Measures of a hand's outline, lengths in cells.
struct HandShape {
    bool valid = false;
    Eigen::Vector2f palm = Eigen::Vector2f::Zero();  ///< Centre of the largest circle inside.
    float palmRadius = 0.0F;                         ///< Its radius.
    float fingerReach = 0.0F;  ///< From the palm's centre to the farthest point of the outline away from the arm.
    int deepGaps = 0;          ///< Gaps deeper than a third of the palm's radius: between spread fingers.
    int fingers = 0;           ///< Stretched ones: tips far from the palm with a dip to either side.
};

/// Scratch of HandShapeJob, made once.
struct HandShapeContext {
    std::vector<Cell> cells = std::vector<Cell>(kHandCells);
    std::vector<float> distance = std::vector<float>(kHandCells);
    std::array<Cell, 2048> contour{};
    std::array<Cell, 2048> sorted{};
    std::array<Cell, 2049> hull{};
    std::size_t contourSize = 0;
    std::size_t hullSize = 0;
};

/// Keeps the component about the middle of the mask, traces its contour, builds the hull, and measures how deep the
/// contour lies under each side of the hull. Invalid without mask and context.
struct HandShapeJob {
    HandMask* mask = nullptr;  ///< In: a hand's region; out: its one component.
    HandShapeContext* context = nullptr;
    Eigen::Vector2f forearm = Eigen::Vector2f::Zero();  ///< As HandRegionJob gives it.

    HandShape shape;  ///< Out.

    [[nodiscard]] bool isValid() const { return mask != nullptr && context != nullptr; }
    void run();

  private:
    [[nodiscard]] bool findPalm();
    void measureGaps();
    void countFingers();
};

}  // namespace cheval::fitting::tracking

// Cuts a hand out of the depth picture, at a size that does not depend on distance (D3, steps 1 to 4).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "fitting/tracking/binary_image.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Samples a square about a hand, its side a multiple of the distance from head to neck, so that a child's hand fills
/// as much of it as an adult's and a far one as much as a near one. What lies at the hand's depth and not beyond the
/// wrist is 1; then two dilations and one erosion. Invalid without a picture or with a distance that is not positive.
struct HandRegionJob {
    hal::ImageView<const std::uint16_t> depth;
    hal::ImageView<const std::uint8_t> userMap;  ///< May be empty: then every pixel counts.
    std::uint8_t label = 0;
    hal::Intrinsics intrinsics;
    Eigen::Vector3f palm = Eigen::Vector3f::Zero();   ///< Sensor frame, millimetres, about its centre.
    Eigen::Vector3f elbow = Eigen::Vector3f::Zero();  ///< Sensor frame, millimetres.
    float headToNeck = 0.0F;                          ///< Metres.
    bool close = true;  ///< The dilations and the erosion, which mend what noise tears; near hands keep their gaps.

    HandMask* mask = nullptr;  ///< Out.
    HandMask* scratch = nullptr;
    float cellMetres = 0.0F;     ///< Out: side of a cell.
    float surface = 0.0F;        ///< Out: depth of the hand's surface, millimetres; 0: nothing there.
    float pixelsPerCell = 0.0F;  ///< Out: under 1 the picture is coarser than the grid.
    Eigen::Vector2f forearm = Eigen::Vector2f::Zero();  ///< Out: from elbow to hand in the grid, rows down; its length
                                                        ///< is the share that lies across the line of sight, 0…1.

    [[nodiscard]] bool isValid() const {
        return !depth.empty() && mask != nullptr && scratch != nullptr && headToNeck > 0.02F && headToNeck < 0.5F &&
               palm.z() > 200.0F && intrinsics.fx > 0.0F;
    }
    void run();

    /// The region's side over the distance from head to neck: an open hand with some room.
    static constexpr float kSideFactor = 1.9F;

    /// A hand's depth about its surface at the palm, millimetres: fingers reach forwards more than back.
    static constexpr float kNearer = 110.0F;
    static constexpr float kFarther = 70.0F;
    /// The palm's place on the surface that was found, sensor frame, millimetres; the joint itself lies inside the
    /// hand.
    [[nodiscard]] Eigen::Vector3f palmOnSurface() const { return palm * ((surface + kPalmDepth) / palm.z()); }

  private:
    static constexpr float kPalmDepth = 15.0F;
    [[nodiscard]] float findSurface() const;
};

}  // namespace cheval::fitting::tracking

// Where the shopper's own arm, hair or bag is in front of a garment: the camera's depth held against the garment's, in
// the picture's own pixels, smoothed so that edges are soft and still.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "hal/image.h"
#include "render/mirror_mapping.h"
#include "render/renderer.h"

namespace cheval::render {

/// Cells of the mirrored picture that a rectangle of the display touches.
struct CellGrid {
    int x0 = 0, y0 = 0;  ///< First cell.
    int columns = 0, rows = 0;
    int cell = 1;          ///< Picture pixels a cell.
    Eigen::Vector4f part;  ///< The same part of the display: left, top, width, height in pixels.
    [[nodiscard]] bool empty() const { return columns <= 0 || rows <= 0; }
};

/// Most cells on a side, however large the camera's picture.
inline constexpr int kMaximumCells = 640;

CellGrid cellGrid(const MirrorMapping& mapping, const PixelRect& rect);

/// Thread-bound; takes memory only when the picture's size changes.
class Occlusion {
  public:
    /// Compares `distances` (what drawDistance() made for `grid`) with the camera's depth. Where `skeleton` says where
    /// the head and both forearms are, a surface in front of the cloth must be one of them, or far in front.
    void update(const CellGrid& grid, const MirrorMapping& mapping, const CameraPicture& camera,
                const fitting::Skeleton& skeleton, hal::ImageView<const hal::Rgba8> distances);
    /// How visible the garment is, 0…255, along one row: `count` samples from display pixel (left, y) on, `step` apart.
    void visibleRow(const MirrorMapping& mapping, float left, float y, float step, int count,
                    std::uint8_t* visible) const;
    /// Forgets the frames before: another person, or a gap in time.
    void reset();
    /// How much farther than the camera's depth the garment lies where nothing hides it, metres.
    [[nodiscard]] float offset() const { return offset_; }

  private:
    void compare(const CellGrid& grid, const MirrorMapping& mapping, const CameraPicture& camera,
                 hal::ImageView<const hal::Rgba8> distances);
    void placeLimbs(const CameraPicture& camera, const fitting::Skeleton& skeleton);
    /// Whether the surface at a cell of the grid belongs to a limb that may hide cloth.
    [[nodiscard]] bool onLimb(const CellGrid& grid, const MirrorMapping& mapping, std::size_t cell) const;
    void separate(const CellGrid& grid, const MirrorMapping& mapping);
    /// Walks the surface that `seed` lies on; whether it is in front rather than a rounder body.
    [[nodiscard]] bool standsOut(const CellGrid& grid, const MirrorMapping& mapping, std::size_t seed);
    void smooth(const CellGrid& grid);

    /// Sensor frame, millimetres.
    struct Limb {
        Eigen::Vector3f from = Eigen::Vector3f::Zero();
        Eigen::Vector3f to = Eigen::Vector3f::Zero();
        float radius = 0.0F;
    };

    int columns_ = 0, rows_ = 0, cell_ = 1;
    std::array<Limb, 3> limbs_{};  ///< Head, left and right forearm with the hand.
    bool knowsLimbs_ = false;
    hal::Intrinsics intrinsics_;
    std::vector<std::uint8_t> visible_;    ///< Of the whole mirrored picture, a byte a cell.
    std::vector<std::uint32_t> lastSeen_;  ///< Frame in which a cell was last covered by cloth.
    std::uint32_t frame_ = 1;
    float offset_ = 0.0F;
    bool hasOffset_ = false;
    // Of the grid:
    std::vector<std::int16_t> nearer_;         ///< Millimetres by which the camera's depth is nearer than the cloth.
    std::vector<std::uint16_t> seen_;          ///< The camera's depth, millimetres.
    std::vector<std::uint8_t> kind_;           ///< What is known of a cell.
    std::vector<std::uint32_t> surface_;       ///< Cells of the surface being walked, in the order of the walk.
    std::size_t walked_ = 0;                   ///< How many of them.
    std::vector<std::uint16_t> hidden_, all_;  ///< Sums along rows.
};

}  // namespace cheval::render

// From the mirror frame to pixels of the display, for either view, as one 3×4 matrix.
#pragma once

#include <Eigen/Core>

namespace cheval::render {

/// Rows give (X·z, Y·z, z) of a mirror-frame point (metres, homogeneous): X and Y in pixels of the display from its top
/// left (pixel edges at whole numbers), z the distance along the camera's axis in metres.
using Projection = Eigen::Matrix<float, 3, 4>;

/// Whole pixels; x1 and y1 are one past the last.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] int width() const { return x1 - x0; }
    [[nodiscard]] int height() const { return y1 - y0; }
    [[nodiscard]] bool empty() const { return x1 <= x0 || y1 <= y0; }
};

/// Distances in metres between which garments are drawn.
inline constexpr float kNear = 0.2F;
inline constexpr float kFar = 12.0F;

/// Display pixel of a mirror-frame point; only for points with z > 0.
Eigen::Vector2f projectPoint(const Projection& projection, const Eigen::Vector3f& mirrorMetres);

/// GL's clip matrix for the part (left, top, width, height) of the display in pixels. The top row of the part comes out
/// as row 0 of what glReadPixels gives.
Eigen::Matrix4f clipMatrix(const Projection& projection, float left, float top, float width, float height);

/// Whether triangles that are counter-clockwise seen from outside come out clockwise through clipMatrix().
bool flipsWinding(const Projection& projection);

/// Where the camera stands, in the mirror frame.
Eigen::Vector3f eyeOf(const Projection& projection);

}  // namespace cheval::render

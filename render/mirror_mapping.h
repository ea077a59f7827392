// Which part of the camera's picture the mirror shows, and where each pixel of it goes: turned upright, flipped as a
// mirror does, cropped to the display's shape, scaled.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "hal/clock.h"
#include "hal/frame.h"
#include "render/projection.h"

namespace cheval::render {

/// The way in which the picture's content must be turned to stand upright.
enum class Turn : std::uint8_t { none, left, half, right };

/// The turn that brings the mirror frame's +Y to the top. `rotated` says that the sensor hangs on its side; on which,
/// the placement says.
Turn uprightTurn(bool rotated, const fitting::SensorPlacement& placement);

/// Immutable between frames. "Mirrored picture" below: the camera's picture, upright and flipped, in its own pixels
/// with pixel edges at whole numbers, before crop and scale.
struct MirrorMapping {
    Turn turn = Turn::none;
    int pictureWidth = 640;  ///< As the sensor delivers it.
    int pictureHeight = 480;
    float cropLeft = 0.0F;  ///< Of the mirrored picture.
    float cropTop = 0.0F;
    float scale = 1.0F;  ///< Display pixels a picture pixel.

    [[nodiscard]] bool onSide() const { return turn == Turn::left || turn == Turn::right; }
    [[nodiscard]] int mirroredWidth() const { return onSide() ? pictureHeight : pictureWidth; }
    [[nodiscard]] int mirroredHeight() const { return onSide() ? pictureWidth : pictureHeight; }

    /// The sensor's pixel (column, row) that pixel (x, y) of the mirrored picture shows.
    [[nodiscard]] Eigen::Vector2i sensorPixel(int x, int y) const;
    /// From sensor coordinates (pixel centres at whole numbers) to display coordinates (pixel edges at whole numbers),
    /// homogeneous.
    [[nodiscard]] Eigen::Matrix3f displayFromSensor() const;
};

/// The projection with which a mesh lies exactly on the person in the picture.
Projection mirrorProjection(const MirrorMapping& mapping, const hal::Intrinsics& intrinsics,
                            const fitting::SensorPlacement& placement);

/// Keeps the shopper in the crop: at rest while they stand near its middle, easing after them when they walk.
/// Thread-bound.
class CropFollower {
  public:
    /// The mapping for one frame. `skeleton` may be absent: the crop stays where it was, at first in the middle.
    MirrorMapping follow(int pictureWidth, int pictureHeight, int displayWidth, int displayHeight, Turn turn,
                         const hal::Intrinsics& intrinsics, const fitting::SensorPlacement& placement,
                         const fitting::Skeleton& skeleton);

  private:
    float centre_ = 0.5F;  ///< Of the crop, as a part of the mirrored picture's width.
    bool followed_ = false;
    hal::TimePoint lastTime_{};
};

}  // namespace cheval::render

// The avatar view's studio and camera: a calm backdrop, a soft shadow on the floor, a figure that stays framed.
#pragma once

#include "fitting/skeleton.h"
#include "hal/clock.h"
#include "hal/image.h"
#include "render/projection.h"

namespace cheval::render {

/// Thread-bound.
class AvatarView {
  public:
    /// Paints the backdrop, once: some dozens of milliseconds that no frame has to spare.
    AvatarView(int width, int height) : width_(width), height_(height) { paintBackdrop(); }

    /// The camera for this frame: before the figure, easing after it; mirrored, as the glass is.
    Projection follow(const fitting::Skeleton& skeleton);
    /// The studio without the figure. `figure`: whether somebody stands there and throws a shadow.
    void draw(const Projection& projection, const fitting::Skeleton& skeleton, bool figure,
              hal::ImageView<hal::Rgba8> target);

  private:
    void paintBackdrop();
    void shadow(const Projection& projection, const Eigen::Vector3f& centre, const Eigen::Vector2f& radii, float depth,
                hal::ImageView<hal::Rgba8> target) const;

    int width_, height_;
    hal::Image<hal::Rgba8> backdrop_;
    Eigen::Vector2f root_{0.0F, 2.0F};  ///< x and z of where the figure stands, mirror frame.
    bool followed_ = false;
    hal::TimePoint lastTime_{};
};

}  // namespace cheval::render

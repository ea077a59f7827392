// A picture out of depth alone, for sensors without colour: the shopper as softly lit clay, warm against a dark, calm
// room.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/image.h"
#include "render/mirror_mapping.h"
#include "render/renderer.h"

namespace cheval::render {

/// Thread-bound; takes memory only when the picture's size changes.
class DepthShading {
  public:
    /// The camera's depth as a picture of the same size, of which only what `mapping` shows on a display of
    /// `displayWidth` × `displayHeight` is drawn. Valid until the next call.
    hal::ImageView<const hal::Rgb8> shade(const CameraPicture& camera, const MirrorMapping& mapping, int displayWidth,
                                          int displayHeight);

  private:
    struct Region {
        int x0 = 0, y0 = 0, width = 0, height = 0;
    };
    void steady(const CameraPicture& camera, const Region& region);
    void boxBlur(const Region& region, std::vector<float>& values);
    void repair(const Region& region);
    void flatten(const Region& region);
    void light(const CameraPicture& camera, const MirrorMapping& mapping, const Region& region);

    hal::Image<hal::Rgb8> picture_;
    int width_ = 0, height_ = 0;
    std::vector<float> steady_;  ///< Metres, averaged over time where nothing moves; 0: no reading.
    // All of the region, row after row:
    std::vector<float> person_;       ///< 1 = shopper; blurred: the share of shopper around.
    std::vector<float> personDepth_;  ///< Metres times person_.
    std::vector<float> scene_;        ///< 1 = reading, not of the shopper; blurred likewise.
    std::vector<float> depth_;        ///< Repaired and smoothed within surfaces; 0: nothing there.
    std::vector<float> alpha_;        ///< How much of the shopper a pixel shows.
    std::vector<float> scratch_, weight_;
};

}  // namespace cheval::render

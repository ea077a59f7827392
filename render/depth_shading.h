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
    void blur(const Region& region, bool person, std::vector<float>& depth, std::vector<float>& weight);
    void boxBlur(const Region& region, std::vector<float>& values);
    void light(const CameraPicture& camera, const MirrorMapping& mapping, const Region& region);

    hal::Image<hal::Rgb8> picture_;
    int width_ = 0, height_ = 0;
    std::vector<float> steady_;         ///< Metres, averaged over time where nothing moves; 0: no reading.
    std::vector<std::uint8_t> person_;  ///< Of the region below: 1 = shopper, 0 = scene.
    std::vector<float> personDepth_, personWeight_, sceneDepth_, sceneWeight_, scratch_, column_;
};

}  // namespace cheval::render

// The head-up display: attract screen, prompt, carousel, size advice, hand cursors, service screen. Sized for reading
// at two metres on a portrait display of 1080×1920, and scaled with it.
#pragma once

#include <array>
#include <vector>

#include "hal/expected.h"
#include "hal/image.h"
#include "render/hud_layer.h"
#include "render/hud_state.h"

namespace cheval::render {

/// Thread-bound. Takes memory only when a text changes.
class Hud {
  public:
    static Expected<Hud> create(int width, int height);
    void draw(const HudState& state, hal::ImageView<hal::Rgba8> target);

  private:
    Hud(int width, int height);
    void refresh(const HudState& state);
    void drawTitle(Pen& pen, const HudState& state) const;
    void drawPrompt(Pen& pen, const HudState& state) const;
    void drawCarousel(Pen& pen, const HudState& state) const;
    void drawAdvice(Pen& pen, const HudState& state) const;
    void drawService(Pen& pen, const HudState& state) const;
    void drawCursor(Pen& pen, fitting::HandState hand) const;

    double unit_;  ///< Display pixels a pixel of the 1080×1920 design.
    int width_, height_;
    std::vector<HudLayer> layers_;  ///< As Layer in hud.cpp numbers them.
    HudState drawn_;                ///< What the layers show.
    bool fresh_ = false;
};

}  // namespace cheval::render

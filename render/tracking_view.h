// What tracking makes of a depth frame, drawn over that frame for technicians: users, joints, hand regions, gestures,
// floor. As the sensor sees it: neither mirrored nor turned upright. On the CPU alone, without GL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fitting/body.h"
#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "fitting/users.h"
#include "hal/clock.h"
#include "hal/expected.h"
#include "hal/frame.h"
#include "hal/image.h"
#include "render/depth_relief.h"

namespace cheval::render {

class HudLayer;
class Pen;

/// One frame and its results, as their own headers define them. All borrowed for the time of a call.
struct TrackingPicture {
    const hal::DepthFrame* frame = nullptr;
    const fitting::Users* users = nullptr;        ///< Its map may be empty; else it has the size of the depth picture.
    const fitting::Skeleton* skeleton = nullptr;  ///< Of the active user.
    const fitting::Hands* hands = nullptr;
    fitting::SensorPlacement placement;
    float handRegion = 0.0F;         ///< Side of the square in which a hand is read, metres; 0: hands are not read.
    fitting::Measurement stature{};  ///< Of the active user.
};

/// Draws the view. Remembers gestures for as long as they are shown. Thread-bound.
///
/// What is drawn: depth as a grey relief, no reading dark; each user tinted, the active one strongest and outlined;
/// lines on the floor a metre apart where nothing hides them; bones and joints, the shopper's left warm and right cold,
/// joints of confidence ≥ 0.5 filled and with solid bones, others hollow and dashed; a square about each hand with its
/// state and the state's confidence, dashed where the hand was not seen, and a ring that fills while it is held still;
/// gestures while they are new; figures in words.
class TrackingView {
  public:
    /// For depth pictures of this size; `scale` picture pixels a depth pixel, 1 … 4.
    /// Errors: invalidInput (a size or scale out of range), resource.
    static Expected<TrackingView> create(int depthWidth, int depthHeight, int scale = 2);
    ~TrackingView();
    TrackingView(TrackingView&&) noexcept;
    TrackingView& operator=(TrackingView&&) noexcept;

    /// Takes in the gestures of a frame; to be called for every frame, also for those that are not drawn.
    void follow(const TrackingPicture& picture);
    /// Draws a frame that follow() has seen. Valid until the next call.
    /// Errors: invalidInput (part of `picture` is missing, or the depth picture has another size).
    Expected<hal::ImageView<const hal::Rgba8>> draw(const TrackingPicture& picture);

    /// How long a gesture stays in the picture.
    static constexpr hal::Duration kGestureShown = std::chrono::milliseconds(1200);

    static constexpr hal::Rgba8 kLeftColour{.r = 255, .g = 150, .b = 50, .a = 255};
    static constexpr hal::Rgba8 kRightColour{.r = 70, .g = 190, .b = 255, .a = 255};
    static constexpr hal::Rgba8 kMiddleColour{.r = 250, .g = 250, .b = 245, .a = 255};
    /// The tint of a user, by id.
    static hal::Rgba8 userColour(std::uint32_t id);

  private:
    TrackingView(std::unique_ptr<HudLayer> layer, int depthWidth, int depthHeight, int scale);
    /// Empty where there is none of the right size.
    [[nodiscard]] hal::ImageView<const std::uint8_t> userMap(const TrackingPicture& picture) const;
    void drawPixels(const TrackingPicture& picture);
    void drawOver(Pen& pen, const TrackingPicture& picture) const;
    void drawFloor(Pen& pen, const TrackingPicture& picture) const;
    void drawUsers(Pen& pen, const TrackingPicture& picture) const;
    void drawBones(Pen& pen, const TrackingPicture& picture) const;
    void drawHand(Pen& pen, const TrackingPicture& picture, fitting::Side side) const;
    /// A ring that fills clockwise from its top while a hand is held still.
    static void drawHolding(Pen& pen, const Eigen::Vector2f& at, double radius, float holding, hal::Rgba8 colour);
    void drawGestures(Pen& pen) const;
    void drawWords(Pen& pen, const TrackingPicture& picture) const;
    /// A line of text on a dark ground with its left upper corner there, in depth pixels, kept within the picture.
    void label(Pen& pen, const std::string& text, double size, hal::Rgba8 colour, double x, double y) const;
    /// Where a point of the mirror frame lies, depth pixels; false: behind the sensor, or nowhere.
    static bool place(const TrackingPicture& picture, const Eigen::Vector3f& mirror, Eigen::Vector2f& pixel);

    std::unique_ptr<HudLayer> layer_;
    DepthRelief relief_;
    hal::Image<hal::Rgba8> picture_;
    int depthWidth_, depthHeight_, scale_;
    std::vector<fitting::GestureEvent> gestures_;  ///< Those still shown.
};

}  // namespace cheval::render

#include "render/tracking_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>
#include <utility>

#include "render/hud_layer.h"

namespace cheval::render {
namespace {

using fitting::GestureEvent;
using fitting::GestureKind;
using fitting::HandState;
using fitting::Joint;
using fitting::Side;

constexpr int kLargestSide = 4096;
constexpr float kSeen = 0.5F;

// Sizes in depth pixels.
constexpr double kJointRadius = 3.6;
constexpr double kBoneWidth = 2.0;
constexpr double kTextSize = 9.5;
constexpr double kSmallText = 8.0;
constexpr double kGestureText = 13.0;
constexpr double kMargin = 5.0;
constexpr double kHoldingGap = 6.0;  ///< From the hand's square to the ring about it.
constexpr double kHoldingWidth = 3.0;

constexpr hal::Rgba8 kInk{.r = 235, .g = 235, .b = 230, .a = 255};
constexpr hal::Rgba8 kFloorColour{.r = 225, .g = 225, .b = 120, .a = 255};
constexpr hal::Rgba8 kAheadColour{.r = 255, .g = 235, .b = 90, .a = 255};

enum class Part : std::uint8_t { middle, left, right };

Part partOf(Joint joint) {
    const std::string_view name = fitting::kJointNames[fitting::index(joint)];
    if (name.starts_with("left")) return Part::left;
    return name.starts_with("right") ? Part::right : Part::middle;
}

hal::Rgba8 colourOf(Part part) {
    switch (part) {
        case Part::left:
            return TrackingView::kLeftColour;
        case Part::right:
            return TrackingView::kRightColour;
        case Part::middle:
            break;
    }
    return TrackingView::kMiddleColour;
}

void setColour(Pen& pen, hal::Rgba8 colour, double alpha = 1.0) {
    pen.colour(colour.r / 255.0, colour.g / 255.0, colour.b / 255.0, alpha);
}

/// A stroke with a dark rim, so that it shows on any ground.
void stroke(Pen& pen, double width, hal::Rgba8 colour, bool dashed) {
    cairo_t* cairo = pen.cairo();
    constexpr double kDash[] = {3.0, 2.5};
    cairo_set_dash(cairo, kDash, dashed ? 2 : 0, 0.0);
    cairo_set_line_cap(cairo, dashed ? CAIRO_LINE_CAP_BUTT : CAIRO_LINE_CAP_ROUND);
    pen.colour(0.0, 0.0, 0.0, 0.65);
    cairo_set_line_width(cairo, width + 1.2);
    cairo_stroke_preserve(cairo);
    setColour(pen, colour);
    cairo_set_line_width(cairo, width);
    cairo_stroke(cairo);
    cairo_set_dash(cairo, nullptr, 0, 0.0);
}

std::string words(const GestureEvent& gesture) {
    std::string hand = gesture.hand == Side::left ? "left hand" : "right hand";
    switch (gesture.kind) {
        case GestureKind::swipe:
            return (gesture.direction == fitting::SwipeDirection::left ? "swipe to the left, "
                                                                       : "swipe to the right, ") +
                   hand;
        case GestureKind::grab:
            return "grab, " + hand;
        case GestureKind::raise:
            return "raise, " + hand;
        case GestureKind::hold:
            return "hold, " + hand;
    }
    return hand;
}

template <typename... Values>
std::string format(const char* pattern, Values... values) {
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(), pattern, values...);
    return text.data();
}

/// To a tenth, and never −0.
double degrees(float radians) {
    return std::round(static_cast<double>(radians) * 1800.0 / std::numbers::pi) / 10.0 + 0.0;
}

}  // namespace

hal::Rgba8 TrackingView::userColour(std::uint32_t id) {
    // Far from the colours of left and right and from each other, also to eyes that see no red.
    constexpr std::array<hal::Rgba8, fitting::kMaximumUsers> kColours = {{{.r = 110, .g = 235, .b = 120},
                                                                          {.r = 205, .g = 130, .b = 255},
                                                                          {.r = 255, .g = 240, .b = 100},
                                                                          {.r = 255, .g = 130, .b = 190},
                                                                          {.r = 120, .g = 130, .b = 255},
                                                                          {.r = 130, .g = 240, .b = 230}}};
    return kColours[(id + kColours.size() - 1) % kColours.size()];
}

Expected<TrackingView> TrackingView::create(int depthWidth, int depthHeight, int scale) {
    if (depthWidth < 1 || depthHeight < 1 || scale < 1 || scale > 4 || depthWidth > kLargestSide / scale ||
        depthHeight > kLargestSide / scale) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = format("a tracking view of %d × %d depth pixels, times %d, cannot be drawn", depthWidth,
                                     depthHeight, scale)};
    }
    Expected<HudLayer> layer = HudLayer::create(0, 0, depthWidth * scale, depthHeight * scale);
    if (!layer) return std::move(layer).error();
    return TrackingView(std::make_unique<HudLayer>(std::move(*layer)), depthWidth, depthHeight, scale);
}

TrackingView::TrackingView(std::unique_ptr<HudLayer> layer, int depthWidth, int depthHeight, int scale)
    : layer_(std::move(layer)),
      picture_(depthWidth * scale, depthHeight * scale),
      depthWidth_(depthWidth),
      depthHeight_(depthHeight),
      scale_(scale) {}

TrackingView::~TrackingView() = default;
TrackingView::TrackingView(TrackingView&&) noexcept = default;
TrackingView& TrackingView::operator=(TrackingView&&) noexcept = default;

void TrackingView::follow(const TrackingPicture& picture) {
    if (picture.frame == nullptr || picture.hands == nullptr) return;
    if (picture.frame->restart) gestures_.clear();
    const hal::TimePoint now = picture.frame->captureTime;
    std::erase_if(gestures_, [now](const GestureEvent& gesture) { return gesture.end + kGestureShown < now; });
    const auto begin = picture.hands->gestures.begin();
    const std::size_t count = std::min(picture.hands->gestureCount, picture.hands->gestures.size());
    gestures_.insert(gestures_.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
}

Expected<hal::ImageView<const hal::Rgba8>> TrackingView::draw(const TrackingPicture& picture) {
    const bool whole =
        picture.frame != nullptr && picture.users != nullptr && picture.skeleton != nullptr && picture.hands != nullptr;
    if (!whole || picture.frame->depth.empty() || picture.frame->depth.width != depthWidth_ ||
        picture.frame->depth.height != depthHeight_) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = format("the tracking view draws depth pictures of %d × %d pixels, with all their results",
                                     depthWidth_, depthHeight_)};
    }
    drawPixels(picture);
    layer_->redraw([&](Pen& pen) {
        cairo_save(pen.cairo());
        cairo_scale(pen.cairo(), scale_, scale_);
        drawOver(pen, picture);
        cairo_restore(pen.cairo());
    });
    layer_->blend(picture_.view());
    return std::as_const(picture_).view();
}

hal::ImageView<const std::uint8_t> TrackingView::userMap(const TrackingPicture& picture) const {
    const auto& map = picture.users->map;
    return !map.empty() && map.width == depthWidth_ && map.height == depthHeight_
               ? map
               : hal::ImageView<const std::uint8_t>{};
}

void TrackingView::drawPixels(const TrackingPicture& picture) {
    const hal::ImageView<const std::uint8_t> relief = relief_.light(picture.frame->depth, picture.frame->intrinsics);
    const hal::ImageView<const std::uint8_t> map = userMap(picture);
    struct Tint {
        hal::Rgba8 colour;
        int share = 0;  ///< Of 256.
    };
    std::array<Tint, 256> tints{};
    std::uint8_t activeLabel = 0;
    for (std::size_t i = 0; i < picture.users->count; ++i) {
        const fitting::User& user = picture.users->users[i];
        const bool active = user.id == picture.users->activeId;
        tints[user.label] = {.colour = userColour(user.id), .share = active ? 170 : 90};
        if (active) activeLabel = user.label;
    }
    tints[0] = {};
    const auto labelAt = [&](int x, int y) { return map.contains(x, y) ? map.at(x, y) : std::uint8_t{0}; };
    for (int y = 0; y < depthHeight_; ++y) {
        for (int x = 0; x < depthWidth_; ++x) {
            const int grey = relief.at(x, y);
            const std::uint8_t label = labelAt(x, y);
            const Tint& tint = tints[label];
            // A coloured light on the relief: shapes stay readable under it.
            const auto lit = [&](int channel) {
                return static_cast<std::uint8_t>(grey * (256 * 255 + tint.share * (channel - 255)) / (256 * 255));
            };
            hal::Rgba8 pixel{.r = lit(tint.colour.r), .g = lit(tint.colour.g), .b = lit(tint.colour.b)};
            const bool outline = label != 0 && label == activeLabel &&
                                 (labelAt(x - 1, y) != label || labelAt(x + 1, y) != label ||
                                  labelAt(x, y - 1) != label || labelAt(x, y + 1) != label);
            if (outline) pixel = tint.colour;
            for (int dy = 0; dy < scale_; ++dy)
                std::fill_n(picture_.view().row(y * scale_ + dy) + static_cast<std::ptrdiff_t>(x) * scale_, scale_,
                            pixel);
        }
    }
}

void TrackingView::drawOver(Pen& pen, const TrackingPicture& picture) const {
    drawFloor(pen, picture);
    drawUsers(pen, picture);
    if (picture.skeleton->present()) {
        drawBones(pen, picture);
        drawHand(pen, picture, Side::left);
        drawHand(pen, picture, Side::right);
    }
    drawGestures(pen);
    drawWords(pen, picture);
}

bool TrackingView::place(const TrackingPicture& picture, const Eigen::Vector3f& mirror, Eigen::Vector2f& pixel) {
    const Eigen::Vector3f sensor = picture.placement.toSensor(mirror);
    if (!sensor.allFinite() || sensor.z() < 50.0F) return false;
    pixel = fitting::project(picture.frame->intrinsics, sensor);
    return true;
}

void TrackingView::drawFloor(Pen& pen, const TrackingPicture& picture) const {
    constexpr float kStep = 0.04F;
    constexpr float kHalfWidth = 1.5F;
    constexpr int kFarthest = 4;
    // What stands before the floor, by more than the floor's own noise, hides it.
    constexpr float kBeforeIt = 120.0F;
    cairo_t* cairo = pen.cairo();
    const hal::ImageView<const std::uint16_t> depth = picture.frame->depth;
    const auto line = [&](const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
        bool drawing = false;
        const int steps = static_cast<int>(std::lround((to - from).norm() / kStep));
        for (int i = 0; i <= steps; ++i) {
            const Eigen::Vector3f at = from + (to - from) * (static_cast<float>(i) / static_cast<float>(steps));
            Eigen::Vector2f pixel;
            bool shown = place(picture, at, pixel);
            const int u = shown ? static_cast<int>(std::lround(std::clamp(pixel.x(), -1.0F, 8192.0F))) : -1;
            const int v = shown ? static_cast<int>(std::lround(std::clamp(pixel.y(), -1.0F, 8192.0F))) : -1;
            shown = depth.contains(u, v);
            if (shown && depth.at(u, v) != 0)
                shown = picture.placement.toSensor(at).z() < static_cast<float>(depth.at(u, v)) + kBeforeIt;
            if (shown && drawing)
                cairo_line_to(cairo, pixel.x() + 0.5, pixel.y() + 0.5);
            else if (shown)
                cairo_move_to(cairo, pixel.x() + 0.5, pixel.y() + 0.5);
            drawing = shown;
        }
    };
    for (int metres = 1; metres <= kFarthest; ++metres) {
        const auto z = static_cast<float>(metres);
        line({-kHalfWidth, 0.0F, z}, {kHalfWidth, 0.0F, z});
    }
    line({0.0F, 0.0F, 0.5F}, {0.0F, 0.0F, static_cast<float>(kFarthest)});
    setColour(pen, kFloorColour, 0.75);
    cairo_set_line_width(cairo, 0.8);
    cairo_stroke(cairo);
    for (int metres = 1; metres <= kFarthest; ++metres) {
        Eigen::Vector2f pixel;
        // At the picture's right, where people seldom stand.
        const Eigen::Vector3f end(-kHalfWidth, 0.0F, static_cast<float>(metres));
        if (!place(picture, end, pixel) || !depth.contains(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())))
            continue;
        label(pen, format("%d m", metres), kSmallText, kFloorColour, pixel.x() + 2.0, pixel.y() - 5.0);
    }
}

void TrackingView::drawUsers(Pen& pen, const TrackingPicture& picture) const {
    constexpr int kAboutTheMiddle = 20;
    const hal::ImageView<const std::uint8_t> map = userMap(picture);
    for (std::size_t i = 0; i < picture.users->count; ++i) {
        const fitting::User& user = picture.users->users[i];
        Eigen::Vector2f top;
        if (!place(picture, {user.centroid.x(), user.upper.y(), user.centroid.z()}, top)) continue;
        // The box's top is that of a raised hand; what is wanted is that of the head, above the middle.
        const int middle = static_cast<int>(std::clamp(top.x(), 0.0F, static_cast<float>(depthWidth_ - 1)));
        for (int y = 0; y < map.height; ++y) {
            const std::uint8_t* row = map.row(y);
            const std::uint8_t* first = row + std::max(0, middle - kAboutTheMiddle);
            const std::uint8_t* end = row + std::min(map.width, middle + kAboutTheMiddle);
            if (std::find(first, end, user.label) == end) continue;
            top.y() = static_cast<float>(y);
            break;
        }
        const bool active = user.id == picture.users->activeId;
        label(pen, format(active ? "user %u, active" : "user %u", static_cast<unsigned>(user.id)), kTextSize,
              userColour(user.id), top.x() - 22.0, top.y() - 16.0);
    }
}

void TrackingView::drawBones(Pen& pen, const TrackingPicture& picture) const {
    const fitting::Skeleton& skeleton = *picture.skeleton;
    cairo_t* cairo = pen.cairo();
    std::array<Eigen::Vector2f, fitting::kJointCount> at;
    std::array<bool, fitting::kJointCount> placed{};
    for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
        placed[i] = place(picture, skeleton.joints[i].position, at[i]);
        at[i].array() += 0.5F;
    }
    // What is only estimated first, so that it never covers what was seen.
    for (const bool seen : {false, true}) {
        for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
            const std::size_t parent = fitting::index(fitting::kJointParent[i]);
            if (parent == i || !placed[i] || !placed[parent]) continue;
            const bool both = skeleton.joints[i].confidence >= kSeen && skeleton.joints[parent].confidence >= kSeen;
            if (both != seen) continue;
            cairo_move_to(cairo, at[parent].x(), at[parent].y());
            cairo_line_to(cairo, at[i].x(), at[i].y());
            stroke(pen, kBoneWidth, colourOf(partOf(static_cast<Joint>(i))), !seen);
        }
    }
    // Which way the chest faces, a quarter of a metre long: a full-face view shows a point.
    const fitting::JointState& torso = skeleton[Joint::torso];
    Eigen::Vector2f ahead;
    if (placed[fitting::index(Joint::torso)] &&
        place(picture, torso.position + torso.orientation * Eigen::Vector3f(0.0F, 0.0F, 0.25F), ahead)) {
        cairo_move_to(cairo, at[fitting::index(Joint::torso)].x(), at[fitting::index(Joint::torso)].y());
        cairo_line_to(cairo, ahead.x() + 0.5, ahead.y() + 0.5);
        stroke(pen, 1.0, kAheadColour, false);
    }
    for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
        if (!placed[i]) continue;
        const hal::Rgba8 colour = colourOf(partOf(static_cast<Joint>(i)));
        const bool seen = skeleton.joints[i].confidence >= kSeen;
        pen.colour(0.0, 0.0, 0.0, seen ? 0.75 : 0.45);
        pen.fillCircle(at[i].x(), at[i].y(), kJointRadius + 1.0);
        if (seen) {
            setColour(pen, colour);
            pen.fillCircle(at[i].x(), at[i].y(), kJointRadius);
            continue;
        }
        cairo_new_sub_path(cairo);
        cairo_arc(cairo, at[i].x(), at[i].y(), kJointRadius - 0.5, 0.0, 2.0 * std::numbers::pi);
        stroke(pen, 1.0, colour, false);
    }
}

void TrackingView::drawHand(Pen& pen, const TrackingPicture& picture, Side side) const {
    const fitting::Hand& hand = (*picture.hands)[side];
    const fitting::JointState& joint = (*picture.skeleton)[side == Side::left ? Joint::leftHand : Joint::rightHand];
    const float depth = picture.placement.toSensor(hand.position).z();
    Eigen::Vector2f at;
    if (picture.handRegion <= 0.0F || !place(picture, hand.position, at)) return;
    const double half = 0.5 * picture.handRegion * 1e3 * picture.frame->intrinsics.fx / depth;
    cairo_rectangle(pen.cairo(), at.x() + 0.5 - half, at.y() + 0.5 - half, 2.0 * half, 2.0 * half);
    const hal::Rgba8 colour = side == Side::left ? kLeftColour : kRightColour;
    stroke(pen, hand.raised ? 1.8 : 1.0, colour, joint.confidence < kSeen);
    drawHolding(pen, at, half + kHoldingGap, hand.holding, colour);
    const std::string state(fitting::nameOf(hand.state));
    // Above the square, or below it where the status line is.
    const double above = at.y() - half - 15.0;
    label(pen, hand.state == HandState::unknown ? state : state + format(" %.2f", hand.confidence), kTextSize, colour,
          at.x() - half, above < 20.0 ? at.y() + half + 4.0 : above);
}

void TrackingView::drawHolding(Pen& pen, const Eigen::Vector2f& at, double radius, float holding, hal::Rgba8 colour) {
    if (!(holding > 0.0F)) return;
    cairo_t* cairo = pen.cairo();
    const double top = -0.5 * std::numbers::pi;
    const double end = top + 2.0 * std::numbers::pi * std::min(1.0, static_cast<double>(holding));
    cairo_new_sub_path(cairo);
    cairo_arc(cairo, at.x() + 0.5, at.y() + 0.5, radius, 0.0, 2.0 * std::numbers::pi);
    setColour(pen, colour, 0.3);
    cairo_set_line_width(cairo, 1.0);
    cairo_stroke(cairo);
    cairo_new_sub_path(cairo);
    cairo_arc(cairo, at.x() + 0.5, at.y() + 0.5, radius, top, end);
    stroke(pen, kHoldingWidth, colour, false);
}

void TrackingView::drawGestures(Pen& pen) const {
    // Beside the person, on the side of the hand: the right hand of who faces the sensor is at the picture's left.
    std::array<double, fitting::kSideCount> y{};
    y.fill(2.0 * kMargin + 14.0);
    for (const GestureEvent& gesture : gestures_) {
        const bool left = gesture.hand == Side::left;
        double& down = y[fitting::index(gesture.hand)];
        label(pen, words(gesture), kGestureText, left ? kLeftColour : kRightColour, left ? depthWidth_ : kMargin, down);
        down += 1.8 * kGestureText;
    }
}

void TrackingView::drawWords(Pen& pen, const TrackingPicture& picture) const {
    const fitting::Users& users = *picture.users;
    const fitting::Skeleton& skeleton = *picture.skeleton;
    std::string text = format("frame %llu   %.2f s   ", static_cast<unsigned long long>(picture.frame->sourceIndex),
                              hal::seconds(picture.frame->captureTime));
    if (users.activeId == 0)
        text += users.count == 0 ? "nobody" : format("nobody active, %zu in view", users.count);
    else
        text += format("user %u active of %zu", static_cast<unsigned>(users.activeId), users.count);
    if (picture.stature.valid)
        text += format("   stature %.2f ± %.2f m", picture.stature.value, picture.stature.uncertainty);
    if (skeleton.present()) {
        const auto seen = std::count_if(skeleton.joints.begin(), skeleton.joints.end(),
                                        [](const fitting::JointState& joint) { return joint.confidence >= kSeen; });
        text += format("   joints seen %d of %zu", static_cast<int>(seen), fitting::kJointCount);
    } else if (users.activeId != 0) {
        text += "   no joints";
    }
    label(pen, text, kTextSize, kInk, kMargin, kMargin);

    const Eigen::Matrix3f& r = picture.placement.rotation;
    const double bottom = depthHeight_ - kMargin - 14.0;
    label(pen,
          format("sensor taken to be %.2f m high, tilt %+.1f°, roll %+.1f°", picture.placement.translation.y(),
                 degrees(std::atan2(r(1, 2), r(2, 2))), degrees(std::atan2(r(0, 1), -r(0, 0)))),
          kTextSize, kFloorColour, kMargin, bottom);
    label(pen, "left", kTextSize, kLeftColour, depthWidth_ - 165.0, bottom);
    label(pen, "right", kTextSize, kRightColour, depthWidth_ - 137.0, bottom);
    label(pen, "● seen  ○ estimated", kTextSize, kInk, depthWidth_ - 104.0, bottom);
}

void TrackingView::label(Pen& pen, const std::string& text, double size, hal::Rgba8 colour, double x, double y) const {
    const TextStyle style{.size = size,
                          .weight = size >= kGestureText ? PANGO_WEIGHT_BOLD : PANGO_WEIGHT_NORMAL,
                          .red = colour.r / 255.0,
                          .green = colour.g / 255.0,
                          .blue = colour.b / 255.0,
                          .align = Align::left};
    const auto [width, height] = pen.measure(text, style, depthWidth_);
    constexpr double kPadding = 2.0;
    const double left = std::clamp(x, kPadding, std::max(kPadding, depthWidth_ - width - kPadding));
    const double top = std::clamp(y, kPadding, std::max(kPadding, depthHeight_ - height - kPadding));
    pen.colour(0.0, 0.0, 0.0, 0.62);
    pen.fillRoundedBox(left - kPadding, top - 1.0, width + 2.0 * kPadding, height + 2.0, 2.0);
    pen.text(text, style, left, top, width + 2.0);
}

}  // namespace cheval::render

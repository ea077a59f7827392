#include "render/tracking_view.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::render {
namespace {

using fitting::Joint;
using fitting::Side;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kScale = 2;

/// A block of a person, 2 m before a level sensor at 1.25 m, another beside it, and a wall at 3.5 m; a band without
/// readings at the left.
class TrackingViewTest : public testing::Test {
  protected:
    TrackingViewTest() : depth_(kWidth, kHeight, 3500), map_(kWidth, kHeight) {
        fill(260, 380, 100, 480, 2000, 1);
        fill(500, 560, 150, 400, 2500, 2);
        fill(0, 40, 0, kHeight, 0, 0);
        frame_.depth = std::as_const(depth_).view();
        frame_.captureTime = hal::TimePoint(std::chrono::seconds(7));
        users_.count = 2;
        users_.users[0] = {.id = 1, .centroid = {0, 1, 2}, .upper = {0.2F, 1.7F, 2.1F}, .label = 1};
        users_.users[1] = {.id = 2, .centroid = {-0.9F, 1, 2.5F}, .upper = {-0.8F, 1.6F, 2.6F}, .label = 2};
        users_.activeId = 1;
        users_.map = std::as_const(map_).view();
        placement_.translation.y() = 1.25F;
        skeleton_.userId = 1;
        for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
            // Side by side on the person, so that none hides another.
            const std::size_t row = i / 5;
            skeleton_.joints[i].position = {0.16F - 0.08F * static_cast<float>(i % 5),
                                            1.35F - 0.3F * static_cast<float>(row), 2.05F};
            skeleton_.joints[i].confidence = 0.9F;
        }
    }
    void fill(int left, int right, int top, int bottom, std::uint16_t depth, std::uint8_t label) {
        for (int y = top; y < bottom; ++y) {
            std::fill(depth_.view().row(y) + left, depth_.view().row(y) + right, depth);
            std::fill(map_.view().row(y) + left, map_.view().row(y) + right, label);
        }
    }
    [[nodiscard]] TrackingPicture picture() const {
        return {.frame = &frame_,
                .users = &users_,
                .skeleton = &skeleton_,
                .hands = &hands_,
                .placement = placement_,
                .handRegion = handRegion_};
    }
    /// A copy of what is drawn.
    hal::Image<hal::Rgba8> drawn() {
        view_.follow(picture());
        const auto drawing = view_.draw(picture());
        EXPECT_TRUE(drawing);
        hal::Image<hal::Rgba8> copy;
        if (drawing) hal::copyInto(*drawing, copy);
        return copy;
    }
    [[nodiscard]] Eigen::Vector2f pixelOf(const Eigen::Vector3f& mirror) const {
        const Eigen::Vector2f at = fitting::project(frame_.intrinsics, placement_.toSensor(mirror));
        return (at.array() + 0.5F) * static_cast<float>(kScale);
    }
    static hal::Rgba8 at(const hal::Image<hal::Rgba8>& image, const Eigen::Vector2f& pixel) {
        return image.view().at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    }
    static hal::Rgba8 at(const hal::Image<hal::Rgba8>& image, int u, int v) {
        return image.view().at(u * kScale, v * kScale);
    }
    static int apart(hal::Rgba8 a, hal::Rgba8 b) {
        return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
    }
    static int colourfulness(hal::Rgba8 pixel) {
        return std::max({pixel.r, pixel.g, pixel.b}) - std::min({pixel.r, pixel.g, pixel.b});
    }
    void gesture(fitting::GestureKind kind) {
        hands_.gestureCount = 1;
        hands_.gestures[0] = {.kind = kind, .hand = Side::right, .end = frame_.captureTime};
    }
    void later(hal::Duration by) {
        frame_.captureTime += by;
        hands_.gestureCount = 0;
    }

    hal::Image<std::uint16_t> depth_;
    hal::Image<std::uint8_t> map_;
    hal::DepthFrame frame_;
    fitting::Users users_;
    fitting::Skeleton skeleton_;
    fitting::Hands hands_;
    fitting::SensorPlacement placement_;
    float handRegion_ = 0.0F;
    TrackingView view_ = std::move(TrackingView::create(kWidth, kHeight, kScale)).value();
};

TEST_F(TrackingViewTest, RefusesSizesAndFramesThatDoNotFit) {
    EXPECT_FALSE(TrackingView::create(0, 480));
    EXPECT_FALSE(TrackingView::create(640, 480, 0));
    EXPECT_FALSE(TrackingView::create(640, 480, 5));
    EXPECT_FALSE(TrackingView::create(5000, 480, 1));
    EXPECT_FALSE(view_.draw({}));
    TrackingPicture lacking = picture();
    lacking.hands = nullptr;
    EXPECT_FALSE(view_.draw(lacking));
    const hal::Image<std::uint16_t> other(320, 240);
    frame_.depth = other.view();
    EXPECT_FALSE(view_.draw(picture()));
}

TEST_F(TrackingViewTest, DepthIsGreyAndNoReadingDark) {
    const hal::Image<hal::Rgba8> image = drawn();
    EXPECT_EQ(colourfulness(at(image, 150, 150)), 0) << "the wall is nobody's";
    EXPECT_GE(at(image, 150, 150).r, DepthRelief::kDarkestReading);
    EXPECT_EQ(at(image, 20, 150),
              (hal::Rgba8{
                  .r = DepthRelief::kNoReading, .g = DepthRelief::kNoReading, .b = DepthRelief::kNoReading, .a = 255}));
}

TEST_F(TrackingViewTest, UsersAreTintedTheActiveOneStrongest) {
    const hal::Image<hal::Rgba8> image = drawn();
    const int active = colourfulness(at(image, 270, 110));
    const int other = colourfulness(at(image, 520, 300));
    EXPECT_GT(active, other + 20);
    EXPECT_GT(other, 20);
    EXPECT_EQ(apart(at(image, 260, 300), TrackingView::userColour(1)), 0) << "its outline";
    for (std::uint32_t a = 1; a <= fitting::kMaximumUsers; ++a) {
        for (std::uint32_t b = 1; b < a; ++b)
            EXPECT_GT(apart(TrackingView::userColour(a), TrackingView::userColour(b)), 60) << a << " and " << b;
    }
}

TEST_F(TrackingViewTest, JointsLieWhereTheyProjectInTheColourOfTheirSide) {
    const hal::Image<hal::Rgba8> image = drawn();
    for (std::size_t i = 0; i < fitting::kJointCount; ++i) {
        const std::string_view name = fitting::kJointNames[i];
        const hal::Rgba8 expected = name.starts_with("left")    ? TrackingView::kLeftColour
                                    : name.starts_with("right") ? TrackingView::kRightColour
                                                                : TrackingView::kMiddleColour;
        EXPECT_LE(apart(at(image, pixelOf(skeleton_.joints[i].position)), expected), 8) << name;
    }
    // Who faces the sensor has the left at the picture's right: nothing is mirrored.
    skeleton_[Joint::leftHand].position.x() = -0.3F;
    EXPECT_GT(pixelOf(skeleton_[Joint::leftHand].position).x(), static_cast<float>(kScale) * kWidth / 2);
}

TEST_F(TrackingViewTest, JointsThatWereNotSeenAreHollow) {
    skeleton_[Joint::leftHand].confidence = 0.49F;
    const hal::Image<hal::Rgba8> image = drawn();
    const Eigen::Vector2f middle = pixelOf(skeleton_[Joint::leftHand].position);
    EXPECT_GT(apart(at(image, middle), TrackingView::kLeftColour), 100);
    // On the ring, whose middle line is 3.1 depth pixels out.
    const Eigen::Vector2f ring = middle + Eigen::Vector2f(0.0F, 3.1F * kScale);
    EXPECT_LE(apart(at(image, ring), TrackingView::kLeftColour), 60);
}

TEST_F(TrackingViewTest, ASquareAsLargeAsTheRegionIsAboutEachHand) {
    handRegion_ = 0.4F;
    for (const Side side : {Side::left, Side::right}) {
        const bool left = side == Side::left;
        hands_[side] = {.state = fitting::HandState::open,
                        .confidence = 0.8F,
                        .position = {left ? -0.6F : 0.6F, 1.2F, 2.0F},
                        .raised = true};
    }
    const hal::Image<hal::Rgba8> image = drawn();
    for (const Side side : {Side::left, Side::right}) {
        const hal::Rgba8 colour = side == Side::left ? TrackingView::kLeftColour : TrackingView::kRightColour;
        const Eigen::Vector3f& middle = hands_[side].position;
        for (const Eigen::Vector3f& edge :
             {Eigen::Vector3f(0.2F, 0, 0), Eigen::Vector3f(-0.2F, 0, 0), Eigen::Vector3f(0, -0.2F, 0)})
            EXPECT_LE(apart(at(image, pixelOf(middle + edge)), colour), 8);
        EXPECT_GT(apart(at(image, pixelOf(middle)), colour), 60);
    }
}

TEST_F(TrackingViewTest, ARingFillsClockwiseAboutAHandThatIsHeldStill) {
    handRegion_ = 0.2F;
    hands_[Side::right] = {.state = fitting::HandState::open, .position = {0.6F, 1.2F, 2.0F}, .raised = true};
    // 0.1 m at 2 m are 28.5 depth pixels; the ring is 6 farther out.
    const float radius = 34.5F * kScale;
    const Eigen::Vector2f middle = pixelOf(hands_[Side::right].position);
    const auto drawnAt = [&](const hal::Image<hal::Rgba8>& image, float turns) {
        const float angle = turns * 2.0F * std::numbers::pi_v<float>;
        const Eigen::Vector2f on = middle + radius * Eigen::Vector2f(std::sin(angle), -std::cos(angle));
        return apart(at(image, on), TrackingView::kRightColour) <= 8;
    };
    struct Case {
        float holding;
        std::array<bool, 4> drawn;  ///< After an eighth of a turn, three eighths, …
    };
    for (const Case& row : {Case{0.0F, {false, false, false, false}}, Case{0.25F, {true, false, false, false}},
                            Case{0.75F, {true, true, true, false}}, Case{1.0F, {true, true, true, true}}}) {
        hands_[Side::right].holding = row.holding;
        const hal::Image<hal::Rgba8> image = drawn();
        for (std::size_t i = 0; i < row.drawn.size(); ++i) {
            EXPECT_EQ(drawnAt(image, (2.0F * static_cast<float>(i) + 1.0F) / 8.0F), row.drawn[i])
                << row.holding << ", " << i;
        }
    }
}

TEST_F(TrackingViewTest, TheFloorShowsEveryMetreWhereNothingHidesIt) {
    fill(40, kWidth, 0, kHeight, 0, 0);
    users_.count = 0;
    users_.activeId = 0;
    skeleton_ = {};
    hal::Image<hal::Rgba8> image = drawn();
    const Eigen::Vector2f beside = pixelOf({-0.4F, 0.0F, 3.0F});
    const Eigen::Vector2f between = pixelOf({-0.4F, 0.0F, 3.5F});
    EXPECT_GT(at(image, beside).r, 80);
    EXPECT_EQ(at(image, between).r, DepthRelief::kNoReading);
    fill(40, kWidth, 0, kHeight, 1500, 0);
    image = drawn();
    EXPECT_EQ(colourfulness(at(image, beside)), 0) << "something stands before it";
}

TEST_F(TrackingViewTest, AGestureIsShownForAWhileEvenIfItsOwnFrameIsNotDrawn) {
    const hal::Image<hal::Rgba8> before = drawn();
    EXPECT_TRUE(before.pixels == drawn().pixels) << "same input, same bytes";
    gesture(fitting::GestureKind::swipe);
    view_.follow(picture());
    hands_.gestureCount = 0;
    const auto differs = [&](hal::Image<hal::Rgba8> now) {
        // Below the status line, which tells the time.
        const std::ptrdiff_t skipped = std::ptrdiff_t{kWidth} * kScale * 40;
        return !std::equal(before.pixels.begin() + skipped, before.pixels.end(), now.pixels.begin() + skipped);
    };
    EXPECT_TRUE(differs(drawn()));
    later(TrackingView::kGestureShown);
    EXPECT_TRUE(differs(drawn()));
    later(std::chrono::milliseconds(1));
    EXPECT_FALSE(differs(drawn()));
    gesture(fitting::GestureKind::grab);
    EXPECT_TRUE(differs(drawn()));
    later(TrackingView::kGestureShown + std::chrono::milliseconds(1));
    EXPECT_FALSE(differs(drawn()));
    gesture(fitting::GestureKind::hold);
    EXPECT_TRUE(differs(drawn()));
    later(std::chrono::milliseconds(33));
    frame_.restart = true;
    EXPECT_FALSE(differs(drawn())) << "another still begins";
}

TEST_F(TrackingViewTest, AMapOfAnotherSizeOrNoneIsNoMap) {
    const hal::Image<std::uint8_t> small(32, 24, 1);
    for (const hal::ImageView<const std::uint8_t> map : {small.view(), hal::ImageView<const std::uint8_t>{}}) {
        users_.map = map;
        EXPECT_EQ(colourfulness(at(drawn(), 270, 110)), 0);
    }
}

TEST_F(TrackingViewTest, PlacesThatAreNowhereAreLeftOut) {
    skeleton_[Joint::leftHand].position = {0.0F, 1.0F, -3.0F};
    skeleton_[Joint::rightHand].position.setConstant(std::numeric_limits<float>::quiet_NaN());
    skeleton_[Joint::leftFoot].position = {1e6F, -1e6F, 0.06F};
    hands_[Side::left].position = skeleton_[Joint::leftHand].position;
    hands_[Side::right].position = skeleton_[Joint::rightHand].position;
    handRegion_ = 0.4F;
    users_.users[1].upper.setConstant(std::numeric_limits<float>::infinity());
    const hal::Image<hal::Rgba8> image = drawn();
    EXPECT_LE(apart(at(image, pixelOf(skeleton_[Joint::neck].position)), TrackingView::kMiddleColour), 8);
}

}  // namespace
}  // namespace cheval::render

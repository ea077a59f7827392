// What no tracker can see through: a dead, covered, turned, slow or wrongly described sensor, and a dog. Nobody is made
// up, nothing is endless, and what is wrong is told.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "fitting/tracking/tracker.h"
#include "hal/sim/world.h"

namespace cheval::fitting {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr hal::Mount kMount{.heightMm = 1250.0F, .tiltDeg = -4.0F, .known = true};
/// Faults are believed after three seconds, whatever the rate.
constexpr double kSlowRate = 10.0;
constexpr int kLongEnough = 40;

using Depth = std::vector<std::uint16_t>;

Depth uniform(std::uint16_t millimetres) {
    return Depth(static_cast<std::size_t>(kWidth) * kHeight, millimetres);
}

/// A floor, and a wall at 3.6 m, as a sensor mounted at `kMount` sees them.
Depth emptyShop() {
    const hal::Intrinsics lens;
    const float tilt = kMount.tiltDeg * 3.14159265F / 180.0F;
    Depth depth = uniform(0);
    for (int v = 0; v < kHeight; ++v) {
        const float up = (lens.cy - static_cast<float>(v)) / lens.fy;
        // Height and distance from the glass gained along the sensor's axis, metre by metre.
        const float rise = std::cos(tilt) * up + std::sin(tilt);
        const float away = std::cos(tilt) - std::sin(tilt) * up;
        float z = 3.6F / away;
        if (rise < 0.0F) z = std::min(z, -1e-3F * kMount.heightMm / rise);
        std::fill_n(depth.begin() + static_cast<std::ptrdiff_t>(v) * kWidth, kWidth,
                    static_cast<std::uint16_t>(std::lround(1e3F * z)));
    }
    return depth;
}

/// Feeds a tracker, and looks at every answer.
class Watch {
  public:
    explicit Watch(double framesPerSecond = kSlowRate, const hal::Mount& mount = kMount)
        : period_(hal::fromSeconds(1.0 / framesPerSecond)), tracker_(TrackerOptions{.mount = mount}) {}

    void show(hal::ImageView<const std::uint16_t> depth, const hal::Intrinsics& intrinsics = {}) {
        const hal::DepthFrame frame{.sequence = number_,
                                    .sourceIndex = number_,
                                    .captureTime = hal::TimePoint(static_cast<std::int64_t>(number_) * period_),
                                    .restart = number_ == 0,
                                    .intrinsics = intrinsics,
                                    .depth = depth};
        ++number_;
        tracker_.track(frame);
        tracker_.readHands(frame);
        look();
    }
    void show(const Depth& depth, int times) {
        for (int i = 0; i < times; ++i)
            show({depth.data(), kWidth, kHeight, kWidth});
    }

    /// Frames in which somebody was said to be seen: a joint with confidence 0.5 or more.
    [[nodiscard]] int seen() const { return seen_; }
    [[nodiscard]] ViewFault fault() const { return tracker_.viewFault(); }
    [[nodiscard]] const Tracker& tracker() const { return tracker_; }

  private:
    void look() {
        const Skeleton& skeleton = tracker_.skeleton();
        ASSERT_LE(tracker_.users().count, kMaximumUsers);
        ASSERT_TRUE(tracker_.placement().translation.allFinite());
        ASSERT_TRUE(tracker_.placement().rotation.allFinite());
        bool sure = false;
        for (const JointState& joint : skeleton.joints) {
            ASSERT_TRUE(joint.position.allFinite());
            ASSERT_TRUE(joint.orientation.coeffs().allFinite());
            ASSERT_TRUE(joint.confidence >= 0.0F && joint.confidence <= 1.0F);
            sure |= joint.confidence >= 0.5F;
        }
        for (const Hand& hand : tracker_.hands().hands) {
            ASSERT_TRUE(hand.position.allFinite());
            ASSERT_TRUE(hand.holding >= 0.0F && hand.holding <= 1.0F);
        }
        seen_ += skeleton.present() && sure ? 1 : 0;
    }

    hal::Duration period_;
    Tracker tracker_;
    std::uint64_t number_ = 0;
    int seen_ = 0;
};

/// The frames of one visit of the simulated kiosk, drawn once for all that looks at them.
struct Visit {
    Visit(hal::sim::Script script, std::uint32_t seed, double framesPerSecond, double seconds)
        : rate(framesPerSecond),
          world(hal::sim::makeWorld({.seed = seed,
                                     .framesPerSecond = framesPerSecond,
                                     .colour = false,
                                     .mount = kMount,
                                     .script = script,
                                     .visitSeconds = seconds})),
          frames(static_cast<std::size_t>(seconds * framesPerSecond)) {
        hal::Image<hal::Rgb8> none;
        for (std::size_t i = 0; i < frames.size(); ++i)
            hal::sim::renderFrame(*world, i, frames[i], none);
    }
    [[nodiscard]] bool present(std::size_t frame) const {
        return hal::sim::truthAt(*world, static_cast<double>(frame) / rate).present;
    }

    double rate;
    std::shared_ptr<hal::sim::World> world;
    std::vector<hal::Image<std::uint16_t>> frames;
};

struct Uniform {
    std::uint16_t millimetres;
    ViewFault fault;
};

TEST(BadInput, OneDepthEverywhereIsNobodyAndIsToldWhereItIsAFault) {
    for (const Uniform& row :
         {Uniform{0, ViewFault::noReadings}, Uniform{65535, ViewFault::noReadings},
          Uniform{8000, ViewFault::noReadings}, Uniform{7999, ViewFault::none}, Uniform{600, ViewFault::covered}}) {
        Watch watch;
        watch.show(uniform(row.millimetres), kLongEnough);
        EXPECT_EQ(watch.seen(), 0) << row.millimetres;
        EXPECT_EQ(watch.tracker().users().count, 0U) << row.millimetres;
        EXPECT_EQ(watch.fault(), row.fault) << row.millimetres;
    }
}

TEST(BadInput, AHandOverTheSensorIsToldAndForgottenWhenItIsGone) {
    const Depth shop = emptyShop();
    Depth hand = shop;
    for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
            // A palm that fills the middle, with fingers up to the upper edge.
            const bool palm = std::hypot(static_cast<float>(u - 330), static_cast<float>(v - 300)) < 290.0F;
            const bool finger = v < 200 && u > 130 && u < 530 && (u - 130) % 100 < 75;
            if (palm || finger)
                hand[static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u)] =
                    static_cast<std::uint16_t>(420 + (u + v) % 40);
        }
    }
    Watch watch;
    watch.show(shop, 10);
    EXPECT_EQ(watch.fault(), ViewFault::none);
    watch.show(hand, kLongEnough);
    EXPECT_EQ(watch.fault(), ViewFault::covered);
    watch.show(shop, kLongEnough);
    EXPECT_EQ(watch.fault(), ViewFault::none);
    EXPECT_EQ(watch.seen(), 0);
}

TEST(BadInput, AnEmptyShopUpsideDownIsToldAndHasNobodyInIt) {
    Depth shop = emptyShop();
    std::reverse(shop.begin(), shop.end());
    Watch watch;
    watch.show(shop, kLongEnough);
    EXPECT_EQ(watch.seen(), 0);
    EXPECT_EQ(watch.fault(), ViewFault::upsideDown);
}

/// All that needs a visit shares one.
class BadVisit : public testing::Test {
  protected:
    static void SetUpTestSuite() { visit_ = std::make_unique<Visit>(hal::sim::Script::visit, 2, 5.0, 12.0); }
    static void TearDownTestSuite() { visit_.reset(); }
    static const Visit& visit() { return *visit_; }

  private:
    static std::unique_ptr<Visit> visit_;
};
std::unique_ptr<Visit> BadVisit::visit_;

TEST_F(BadVisit, UpsideDownIsTold) {
    Watch watch(visit().rate);
    for (hal::Image<std::uint16_t> frame : visit().frames) {
        std::reverse(frame.pixels.begin(), frame.pixels.end());
        watch.show(frame.view());
    }
    EXPECT_EQ(watch.fault(), ViewFault::upsideDown);
}

TEST_F(BadVisit, AtFiveFramesASecondTheShopperIsStillFollowed) {
    Watch watch(visit().rate);
    int present = 0;
    int followed = 0;
    for (std::size_t i = 0; i < visit().frames.size(); ++i) {
        const int before = watch.seen();
        watch.show(visit().frames[i].view());
        if (!visit().present(i)) continue;
        ++present;
        followed += watch.seen() - before;
    }
    ASSERT_GT(present, 25);
    EXPECT_GT(followed, present * 8 / 10);
    EXPECT_EQ(watch.fault(), ViewFault::none);
}

TEST_F(BadVisit, ALensThatIsNotItsOwnIsTold) {
    for (const float factor : {0.6F, 1.6F}) {
        hal::Intrinsics wrong;
        wrong.fx *= factor;
        wrong.fy *= factor;
        Watch watch(visit().rate);
        for (const hal::Image<std::uint16_t>& frame : visit().frames)
            watch.show(frame.view(), wrong);
        EXPECT_EQ(watch.fault(), ViewFault::floorElsewhere) << factor;
    }
}

TEST(BadInput, ADogIsNobody) {
    const Visit visit(hal::sim::Script::dog, 3, kSlowRate, 7.5);
    Watch watch(visit.rate);
    for (const hal::Image<std::uint16_t>& frame : visit.frames)
        watch.show(frame.view());
    EXPECT_EQ(watch.seen(), 0);
    EXPECT_EQ(watch.fault(), ViewFault::none);
}

}  // namespace
}  // namespace cheval::fitting

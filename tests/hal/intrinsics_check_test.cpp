#include "hal/intrinsics_check.h"

#include <functional>
#include <limits>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/depth_camera.h"

namespace cheval::hal {
namespace {

using testing::HasSubstr;

TEST(IntrinsicsCheck, TakesTheSensorsThatThereAre) {
    const Intrinsics taken[] = {
        {},
        {.fx = 476.007F, .fy = 476.007F, .cx = 313.683F, .cy = 242.755F},                        // 68°
        {.width = 320, .height = 240, .fx = 285.6F, .fy = 285.6F, .cx = 159.5F, .cy = 119.5F},   // 58°
        {.width = 512, .height = 424, .fx = 365.5F, .fy = 365.5F, .cx = 255.0F, .cy = 212.0F},   // 70°
        {.width = 640, .height = 576, .fx = 504.0F, .fy = 504.0F, .cx = 320.0F, .cy = 330.0F},   // 65°
        {.width = 512, .height = 512, .fx = 252.0F, .fy = 252.0F, .cx = 256.0F, .cy = 256.0F},   // 91°
        {.width = 848, .height = 480, .fx = 425.0F, .fy = 425.0F, .cx = 424.0F, .cy = 240.0F},   // 90°
        {.width = 480, .height = 640, .fx = 570.3F, .fy = 570.3F, .cx = 239.5F, .cy = 319.5F}};  // on its side
    for (const Intrinsics& intrinsics : taken)
        EXPECT_TRUE(checkIntrinsics(intrinsics)) << intrinsics.fx;
}

struct Refused {
    const char* what;
    std::function<void(Intrinsics&)> change;
    const char* key;
    const char* cause;  ///< Part of it.
};

TEST(IntrinsicsCheck, RefusesATableOfWhatNoSensorIs) {
    const float none = std::numeric_limits<float>::quiet_NaN();
    const float endless = std::numeric_limits<float>::infinity();
    const Refused table[] = {
        {"no columns", [](Intrinsics& i) { i.width = 0; }, "width", "0 pixels"},
        {"a negative height", [](Intrinsics& i) { i.height = -480; }, "height", "-480 pixels"},
        {"no focal length", [](Intrinsics& i) { i.fx = 0.0F; }, "fx", "no positive number"},
        {"a mirrored one", [](Intrinsics& i) { i.fy = -570.3F; }, "fy", "no positive number"},
        {"not a number", [none](Intrinsics& i) { i.fx = none; }, "fx", "no positive number"},
        {"endless", [endless](Intrinsics& i) { i.fy = endless; }, "fy", "no positive number"},
        {"millimetres", [](Intrinsics& i) { i.fx = 4.73F; }, "fx", "178 degrees across a picture of 640"},
        {"wider than 120 degrees", [](Intrinsics& i) { i.fx = 184.0F; }, "fx", "120 degrees across"},
        {"narrower than 30 degrees", [](Intrinsics& i) { i.fy = 897.0F; }, "fy", "30 degrees up a picture of 480"},
        {"of twice the resolution", [](Intrinsics& i) { i.fx = i.fy = 1140.6F; }, "fy", "24 degrees up"},
        {"a centre to the left", [](Intrinsics& i) { i.cx = -0.5F; }, "cx", "outside the picture"},
        {"a centre below", [](Intrinsics& i) { i.cy = 480.0F; }, "cy", "outside the picture"},
        {"a centre that is none", [none](Intrinsics& i) { i.cx = none; }, "cx", "outside the picture"}};
    for (const Refused& row : table) {
        Intrinsics intrinsics;
        row.change(intrinsics);
        const Expected<void> checked = checkIntrinsics(intrinsics);
        ASSERT_FALSE(checked) << row.what;
        EXPECT_EQ(checked.error().code, ErrorCode::invalidInput) << row.what;
        EXPECT_EQ(checked.error().key, row.key) << row.what;
        EXPECT_THAT(checked.error().cause, HasSubstr(row.cause)) << row.what;
        EXPECT_FALSE(checked.error().mend.empty()) << row.what;
        EXPECT_FALSE(checked.error().why.empty()) << row.what;
    }
}

TEST(IntrinsicsCheck, SaysWhichFocalLengthsWouldDo) {
    const Expected<void> checked = checkIntrinsics({.fx = 2000.0F});
    ASSERT_FALSE(checked);
    EXPECT_THAT(checked.error().mend, HasSubstr("185 to 1194 pixels"));
}

/// A camera that says this of its lens.
class SaysOfItself final : public DepthCamera {
  public:
    explicit SaysOfItself(const Intrinsics& intrinsics) : says_(intrinsics) {}
    [[nodiscard]] int closings() const { return closings_; }

  protected:
    Expected<CameraInfo> doOpen() override { return CameraInfo{.name = "odd", .intrinsics = says_}; }
    void doClose() override { ++closings_; }
    FrameStatus doWaitFrame(Duration, DepthFrame&, Interrupt&) override { return FrameStatus::timedOut; }

  private:
    Intrinsics says_;
    int closings_ = 0;
};

TEST(IntrinsicsCheck, EveryCameraIsRefusedWhoseLensCannotBe) {
    SaysOfItself odd({.fx = 57.0F});
    const Expected<void> opened = odd.open();
    ASSERT_FALSE(opened);
    EXPECT_THAT(opened.error().cause, HasSubstr("\"odd\""));
    EXPECT_THAT(opened.error().cause, HasSubstr("160 degrees across"));
    EXPECT_FALSE(odd.isOpen());
    EXPECT_EQ(odd.closings(), 1) << "the device is released";
    SaysOfItself sound({});
    EXPECT_TRUE(sound.open());
}

}  // namespace
}  // namespace cheval::hal

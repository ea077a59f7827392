#include "render/occlusion.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>

#include <gtest/gtest.h>

namespace cheval::render {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kCloth = 2000;  ///< Millimetres.

/// A flat sheet of cloth at kCloth before an upright sensor, over the whole crop, and a camera that sees what a formula
/// says at each pixel of the mirrored picture.
class Sheet {
  public:
    explicit Sheet(const std::function<int(int, int)>& seen) : depth_(kWidth, kHeight), user_(kWidth, kHeight, 1) {
        mapping_.cropLeft = 185.0F;
        mapping_.scale = 1.0F;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x)
                depth_.view().at(kWidth - 1 - x, y) = static_cast<std::uint16_t>(seen(x, y));
        }
        camera_.depth = depth_.view();
        camera_.userMap = user_.view();
        camera_.userLabel = 1;
        grid_ = cellGrid(mapping_, {0, 0, 270, 480});
        distances_.resize(grid_.columns, grid_.rows, {kCloth / 256, kCloth % 256, 255, 255});
    }
    /// How visible the cloth is at a pixel of the mirrored picture.
    int visible(int x, int y) {
        occlusion_.update(grid_, mapping_, camera_, skeleton_, hal::ImageView<const hal::Rgba8>(distances_.view()));
        std::array<std::uint8_t, 1> result{};
        occlusion_.visibleRow(mapping_, static_cast<float>(x) + 0.5F - mapping_.cropLeft, static_cast<float>(y) + 0.5F,
                              1.0F, 1, result.data());
        return result[0];
    }
    Occlusion& occlusion() { return occlusion_; }
    hal::Image<std::uint8_t>& user() { return user_; }
    fitting::Skeleton& skeleton() { return skeleton_; }
    [[nodiscard]] const CameraPicture& camera() const { return camera_; }

  private:
    hal::Image<std::uint16_t> depth_;
    hal::Image<std::uint8_t> user_;
    MirrorMapping mapping_;
    CameraPicture camera_;
    fitting::Skeleton skeleton_;  ///< Nobody, until a test says where the limbs are.
    CellGrid grid_;
    hal::Image<hal::Rgba8> distances_;
    Occlusion occlusion_;
};

/// The body lies just behind the cloth but for a bar across, `nearer` mm before the cloth.
int barAcross(int y, int nearer) {
    return y >= 200 && y < 240 ? kCloth - nearer : kCloth + 15;
}

TEST(Occlusion, whatStandsOutHides) {
    Sheet sheet([](int, int y) { return barAcross(y, 90); });
    EXPECT_EQ(sheet.visible(320, 220), 0);
    EXPECT_EQ(sheet.visible(320, 100), 255);
}

/// Head, and both forearms level with it, at a height of the mirrored picture and a depth in millimetres.
void placeLimbs(Sheet& sheet, float y, float depth) {
    sheet.skeleton().userId = 1;
    const auto put = [&](fitting::Joint joint, float x, float height) {
        const Eigen::Vector3f sensor = fitting::unproject(sheet.camera().intrinsics, x, height, depth);
        sheet.skeleton()[joint] = {.position = sheet.camera().placement.toMirror(sensor), .confidence = 0.9F};
    };
    put(fitting::Joint::head, 320.0F, 20.0F);
    put(fitting::Joint::rightElbow, 200.0F, y);
    put(fitting::Joint::rightHand, 310.0F, y);
    put(fitting::Joint::leftElbow, 440.0F, y);
    put(fitting::Joint::leftHand, 330.0F, y);
}

TEST(Occlusion, aForearmHidesWhereTheSkeletonHasIt) {
    Sheet sheet([](int, int y) { return barAcross(y, 90); });
    placeLimbs(sheet, 220.0F, kCloth - 60);
    EXPECT_EQ(sheet.visible(320, 220), 0);
}

TEST(Occlusion, aShapeThatIsNoLimbDoesNotHideUnlessFarInFront) {
    Sheet belly([](int, int y) { return barAcross(y, 90); });
    placeLimbs(belly, 400.0F, kCloth - 60);
    EXPECT_EQ(belly.visible(320, 220), 255);
    Sheet bag([](int, int y) { return barAcross(y, 250); });
    placeLimbs(bag, 400.0F, kCloth - 60);
    EXPECT_EQ(bag.visible(320, 220), 0);
}

TEST(Occlusion, whatIsNearerByLessThanClothAndSkinDifferDoesNot) {
    Sheet sheet([](int, int y) { return barAcross(y, 25); });
    EXPECT_EQ(sheet.visible(320, 220), 255);
}

TEST(Occlusion, aRoundBellyIsNoArm) {
    // As much nearer as the arm above, but without a step at its rim.
    Sheet sheet([](int x, int y) {
        const float r2 = static_cast<float>((x - 320) * (x - 320) + (y - 240) * (y - 240)) / (90.0F * 90.0F);
        return kCloth + 15 - static_cast<int>(110.0F * std::max(1.0F - r2, 0.0F));
    });
    EXPECT_EQ(sheet.visible(320, 240), 255);
}

TEST(Occlusion, whatIsFarInFrontHidesHoweverItEnds) {
    Sheet sheet([](int x, int y) {
        const float r2 = static_cast<float>((x - 320) * (x - 320) + (y - 240) * (y - 240)) / (60.0F * 60.0F);
        return kCloth + 15 - static_cast<int>(900.0F * std::max(1.0F - r2, 0.0F));
    });
    EXPECT_EQ(sheet.visible(320, 240), 0);
}

TEST(Occlusion, holesDoNotHide) {
    Sheet sheet([](int x, int y) { return x > 300 && x < 340 && y > 100 && y < 140 ? 0 : kCloth + 15; });
    EXPECT_EQ(sheet.visible(320, 120), 255);
}

TEST(Occlusion, anotherPersonInFrontHides) {
    Sheet sheet([](int, int y) { return barAcross(y, 400); });
    for (int x = 0; x < kWidth; ++x) {
        for (int y = 200; y < 240; ++y)
            sheet.user().view().at(x, y) = 2;
    }
    EXPECT_EQ(sheet.visible(320, 220), 0);
}

TEST(Occlusion, theBodysOwnOffsetIsLearnt) {
    Sheet sheet([](int, int y) { return barAcross(y, 190) - 100; });
    EXPECT_EQ(sheet.visible(320, 100), 255) << "a body tracked 85 mm too far away";
    EXPECT_EQ(sheet.visible(320, 220), 0) << "and the arm before it";
    EXPECT_NEAR(sheet.occlusion().offset(), 0.085F, 0.006F);
}

TEST(Occlusion, edgesAreSoft) {
    Sheet sheet([](int, int y) { return barAcross(y, 90); });
    int between = 0;
    int before = sheet.visible(320, 190);
    for (int y = 190; y <= 220; ++y) {
        const int now = sheet.visible(320, y);
        EXPECT_LE(now, before);
        between += now > 10 && now < 245 ? 1 : 0;
        before = now;
    }
    EXPECT_GE(between, 1);
}

TEST(Occlusion, resetForgets) {
    Sheet sheet([](int, int y) { return barAcross(y, 90); });
    EXPECT_EQ(sheet.visible(320, 220), 0);
    sheet.occlusion().reset();
    std::array<std::uint8_t, 1> result{};
    sheet.occlusion().visibleRow({}, 100.0F, 220.0F, 1.0F, 1, result.data());
    EXPECT_EQ(result[0], 255);
}

}  // namespace
}  // namespace cheval::render

// Golden pictures: what is drawn stays what it was, on both kinds of context, in every mount and view. A channel may
// differ a little, since software GL differs by rounding from processor to processor. On a difference the picture and a
// visual diff are left in ./golden-failures; CHEVAL_UPDATE_GOLDENS=1 replaces the goldens by what EGL draws.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "hal/png/png.h"
#include "render/renderer.h"
#include "tests/render/render_scene.h"

namespace cheval::render {
namespace {

using test::Mounting;
using test::RenderScene;
using test::RenderSceneOptions;

constexpr int kWidth = 270;
constexpr int kHeight = 480;
/// Of 255, in any channel.
constexpr int kTolerance = 10;
/// Pixels that may differ by more: an edge may fall on the next one.
constexpr int kStrays = kWidth * kHeight / 400;

struct Case {
    const char* name;
    RenderSceneOptions world;
    View view = View::mirror;
    Screen screen = Screen::acquiring;
    float renderScale = 1.0F;
    bool texts = false;
};

const Case kCases[] = {
    {.name = "mirror_upright", .world = {}},
    {.name = "mirror_right_edge_up", .world = {.mounting = Mounting::rightEdgeUp, .personX = 0.2F}},
    {.name = "mirror_left_edge_up", .world = {.mounting = Mounting::leftEdgeUp, .personX = 0.2F}},
    {.name = "mirror_arm_across", .world = {.armAcross = true, .personX = 0.3F}},
    {.name = "mirror_half_scale", .world = {}, .renderScale = 0.5F},
    {.name = "mirror_shaded_depth", .world = {.colour = false, .armAcross = true}},
    {.name = "mirror_shaded_depth_left_edge_up", .world = {.mounting = Mounting::leftEdgeUp, .colour = false}},
    {.name = "avatar", .world = {.armAcross = true}, .view = View::avatar},
    {.name = "attract", .world = {.dressed = false}, .screen = Screen::attract},
    {.name = "wearing", .world = {}, .screen = Screen::wearing, .texts = true},
    {.name = "service", .world = {.dressed = false}, .screen = Screen::service, .texts = true},
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name.
void PrintTo(const Case& one, std::ostream* out) {
    *out << one.name;
}

class Golden : public ::testing::TestWithParam<std::tuple<Case, ContextKind>> {};
INSTANTIATE_TEST_SUITE_P(Pictures, Golden,
                         ::testing::Combine(::testing::ValuesIn(kCases),
                                            ::testing::Values(ContextKind::egl, ContextKind::osmesa)),
                         [](const auto& parameter) {
                             const bool egl = std::get<1>(parameter.param) == ContextKind::egl;
                             return std::string(std::get<0>(parameter.param).name) + (egl ? "_egl" : "_osmesa");
                         });

int distance(hal::Rgba8 a, hal::Rgba8 b) {
    return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

/// The golden in grey, and in red what differs beyond the tolerance.
hal::Image<hal::Rgba8> visualDiff(const hal::Image<hal::Rgba8>& golden, const hal::Image<hal::Rgba8>& drawn) {
    hal::Image<hal::Rgba8> diff(golden.width, golden.height);
    for (std::size_t i = 0; i < golden.pixels.size(); ++i) {
        const hal::Rgba8 was = golden.pixels[i];
        const auto grey = static_cast<std::uint8_t>((was.r + was.g + was.b) / 6);
        const int apart = distance(was, drawn.pixels[i]);
        const bool strays = apart > kTolerance;
        diff.pixels[i] = strays ? hal::Rgba8{255, grey, grey, 255} : hal::Rgba8{grey, grey, grey, 255};
    }
    return diff;
}

TEST_P(Golden, isDrawnAsItWas) {
    const auto& [one, context] = GetParam();
    const RenderScene world(one.world);
    auto renderer = Renderer::create(
        {.width = kWidth, .height = kHeight, .context = context, .rotated = world.rotated()}, world.materials());
    ASSERT_TRUE(renderer) << renderer.error().message();
    Scene scene = world.scene(one.view);
    scene.renderScale = one.renderScale;
    scene.hud.screen = one.screen;
    if (one.texts) {
        scene.hud.carouselCount = 3;
        scene.hud.carousel[0].name.assign("T-shirt");
        scene.hud.carousel[1].name.assign("Trousers");
        scene.hud.carousel[2].name.assign("T-shirt + Trousers");
        scene.hud.carouselSelected = 1;
        scene.hud.advice.assign("Your size: M");
        scene.hud.prompt.assign("Swipe to change");
        scene.hud.service.assign("The sensor sends no frames.\nCheck its cable.");
        scene.hud.cursors[0] = {.visible = true, .position = {0.2F, 0.55F}, .state = fitting::HandState::open};
        scene.hud.cursors[1] = {.visible = true, .position = {0.8F, 0.5F}, .state = fitting::HandState::closed};
    }
    hal::Image<hal::Rgba8> drawn(kWidth, kHeight);
    auto done = (*renderer)->draw(scene, drawn.view());
    ASSERT_TRUE(done) << done.error().message();

    const std::string path = std::string(CHEVAL_SOURCE) + "/tests/golden/" + one.name + ".png";
    const hal::ImageView<const hal::Rgba8> view = drawn.view();
    if (std::getenv("CHEVAL_UPDATE_GOLDENS") != nullptr && context == ContextKind::egl) {
        auto written = hal::writePng(path, view, {.compression = 9});
        ASSERT_TRUE(written) << written.error().message();
    }
    hal::Image<hal::Rgba8> golden;
    auto read = hal::readPng(path, golden);
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(golden.pixels.size(), drawn.pixels.size());
    int strays = 0;
    for (std::size_t i = 0; i < golden.pixels.size(); ++i)
        strays += distance(golden.pixels[i], drawn.pixels[i]) > kTolerance ? 1 : 0;
    if (strays <= kStrays) return;

    const std::filesystem::path folder = "golden-failures";
    std::filesystem::create_directories(folder);
    const std::string stem = (folder / one.name).string() + (context == ContextKind::egl ? "_egl" : "_osmesa");
    const hal::Image<hal::Rgba8> diff = visualDiff(golden, drawn);
    (void)hal::writePng(stem + "_drawn.png", view);
    (void)hal::writePng(stem + "_diff.png", diff.view());
    FAIL() << strays << " pixels differ by more than " << kTolerance << " of 255; see "
           << std::filesystem::absolute(stem).string() << "_diff.png";
}

}  // namespace
}  // namespace cheval::render

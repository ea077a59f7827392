// What the renderer promises, on both kinds of context.
#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "render/mirror_mapping.h"
#include "tests/render/render_scene.h"
#include "tests/support/allocation_counter.h"

namespace cheval::render {
namespace {

using test::Mounting;
using test::RenderScene;
using test::RenderSceneOptions;

constexpr int kWidth = 270;
constexpr int kHeight = 480;

bool near(hal::Rgba8 pixel, hal::Rgb8 colour, int tolerance) {
    return std::abs(pixel.r - colour.r) <= tolerance && std::abs(pixel.g - colour.g) <= tolerance &&
           std::abs(pixel.b - colour.b) <= tolerance;
}

int difference(const hal::Image<hal::Rgba8>& a, const hal::Image<hal::Rgba8>& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        count += a.pixels[i] == b.pixels[i] ? 0 : 1;
    return count;
}

class RendererTest : public ::testing::TestWithParam<ContextKind> {
  protected:
    std::unique_ptr<Renderer> make(const RenderScene& world, int width = kWidth, int height = kHeight) {
        auto renderer = Renderer::create(
            {.width = width, .height = height, .context = GetParam(), .rotated = world.rotated()}, world.materials());
        EXPECT_TRUE(renderer) << (renderer ? "" : renderer.error().message());
        return renderer ? std::move(renderer).value() : nullptr;
    }
    hal::Image<hal::Rgba8> draw(Renderer& renderer, const Scene& scene, int width = kWidth, int height = kHeight) {
        hal::Image<hal::Rgba8> target(width, height, {1, 2, 3, 4});
        auto drawn = renderer.draw(scene, target.view());
        EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message());
        return target;
    }
    hal::Image<hal::Rgba8> draw(const RenderScene& world, View view = View::mirror) {
        return draw(*make(world), world.scene(view));
    }
    /// The display pixel of a mirror-frame point.
    static Eigen::Vector2i pixelOf(const RenderScene& world, const Eigen::Vector3f& point) {
        CropFollower crop;
        const MirrorMapping mapping =
            crop.follow(640, 480, kWidth, kHeight, uprightTurn(world.rotated(), world.placement()), world.intrinsics(),
                        world.placement(), world.scene().skeleton);
        const Projection projection = mirrorProjection(mapping, world.intrinsics(), world.placement());
        const Eigen::Vector2f pixel = projectPoint(projection, point);
        return {static_cast<int>(pixel.x()), static_cast<int>(pixel.y())};
    }
};
INSTANTIATE_TEST_SUITE_P(Contexts, RendererTest, ::testing::Values(ContextKind::egl, ContextKind::osmesa),
                         [](const auto& kind) { return kind.param == ContextKind::egl ? "egl" : "osmesa"; });

TEST_P(RendererTest, saysWhatItDrawsWith) {
    const RenderScene world({});
    const auto renderer = make(world);
    EXPECT_NE(renderer->description().find(GetParam() == ContextKind::egl ? "EGL" : "OSMesa"), std::string::npos)
        << renderer->description();
}

TEST_P(RendererTest, flipsThePictureAsAMirrorDoes) {
    for (const Mounting mounting : {Mounting::upright, Mounting::rightEdgeUp, Mounting::leftEdgeUp}) {
        const RenderScene world({.mounting = mounting, .dressed = false});
        const auto target = draw(world);
        // The ball is at the shopper's left, so at the display's left, above the middle.
        const Eigen::Vector2i ball = pixelOf(world, world.marker());
        EXPECT_LT(ball.x(), kWidth / 2);
        EXPECT_LT(ball.y(), kHeight / 2);
        EXPECT_TRUE(near(target.view().at(ball.x(), ball.y()), RenderScene::kMarkerColour, 6));
        EXPECT_FALSE(near(target.view().at(kWidth - 1 - ball.x(), ball.y()), RenderScene::kMarkerColour, 60));
    }
}

TEST_P(RendererTest, fillsEveryPixelOpaque) {
    const RenderScene world({});
    const auto renderer = make(world);
    for (const View view : {View::mirror, View::avatar}) {
        const auto target = draw(*renderer, world.scene(view));
        EXPECT_TRUE(std::all_of(target.pixels.begin(), target.pixels.end(), [](hal::Rgba8 p) { return p.a == 255; }));
    }
}

TEST_P(RendererTest, drawsOnlyThePictureWithoutAMesh) {
    RenderSceneOptions options;
    const RenderScene dressed(options);
    options.dressed = false;
    const RenderScene bare(options);
    const auto renderer = make(dressed);
    const auto with = draw(*renderer, dressed.scene());
    const auto without = draw(*renderer, bare.scene());
    const Eigen::Vector2i chest = pixelOf(bare, bare.chest());
    EXPECT_FALSE(near(without.view().at(chest.x(), chest.y()), {40, 92, 160}, 60));
    EXPECT_GT(difference(with, without), 5000);
    // A mesh of no parts is no mesh.
    const fitting::PosedMesh nothing;
    Scene scene = bare.scene();
    scene.mesh = &nothing;
    EXPECT_EQ(difference(draw(*renderer, scene), without), 0);
}

TEST_P(RendererTest, laysAVertexOnThePixelThatSeesIt) {
    for (const Mounting mounting : {Mounting::upright, Mounting::rightEdgeUp, Mounting::leftEdgeUp}) {
        RenderScene world({.mounting = mounting, .sideMarker = false});
        // One small square of cloth in the air, nearer than everything.
        const Eigen::Vector3f centre(0.12F, 1.31F, 1.7F);
        constexpr float kHalf = 0.05F;
        fitting::PosedMesh& mesh = world.mesh();
        mesh.vertices.clear();
        for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
            mesh.vertices.push_back({centre.x() + kHalf * static_cast<float>(x),
                                     centre.y() + kHalf * static_cast<float>(y), centre.z(), 0, 0, -1, 0.5F, 0.5F});
        }
        mesh.indices = {0, 1, 2, 0, 2, 3};
        mesh.parts = {{.kind = fitting::PartKind::garment, .indexCount = 6, .material = 1, .layer = 1}};
        mesh.topologyRevision = 2;
        RenderScene bare({.mounting = mounting, .sideMarker = false, .dressed = false});
        const auto renderer = make(world);
        const auto with = draw(*renderer, world.scene());
        const auto without = draw(*renderer, bare.scene());
        int left = kWidth;
        int right = -1;
        int top = kHeight;
        int bottom = -1;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                if (with.view().at(x, y) == without.view().at(x, y)) continue;
                left = std::min(left, x);
                right = std::max(right, x);
                top = std::min(top, y);
                bottom = std::max(bottom, y);
            }
        }
        const Eigen::Vector2i upperLeft = pixelOf(world, centre + Eigen::Vector3f(-kHalf, kHalf, 0));
        const Eigen::Vector2i lowerRight = pixelOf(world, centre + Eigen::Vector3f(kHalf, -kHalf, 0));
        EXPECT_NEAR(left, upperLeft.x(), 1);
        EXPECT_NEAR(top, upperLeft.y(), 1);
        EXPECT_NEAR(right, lowerRight.x(), 1);
        EXPECT_NEAR(bottom, lowerRight.y(), 1);
    }
}

TEST_P(RendererTest, hidesTheGarmentBehindTheShoppersArm) {
    RenderSceneOptions options{.armAcross = true};
    const RenderScene dressed(options);
    options.dressed = false;
    const RenderScene bare(options);
    const auto renderer = make(dressed);
    const auto with = draw(*renderer, dressed.scene());
    const auto without = draw(*renderer, bare.scene());
    const Eigen::Vector2i arm = pixelOf(dressed, dressed.forearm());
    EXPECT_EQ(with.view().at(arm.x(), arm.y()), without.view().at(arm.x(), arm.y()));
    const Eigen::Vector2i chest = pixelOf(dressed, dressed.chest());
    EXPECT_FALSE(near(with.view().at(chest.x(), chest.y()), RenderScene::kSkinColour, 40));
}

TEST_P(RendererTest, keepsTheGarmentWhereTheBodyIsTrackedALittleTooFarAway) {
    const RenderScene world({.clothBehind = 0.07F});
    const RenderScene bare({.dressed = false});
    const auto renderer = make(world);
    const auto with = draw(*renderer, world.scene());
    const auto without = draw(*renderer, bare.scene());
    const Eigen::Vector2i chest = pixelOf(world, world.chest());
    EXPECT_NE(with.view().at(chest.x(), chest.y()), without.view().at(chest.x(), chest.y()));
}

TEST_P(RendererTest, treatsPixelsWithoutDepthAsNotHiding) {
    const RenderScene world({});
    Scene scene = world.scene();
    const hal::Image<std::uint16_t> holes(640, 480, 0);
    const auto renderer = make(world);
    const auto expected = draw(*renderer, scene);
    scene.camera.depth = holes.view();
    const Eigen::Vector2i chest = pixelOf(world, world.chest());
    const auto drawn = draw(*make(world), scene);
    EXPECT_EQ(drawn.view().at(chest.x(), chest.y()), expected.view().at(chest.x(), chest.y()));
}

TEST_P(RendererTest, leavesTheMannequinOutOfTheMirror) {
    RenderScene world({});
    const auto renderer = make(world);
    const auto with = draw(*renderer, world.scene());
    auto& parts = world.mesh().parts;
    std::erase_if(parts, [](const fitting::MeshPart& part) { return part.kind == fitting::PartKind::body; });
    ++world.mesh().topologyRevision;
    EXPECT_EQ(difference(draw(*renderer, world.scene()), with), 0);
    EXPECT_GT(
        difference(draw(*renderer, world.scene(View::avatar)), draw(*make(world), RenderScene({}).scene(View::avatar))),
        1000);
}

TEST_P(RendererTest, avatarStandsInTheMiddleWhereverTheShopperStands) {
    for (const float x : {-0.8F, 0.6F}) {
        const RenderScene world({.personX = x});
        const RenderScene empty({.dressed = false, .personX = x});
        const auto renderer = make(world);
        const auto with = draw(*renderer, world.scene(View::avatar));
        const auto without = draw(*renderer, empty.scene(View::avatar));
        double sum = 0.0;
        int count = 0;
        for (int y = 0; y < kHeight; ++y) {
            for (int column = 0; column < kWidth; ++column) {
                if (with.view().at(column, y) == without.view().at(column, y)) continue;
                sum += column;
                ++count;
            }
        }
        ASSERT_GT(count, 5000);
        EXPECT_NEAR(sum / count, kWidth / 2.0, 6.0);
    }
}

TEST_P(RendererTest, shadesDepthWhereThereIsNoColour) {
    const RenderScene world({.colour = false, .dressed = false});
    const auto target = draw(world);
    const Eigen::Vector2i chest = pixelOf(world, world.chest());
    const hal::Rgba8 person = target.view().at(chest.x(), chest.y());
    const hal::Rgba8 wall = target.view().at(5, 40);
    EXPECT_GT(person.r, wall.r + 60) << "the shopper stands out";
    EXPECT_GT(person.r, person.b) << "and is warm";
    EXPECT_LE(wall.r, wall.b) << "before a cool room";
}

TEST_P(RendererTest, staysLitWithoutAnyCamera) {
    Scene scene;
    const RenderScene world({});
    const auto renderer = make(world);
    const auto mirror = draw(*renderer, scene);
    EXPECT_GT(mirror.view().at(kWidth / 2, kHeight - 5).b, 0);
    scene.view = View::avatar;
    draw(*renderer, scene);
}

TEST_P(RendererTest, drawsCoarserGarmentsOnAskingInTheSamePlace) {
    const RenderScene world({});
    const auto renderer = make(world);
    Scene scene = world.scene();
    const auto fine = draw(*renderer, scene);
    scene.renderScale = 0.5F;
    const auto coarse = draw(*make(world), scene);
    EXPECT_NE(difference(fine, coarse), 0);
    std::int64_t apart = 0;
    for (std::size_t i = 0; i < fine.pixels.size(); ++i)
        apart += std::abs(fine.pixels[i].g - coarse.pixels[i].g);
    EXPECT_LT(static_cast<double>(apart) / static_cast<double>(fine.pixels.size()), 2.0);
}

TEST_P(RendererTest, refusesWrongBuffersAndBrokenMeshes) {
    RenderScene world({});
    const auto renderer = make(world);
    hal::Image<hal::Rgba8> small(10, 10);
    auto refused = renderer->draw(world.scene(), small.view());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::invalidInput);

    hal::Image<hal::Rgba8> target(kWidth, kHeight);
    Scene scene = world.scene();
    scene.camera.intrinsics.width = 320;
    EXPECT_FALSE(renderer->draw(scene, target.view()));

    const auto broken = [&](auto spoil) {
        RenderScene bad({});
        spoil(bad.mesh());
        ++bad.mesh().topologyRevision;
        auto drawn = renderer->draw(bad.scene(), target.view());
        EXPECT_FALSE(drawn);
        EXPECT_TRUE(renderer->draw(world.scene(), target.view())) << "and draws the next good one";
    };
    broken([](fitting::PosedMesh& mesh) { mesh.indices.back() = 0xFFFFFFFFU; });
    broken([](fitting::PosedMesh& mesh) { mesh.parts.back().indexCount += 3; });
    broken([](fitting::PosedMesh& mesh) { mesh.parts.back().firstIndex = 0xFFFFFFF0U; });
    broken([](fitting::PosedMesh& mesh) { mesh.parts.back().material = 77; });
}

TEST_P(RendererTest, survivesPositionsThatAreNoNumbers) {
    RenderScene world({});
    const auto renderer = make(world);
    world.mesh().vertices[3].x = std::numeric_limits<float>::quiet_NaN();
    world.mesh().vertices.back().y = std::numeric_limits<float>::infinity();
    draw(*renderer, world.scene());
    Scene scene = world.scene();
    scene.skeleton[fitting::Joint::torso].position.x() = std::numeric_limits<float>::quiet_NaN();
    draw(*renderer, scene);
    draw(*renderer, RenderScene({}).scene(View::avatar));
}

TEST_P(RendererTest, drawsTheSameBytesForTheSameScenes) {
    const RenderScene world({.armAcross = true});
    const auto one = make(world);
    const auto two = make(world);
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(difference(draw(*one, world.scene()), draw(*two, world.scene())), 0);
}

TEST_P(RendererTest, twoKindsOfContextLiveSideBySide) {
    const RenderScene world({});
    const auto other =
        Renderer::create({.width = kWidth,
                          .height = kHeight,
                          .context = GetParam() == ContextKind::egl ? ContextKind::osmesa : ContextKind::egl},
                         world.materials());
    ASSERT_TRUE(other);
    const auto renderer = make(world);
    const auto first = draw(*renderer, world.scene());
    draw(**other, world.scene());
    EXPECT_EQ(difference(draw(*renderer, world.scene()), first), 0);
}

TEST_P(RendererTest, drawsIntoRowsFartherApartThanTheyAreWide) {
    const RenderScene world({});
    const auto renderer = make(world);
    const auto tight = draw(*renderer, world.scene());
    hal::Image<hal::Rgba8> wide(kWidth + 50, kHeight, {9, 9, 9, 9});
    const hal::ImageView<hal::Rgba8> view{
        .data = wide.pixels.data(), .width = kWidth, .height = kHeight, .stride = kWidth + 50};
    ASSERT_TRUE(make(world)->draw(world.scene(), view));
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x)
            ASSERT_EQ(view.at(x, y), tight.view().at(x, y));
        for (int x = kWidth; x < kWidth + 50; ++x)
            ASSERT_EQ(wide.view().at(x, y), (hal::Rgba8{9, 9, 9, 9})) << "nothing is written beside the picture";
    }
}

TEST_P(RendererTest, takesNoMemoryInASteadyStateOutsideTheDriver) {
    // The driver takes memory as it likes; without a mesh GL does nothing, so that what is counted is ours.
    RenderSceneOptions options{.dressed = false};
    for (const bool colour : {true, false}) {
        options.colour = colour;
        const RenderScene world(options);
        const auto renderer = make(world);
        Scene scene = world.scene();
        scene.hud.screen = Screen::wearing;
        scene.hud.carouselCount = 2;
        scene.hud.carousel[0].name.assign("T-shirt");
        scene.hud.prompt.assign("Hold still");
        scene.hud.cursors[0] = {.visible = true, .position = {0.3F, 0.4F}, .state = fitting::HandState::open};
        hal::Image<hal::Rgba8> target(kWidth, kHeight);
        for (const View view : {View::mirror, View::avatar}) {
            scene.view = view;
            for (int i = 0; i < 3; ++i)
                ASSERT_TRUE(renderer->draw(scene, target.view()));
            const test::AllocationCounter counter;
            for (int i = 0; i < 5; ++i)
                (void)renderer->draw(scene, target.view());
            EXPECT_EQ(counter.count(), 0U);
        }
    }
}

TEST_P(RendererTest, theFirstDressedPictureCompilesNothing) {
    // What a software driver compiles takes thousands of allocations; the first garment must find it done.
    const RenderScene world({});
    const auto renderer = make(world);
    hal::Image<hal::Rgba8> target(kWidth, kHeight);
    const auto taken = [&](const Scene& scene) {
        const test::AllocationCounter counter;
        EXPECT_TRUE(renderer->draw(scene, target.view()));
        return counter.count();
    };
    for (const View view : {View::mirror, View::avatar}) {
        Scene undressed = world.scene(view);
        undressed.mesh = nullptr;
        taken(undressed);  // Texts of the head-up display.
        const auto first = taken(world.scene(view));
        for (int i = 0; i < 5; ++i)
            taken(world.scene(view));
        const auto later = taken(world.scene(view));
        EXPECT_LE(first, 2 * later + 200);
    }
}

TEST_P(RendererTest, theDriversMemoryIsFlat) {
    const RenderScene world({});
    const auto renderer = make(world);
    hal::Image<hal::Rgba8> target(kWidth, kHeight);
    const auto burst = [&] {
        const test::AllocationCounter counter;
        for (int i = 0; i < 20; ++i)
            (void)renderer->draw(world.scene(), target.view());
        return counter.count();
    };
    burst();
    const auto first = burst();
    const auto second = burst();
    EXPECT_LE(second, first + first / 10 + 20) << "allocations of 20 frames, driver included";
}

TEST(Renderer, refusesAPictureThatCannotBe) {
    auto none = Renderer::create({.width = 0, .height = 480}, {});
    ASSERT_FALSE(none);
    EXPECT_FALSE(none.error().mend.empty());
    auto huge = Renderer::create({.width = 1 << 20, .height = 1 << 20}, {});
    ASSERT_FALSE(huge);
}

}  // namespace
}  // namespace cheval::render

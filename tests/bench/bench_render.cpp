// What a drawn frame costs at 1080×1920: mirror and avatar, EGL and OSMesa, with colour and from depth alone.
// --benchmark_repetitions=5 --benchmark_report_aggregates_only gives medians.
#include <benchmark/benchmark.h>

#include "render/renderer.h"
#include "tests/render/render_scene.h"

namespace {

using cheval::render::ContextKind;
using cheval::render::View;

void drawFrame(benchmark::State& state, ContextKind context, View view, bool colour, bool dressed) {
    const cheval::test::RenderScene world({.colour = colour, .armAcross = true, .dressed = dressed});
    auto renderer = cheval::render::Renderer::create({.context = context}, world.materials());
    if (!renderer) {
        state.SkipWithError(renderer.error().message().c_str());
        return;
    }
    cheval::render::Scene scene = world.scene(view);
    scene.hud.screen = cheval::render::Screen::wearing;
    scene.hud.carouselCount = 3;
    scene.hud.carousel[0].name.assign("T-shirt");
    scene.hud.carousel[1].name.assign("Trousers");
    scene.hud.carousel[2].name.assign("Both");
    cheval::hal::Image<cheval::hal::Rgba8> target(1080, 1920);
    for (int i = 0; i < 3; ++i)
        (void)(*renderer)->draw(scene, target.view());
    for ([[maybe_unused]] auto _ : state) {
        if (auto drawn = (*renderer)->draw(scene, target.view()); !drawn) {
            state.SkipWithError(drawn.error().message().c_str());
            return;
        }
    }
    state.SetLabel((*renderer)->description());
}

#define CHEVAL_BENCH(name, ...)                     \
    BENCHMARK_CAPTURE(drawFrame, name, __VA_ARGS__) \
        ->Unit(benchmark::kMillisecond)             \
        ->MeasureProcessCPUTime()                   \
        ->UseRealTime()

CHEVAL_BENCH(pictureOnly, ContextKind::egl, View::mirror, true, false);
CHEVAL_BENCH(mirrorEgl, ContextKind::egl, View::mirror, true, true);
CHEVAL_BENCH(mirrorOsmesa, ContextKind::osmesa, View::mirror, true, true);
CHEVAL_BENCH(mirrorShadedDepthEgl, ContextKind::egl, View::mirror, false, true);
CHEVAL_BENCH(avatarEgl, ContextKind::egl, View::avatar, true, true);
CHEVAL_BENCH(avatarOsmesa, ContextKind::osmesa, View::avatar, true, true);

}  // namespace

BENCHMARK_MAIN();

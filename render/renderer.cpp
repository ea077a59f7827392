#include "render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "render/avatar_view.h"
#include "render/compositor.h"
#include "render/depth_shading.h"
#include "render/garment_pass.h"
#include "render/gl_context.h"
#include "render/hud.h"
#include "render/mirror_mapping.h"
#include "render/occlusion.h"
#include "render/picture_scaler.h"

namespace cheval::render {
namespace {

constexpr float kLeastRenderScale = 0.25F;
/// Mean brightness of a picture in which cloth is lit as it is in the studio.
constexpr float kNeutralBrightness = 112.0F;
constexpr float kExposureFollow = 0.08F;
/// A longer gap than this between frames is another scene.
constexpr double kMemorySeconds = 0.2;

ToneCurve dimmed(float factor) {
    ToneCurve curve{};
    for (std::size_t i = 0; i < curve.size(); ++i)
        curve[i] = static_cast<std::uint8_t>(std::lround(static_cast<float>(i) * factor));
    return curve;
}

bool sizesAgree(const CameraPicture& camera) {
    const auto same = [&](const auto& view) {
        return view.empty() || (view.width == camera.intrinsics.width && view.height == camera.intrinsics.height);
    };
    return same(camera.colour) && same(camera.depth) && same(camera.userMap);
}

}  // namespace

struct Renderer::State {
    State(const RendererOptions& wanted, std::unique_ptr<GlContext> gl, std::unique_ptr<GarmentPass> pass, Hud display)
        : options(wanted),
          context(std::move(gl)),
          garments(std::move(pass)),
          hud(std::move(display)),
          avatar(wanted.width, wanted.height),
          drawn(wanted.width, wanted.height),
          distances(kMaximumCells, kMaximumCells) {}

    Expected<void> drawMirror(const Scene& scene, hal::ImageView<hal::Rgba8> target);
    Expected<void> drawAvatar(const Scene& scene, hal::ImageView<hal::Rgba8> target);
    /// Starts GL on the garments; false where there is nothing to see.
    Expected<bool> start(const Scene& scene, const GarmentView& view);
    /// Waits for GL and gives what it drew.
    hal::ImageView<hal::Rgba8> finish();
    void matchExposure(const CameraPicture& camera);

    RendererOptions options;
    std::unique_ptr<GlContext> context;
    std::unique_ptr<GarmentPass> garments;
    Hud hud;
    CropFollower crop;
    PictureScaler scaler;
    DepthShading shading;
    Occlusion occlusion;
    Compositor compositor;
    AvatarView avatar;
    hal::Image<hal::Rgba8> drawn;      ///< What GL drew of the garments.
    hal::Image<hal::Rgba8> distances;  ///< And how far away it is, in cells of the camera's picture.
    PixelRect rect;
    int columns = 0, rows = 0;  ///< Of `rect`, as drawn.
    Eigen::Vector3f exposure = Eigen::Vector3f::Ones();
    bool exposed = false;
    hal::TimePoint lastTime{};  ///< Of the frame that occlusion remembers.
    std::uint32_t lastUser = 0;
    std::array<ToneCurve, 3> tones = {dimmed(1.0F), dimmed(0.5F), dimmed(0.3F)};
    /// So that the words of a screen can be read on what is behind them.
    [[nodiscard]] const ToneCurve& toneOf(Screen screen) const {
        return screen == Screen::service ? tones[2] : screen == Screen::attract ? tones[1] : tones[0];
    }
};

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::~Renderer() = default;

Expected<std::unique_ptr<Renderer>> Renderer::create(const RendererOptions& options,
                                                     std::span<const fitting::Material> materials) {
    auto context = makeGlContext(options.context);
    if (!context) return std::move(context).error().within("while starting the renderer");
    auto garments = GarmentPass::create(**context, options.width, options.height, kMaximumCells, materials);
    if (!garments) return std::move(garments).error().within("while starting the renderer");
    auto hud = Hud::create(options.width, options.height);
    if (!hud) return std::move(hud).error().within("while starting the renderer");
    return std::unique_ptr<Renderer>(new Renderer(std::make_unique<State>(
        options, std::move(context).value(), std::move(garments).value(), std::move(hud).value())));
}

const std::string& Renderer::description() const {
    return state_->context->description();
}

Expected<void> Renderer::draw(const Scene& scene, hal::ImageView<hal::Rgba8> target) {
    State& state = *state_;
    if (target.empty() || target.width != state.options.width || target.height != state.options.height ||
        target.stride < target.width)
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the buffer to draw into has " + std::to_string(target.width) + "×" +
                              std::to_string(target.height) + " pixels, not " + std::to_string(state.options.width) +
                              "×" + std::to_string(state.options.height),
                     .mend = "start the renderer with the display's size"};
    if (!sizesAgree(scene.camera))
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the camera's pictures differ in size from its intrinsics",
                     .why = "colour and user map are registered to depth pixel for pixel"};
    if (auto current = state.context->makeCurrent(); !current) return current;
    auto drawn = scene.view == View::mirror ? state.drawMirror(scene, target) : state.drawAvatar(scene, target);
    if (!drawn) return drawn;
    state.hud.draw(scene.hud, target);
    return state.garments->check();
}

Expected<bool> Renderer::State::start(const Scene& scene, const GarmentView& view) {
    rect = {};
    if (scene.mesh == nullptr || scene.mesh->parts.empty() || scene.mesh->vertices.empty()) return false;
    if (auto uploaded = garments->upload(*scene.mesh); !uploaded) return std::move(uploaded).error();
    rect = garments->bounds(*scene.mesh, view);
    if (rect.empty()) return false;
    const float scale = std::clamp(scene.renderScale, kLeastRenderScale, 1.0F);
    columns = std::max(static_cast<int>(std::lround(static_cast<float>(rect.width()) * scale)), 1);
    rows = std::max(static_cast<int>(std::lround(static_cast<float>(rect.height()) * scale)), 1);
    garments->drawColour(view, rect, columns, rows);
    return true;
}

hal::ImageView<hal::Rgba8> Renderer::State::finish() {
    const hal::ImageView<hal::Rgba8> view{
        .data = drawn.pixels.data(), .width = columns, .height = rows, .stride = columns};
    garments->readColour(view);
    return view;
}

void Renderer::State::matchExposure(const CameraPicture& camera) {
    if (camera.colour.empty()) {
        exposure = Eigen::Vector3f::Constant(0.95F);
        exposed = false;
        return;
    }
    constexpr int kStep = 12;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
    for (int y = kStep / 2; y < camera.colour.height; y += kStep) {
        const hal::Rgb8* row = camera.colour.row(y);
        for (int x = kStep / 2; x < camera.colour.width; x += kStep, ++count)
            sum += Eigen::Vector3f(row[x].r, row[x].g, row[x].b);
    }
    const Eigen::Vector3f mean = sum / static_cast<float>(std::max(count, 1));
    const float grey = std::max(mean.mean(), 1.0F);
    // Brightness follows the room most of the way; its tint only a little, since walls have colours of their own.
    const float brightness = std::clamp(0.35F + 0.65F * grey / kNeutralBrightness, 0.6F, 1.2F);
    const Eigen::Vector3f tint = (0.8F + 0.2F * mean.array() / grey).matrix().cwiseMax(0.9F).cwiseMin(1.1F);
    const Eigen::Vector3f wanted = brightness * tint;
    if (exposed)
        exposure += (wanted - exposure) * kExposureFollow;
    else
        exposure = wanted;
    exposed = true;
}

Expected<void> Renderer::State::drawMirror(const Scene& scene, hal::ImageView<hal::Rgba8> target) {
    const CameraPicture& camera = scene.camera;
    const MirrorMapping mapping = crop.follow(camera.intrinsics.width, camera.intrinsics.height, options.width,
                                              options.height, uprightTurn(options.rotated, camera.placement),
                                              camera.intrinsics, camera.placement, scene.skeleton);
    matchExposure(camera);
    const GarmentView view{.projection = mirrorProjection(mapping, camera.intrinsics, camera.placement),
                           .exposure = exposure};
    auto started = start(scene, view);
    if (!started) return std::move(started).error();
    CellGrid grid;
    if (*started && !camera.depth.empty()) {
        grid = cellGrid(mapping, rect);
        if (!grid.empty()) garments->drawDistance(view, grid.part, grid.columns, grid.rows);
    }
    // GL's threads are at work on the garments; meanwhile the picture.
    const ToneCurve& tone = toneOf(scene.hud.screen);
    if (!camera.colour.empty()) {
        scaler.draw(mapping, camera.colour, tone, target);
    } else if (!camera.depth.empty()) {
        scaler.draw(mapping, shading.shade(camera, mapping, options.width, options.height), tone, target);
    } else {
        for (int y = 0; y < target.height; ++y)
            std::fill(target.row(y), target.row(y) + target.width, hal::Rgba8{17, 19, 24, 255});
    }
    if (!*started) {
        occlusion.reset();
        return {};
    }
    const bool hides = !grid.empty();
    if (hides) {
        // What was hidden a while ago, or on somebody else, says nothing about now.
        const double gap = hal::seconds(scene.skeleton.captureTime - lastTime);
        if (gap < 0.0 || gap > kMemorySeconds || scene.skeleton.userId != lastUser) occlusion.reset();
        lastTime = scene.skeleton.captureTime;
        lastUser = scene.skeleton.userId;
        const hal::ImageView<hal::Rgba8> cells{
            .data = distances.pixels.data(), .width = grid.columns, .height = grid.rows, .stride = grid.columns};
        garments->readDistance(cells);
        occlusion.update(grid, mapping, camera, scene.skeleton, cells);
    }
    compositor.compose(finish(), rect, mapping, hides ? &occlusion : nullptr, target);
    return {};
}

Expected<void> Renderer::State::drawAvatar(const Scene& scene, hal::ImageView<hal::Rgba8> target) {
    const GarmentView view{.projection = avatar.follow(scene.skeleton), .withBody = true};
    auto started = start(scene, view);
    if (!started) return std::move(started).error();
    avatar.draw(view.projection, scene.skeleton, *started, target);
    if (*started) compositor.compose(finish(), rect, {}, nullptr, target);
    // The stage is as light as the words that stand on it.
    const ToneCurve& tone = toneOf(scene.hud.screen);
    for (int y = 0; &tone != tones.data() && y < target.height; ++y) {
        for (hal::Rgba8& pixel : std::span(target.row(y), static_cast<std::size_t>(target.width)))
            pixel = {tone[pixel.r], tone[pixel.g], tone[pixel.b], pixel.a};
    }
    return {};
}

}  // namespace cheval::render

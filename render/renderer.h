// Draws the mirror: camera picture or mannequin, garments, occlusion by the shopper's own body, and the head-up
// display, into a buffer lent by a display (D13).
#pragma once

#include <memory>
#include <span>
#include <string>

#include "fitting/material.h"
#include "fitting/mesh.h"
#include "fitting/skeleton.h"
#include "hal/expected.h"
#include "hal/frame.h"
#include "hal/image.h"
#include "render/hud_state.h"

namespace cheval::render {

enum class ContextKind : std::uint8_t { automatic, egl, osmesa };
enum class View : std::uint8_t { mirror, avatar };

struct RendererOptions {
    int width = 1080;
    int height = 1920;
    ContextKind context = ContextKind::automatic;  ///< automatic: EGL surfaceless, else OSMesa.
    bool rotated = false;  ///< The sensor is mounted turned by 90°; else the mirror view is a portrait crop that
                           ///< follows the shopper.
};

/// What the camera saw, as the renderer needs it. Views are borrowed for the time of draw().
struct CameraPicture {
    hal::ImageView<const hal::Rgb8> colour;      ///< Empty: shaded depth is shown.
    hal::ImageView<const std::uint16_t> depth;   ///< Millimetres, for occlusion and shading.
    hal::ImageView<const std::uint8_t> userMap;  ///< 0 = scene.
    std::uint8_t userLabel = 0;                  ///< The dressed person's label in userMap; 0: nobody.
    hal::Intrinsics intrinsics;
    fitting::SensorPlacement placement;
};

/// One frame to draw.
struct Scene {
    View view = View::mirror;
    const fitting::PosedMesh* mesh = nullptr;  ///< May be null: nobody is dressed.
    CameraPicture camera;
    fitting::Skeleton skeleton;  ///< For the crop and the avatar's place; may be absent.
    HudState hud;
    float renderScale = 1.0F;  ///< 0.5…1: the degrade ladder's resolution of garments.
};

/// Thread-bound to the thread that calls create(). After the first draws it takes no heap memory outside the GL driver.
class Renderer {
  public:
    /// Makes a context and uploads materials (index as MeshPart::material). Fails with cause and mend where neither EGL
    /// nor OSMesa gives OpenGL ES 3 or GL 3.3 core.
    static Expected<std::unique_ptr<Renderer>> create(const RendererOptions& options,
                                                      std::span<const fitting::Material> materials);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    /// Draws into `target` (row 0 at the top, options' size).
    Expected<void> draw(const Scene& scene, hal::ImageView<hal::Rgba8> target);
    /// E.g. "EGL surfaceless, OpenGL ES 3.2, llvmpipe".
    [[nodiscard]] const std::string& description() const;

  private:
    struct State;
    explicit Renderer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace cheval::render

// What the loop hands to the renderer: one frame, complete, owning its memory.
#pragma once

#include <cstdint>

#include "fitting/mesh.h"
#include "fitting/skeleton.h"
#include "hal/clock.h"
#include "hal/frame.h"
#include "hal/image.h"
#include "render/hud_state.h"
#include "render/renderer.h"

namespace cheval::daemon {

/// The camera's buffers are lent for one frame only, so what the renderer needs of them is copied. Capacities are
/// reserved at start-up; filling a packet takes no memory.
struct FramePacket {
    fitting::PosedMesh mesh;
    bool dressed = false;     ///< `mesh` is to be drawn.
    bool hasPicture = false;  ///< The pictures below belong to this frame.
    hal::Image<std::uint16_t> depth;
    hal::Image<hal::Rgb8> colour;
    hal::Image<std::uint8_t> userMap;
    std::uint8_t userLabel = 0;
    hal::Intrinsics intrinsics;
    fitting::SensorPlacement placement;
    fitting::Skeleton skeleton;
    render::HudState hud;
    render::View view = render::View::mirror;
    float renderScale = 1.0F;
    hal::TimePoint captureTime{};
    std::uint64_t sourceIndex = 0;  ///< DepthFrame::sourceIndex.
};

}  // namespace cheval::daemon

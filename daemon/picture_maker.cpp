#include "daemon/picture_maker.h"

#include <algorithm>
#include <array>
#include <utility>

namespace cheval::daemon {

namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// A display that gives no buffer for this long is out of order.
constexpr hal::Duration kLongestLoan = milliseconds(200);
/// Shown where a picture could not be drawn: dark, as a mirror in an unlit room.
constexpr hal::Rgba8 kUndrawn{.r = 22, .g = 24, .b = 28, .a = 255};

void fill(hal::ImageView<hal::Rgba8> pixels, hal::Rgba8 colour) {
    for (int y = 0; y < pixels.height; ++y)
        std::fill_n(pixels.row(y), pixels.width, colour);
}

}  // namespace

struct PictureMaker::Tasks {
    static PictureMaker& self(void* context) { return *static_cast<PictureMaker*>(context); }

    static void draw(void* context) {
        PictureMaker& maker = self(context);
        const FramePacket& packet = *maker.packet_;
        render::Scene scene{.view = packet.view,
                            .mesh = packet.dressed ? &packet.mesh : nullptr,
                            .skeleton = packet.skeleton,
                            .hud = packet.hud,
                            .renderScale = packet.renderScale};
        if (packet.hasPicture) {
            scene.camera = {.colour = packet.colour.view(),
                            .depth = packet.depth.view(),
                            .userMap = packet.userMap.view(),
                            .userLabel = packet.userLabel,
                            .intrinsics = packet.intrinsics,
                            .placement = packet.placement};
        }
        maker.outcome_ = maker.renderer_->draw(scene, maker.buffer_.pixels);
    }
    static void present(void* context) {
        PictureMaker& maker = self(context);
        // What a lent buffer holds before it is drawn is anything: an old picture, or nothing.
        if (!maker.outcome_) fill(maker.buffer_.pixels, kUndrawn);
        if (maker.outcome_ && maker.options_.observer) {
            maker.cost_->pause();
            maker.options_.observer(*maker.packet_, maker.buffer_.pixels);
            maker.cost_->resume();
        }
        // A buffer on loan goes back whatever happened, or the display would never lend again.
        Expected<void> presented = maker.display_.present(maker.buffer_, maker.packet_->captureTime);
        if (maker.outcome_ && !presented) maker.outcome_ = std::move(presented);
    }

    static constexpr std::array<Task, 2> kTable = {{
        {.name = "draw", .budget = microseconds(18'000), .priority = 10, .skip = SkipPolicy::never, .work = &draw},
        {.name = "present", .budget = microseconds(2000), .priority = 20, .skip = SkipPolicy::never, .work = &present},
    }};
};

std::span<const Task> PictureMaker::tasks() {
    return Tasks::kTable;
}

Expected<std::unique_ptr<PictureMaker>> PictureMaker::create(const PictureMakerOptions& options,
                                                             std::span<const fitting::Material> materials,
                                                             hal::Display& display, const hal::Clock& cost) {
    auto pausable = std::make_unique<PausableClock>(cost);
    Expected<Scheduler> scheduler = Scheduler::create(Tasks::kTable, options.scheduler, *pausable, *pausable);
    if (!scheduler) return std::move(scheduler).error();
    Expected<std::unique_ptr<render::Renderer>> renderer = render::Renderer::create(options.renderer, materials);
    if (!renderer) return std::move(renderer).error();
    return std::unique_ptr<PictureMaker>(
        new PictureMaker(options, std::move(*renderer), display, std::move(pausable), std::move(*scheduler)));
}

PictureMaker::PictureMaker(const PictureMakerOptions& options, std::unique_ptr<render::Renderer> renderer,
                           hal::Display& display, std::unique_ptr<PausableClock> cost, Scheduler scheduler)
    : options_(options),
      renderer_(std::move(renderer)),
      display_(display),
      cost_(std::move(cost)),
      scheduler_(std::move(scheduler)) {}

PictureMaker::~PictureMaker() = default;

Expected<hal::Duration> PictureMaker::show(const FramePacket& packet) {
    Expected<hal::DisplayBuffer> lent = display_.lend(kLongestLoan);
    if (!lent) return std::move(lent).error();
    buffer_ = *lent;
    packet_ = &packet;
    outcome_ = {};
    const hal::Duration taken = scheduler_.runFrame(cost_->now(), this);
    packet_ = nullptr;
    if (!outcome_) return std::move(outcome_).error();
    return taken;
}

}  // namespace cheval::daemon

#include "daemon/once.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "daemon/devices.h"
#include "daemon/log.h"
#include "daemon/room_options.h"
#include "daemon/visit_report.h"

namespace cheval::daemon {

namespace {

/// After the shopper has gone, for the mirror to notice and to show the attract screen.
constexpr double kAfterwardsSeconds = 1.0;
constexpr double kStatusEverySeconds = 0.5;

std::string captionOf(const MirrorStatus& status) {
    std::string caption(name(status.state));
    if (status.state == SessionState::wearing) {
        caption += ": " + std::string(status.outfit.view());
        if (status.avatarView) caption += " (avatar)";
    }
    return caption;
}

}  // namespace

Expected<OnceResult> runOnce(const config::Settings& given, const OnceOptions& options) {
    config::Settings settings = given;
    settings.sensor.source = config::SensorSource::sim;
    const Wardrobe wardrobe = loadWardrobe(wardrobeOptions(settings));
    for (const Error& refusal : wardrobe.refusals)
        log(Severity::warning, refusal.message());

    hal::VirtualClock clock;
    const hal::VirtualClock still;
    const hal::SteadyClock cost;
    Expected<std::unique_ptr<Screen>> screen = Screen::open(settings, clock);
    if (!screen) return std::move(screen).error();
    std::unique_ptr<VisitReport> report;
    if (!options.report.empty()) {
        Expected<std::unique_ptr<VisitReport>> created =
            VisitReport::create({.folder = options.report, .title = "One visit of the simulated shopper"});
        if (!created) return std::move(created).error();
        report = std::move(*created);
    }
    FrameSource source = makeFrameSource(settings, clock);
    MirrorParts parts{.camera = source.camera,
                      .display = &(*screen)->display(),
                      .mode = (*screen)->mode(),
                      .clock = &clock,
                      .admission = &still,
                      .cost = &cost,
                      .wardrobe = &wardrobe,
                      .runToTheEnd = true};
    if (source.buttons != nullptr) parts.buttons.push_back(source.buttons.get());
    if ((*screen)->buttons() != nullptr) parts.buttons.push_back((*screen)->buttons());
    std::unique_ptr<Mirror> mirror;
    if (report != nullptr) {
        parts.observer = [&mirror, &report](const FramePacket& packet, hal::ImageView<const hal::Rgba8> picture) {
            report->addFrame(picture, packet.captureTime, captionOf(mirror->status()));
        };
    }
    Expected<std::unique_ptr<Mirror>> made = Mirror::create(settings, std::move(parts));
    if (!made) return std::move(made).error();
    mirror = std::move(*made);

    const double leaves =
        settings.simulation.visitSeconds + settings.session.leaveSeconds + settings.session.goneSeconds;
    const double ends =
        std::min(leaves + kAfterwardsSeconds, settings.simulation.visitSeconds + settings.simulation.pauseSeconds);
    double nextStatus = 0.0;
    while (hal::seconds(clock.now()) < ends) {
        const Expected<StepResult> step = mirror->step();
        if (!step) return step.error();
        if (*step == StepResult::stopped || *step == StepResult::ended) break;
        if (options.status && hal::seconds(clock.now()) >= nextStatus) {
            nextStatus += kStatusEverySeconds;
            options.status(mirror->status());
        }
    }
    OnceResult result{.status = mirror->status(),
                      .visitSeconds = hal::seconds(clock.now()),
                      .tasks = mirror->statistics(),
                      .renderer = mirror->rendererDescription()};
    if (report != nullptr) {
        Expected<void> finished = report->finish(result.tasks);
        if (!finished) return std::move(finished).error();
    }
    if (result.status.visits == 0) {
        return Error{.code = ErrorCode::internal,
                     .cause = "the simulated shopper was not dressed",
                     .mend = wardrobe.refusals.empty()
                                 ? "run it with default settings; if it stays so, the program is at fault"
                                 : wardrobe.refusals.front().message(),
                     .why = "one visit is the shortest proof that the mirror works"};
    }
    return result;
}

}  // namespace cheval::daemon

#include "daemon/service_control.h"

#include <csignal>
#include <utility>

#include <unistd.h>

#include "daemon/hud_writer.h"
#include "daemon/log.h"

namespace cheval::daemon {

ServiceControl::ServiceControl(InstanceLock lock, const hal::Clock& clock) : lock_(std::move(lock)), board_(clock) {}

Expected<std::unique_ptr<ServiceControl>> ServiceControl::begin(const config::Settings& settings,
                                                                const hal::Clock& clock) {
    Expected<InstanceLock> lock = InstanceLock::take();
    if (!lock) return std::move(lock).error();
    std::unique_ptr<ServiceControl> control(new ServiceControl(std::move(*lock), clock));
    Expected<void> started = control->startBus(settings.bus.kind);
    if (!started) return std::move(started).error();
    return control;
}

Expected<void> ServiceControl::startBus(config::BusKind kind) {
    kind_ = kind;
    busProblem_.clear();
    Expected<std::unique_ptr<ControlBus>> bus =
        ControlBus::start({.kind = kind,
                           .version = CHEVAL_VERSION,
                           .commands = commands_,
                           // To the process: every thread blocks it, and the main one waits for it.
                           .reload = [] { kill(getpid(), SIGHUP); }});
    if (!bus) {
        busProblem_ = serviceText(bus.error());
        return std::move(bus).error();
    }
    bus_ = std::move(*bus);
    return {};
}

void ServiceControl::settingsChange(const config::Settings& settings) {
    commands_->clear();
    if (settings.bus.kind == kind_) return;
    bus_.reset();
    const Expected<void> started = startBus(settings.bus.kind);
    // At the start a second mirror is refused; one that is lit already stays so.
    if (!started) log(Severity::error, started.error().message());
}

void ServiceControl::report(const Subject& subject) {
    ControlSnapshot snapshot{.mirror = subject.mirror.status(),
                             .tasks = subject.mirror.statistics(),
                             .renderer = subject.mirror.rendererDescription()};
    for (std::size_t rung = 0; rung < kRecoveryRungCount; ++rung)
        snapshot.recovery.emplace_back(name(static_cast<RecoveryRung>(rung)), snapshot.mirror.recovery[rung]);
    for (const OutfitChoice& choice : subject.wardrobe.outfits)
        snapshot.outfits.push_back({.id = choice.id, .name = choice.name});
    HealthInput input{.mirror = snapshot.mirror,
                      .framesPerSecond = subject.settings.loop.fps,
                      .sensorKeepsTime = subject.settings.sensor.source != config::SensorSource::replay,
                      .haveDisplay = subject.settings.display.kind != config::DisplayKind::headless,
                      .haveButtons = subject.haveButtons,
                      .haveBody = subject.wardrobe.body.has_value(),
                      .outfits = subject.wardrobe.outfits.size(),
                      .settingsProblem = subject.settingsProblem,
                      .busWanted = kind_ != config::BusKind::none,
                      .busProblem = bus_ != nullptr ? bus_->problem() : busProblem_};
    for (const Error& refusal : subject.wardrobe.refusals)
        input.refusals.push_back(serviceText(refusal));
    snapshot.health = board_.update(input);
    if (bus_ != nullptr) bus_->publish(std::move(snapshot));
}

}  // namespace cheval::daemon

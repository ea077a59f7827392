#include "daemon/service.h"

#include <csignal>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "daemon/devices.h"
#include "daemon/host_hardware.h"
#include "daemon/hud_writer.h"
#include "daemon/log.h"
#include "daemon/message_ids.h"
#include "daemon/room_options.h"
#include "daemon/service_control.h"
#include "daemon/service_manager.h"
#include "daemon/status_line.h"

namespace cheval::daemon {

namespace {

sigset_t awaitedSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGHUP);
    return signals;
}

/// Everything that belongs to one set of settings but the screen, which stays lit over a change.
class Running {
  public:
    static Expected<std::unique_ptr<Running>> start(const config::Settings& settings, const Screen& screen,
                                                    RemoteCommands* commands, hal::Clock& clock) {
        std::unique_ptr<Running> running(new Running(settings, clock));
        MirrorParts parts{.camera = running->source_.camera,
                          .commands = commands,
                          .hardware = running->hardware_.get(),
                          .display = &screen.display(),
                          .mode = screen.mode(),
                          .clock = &clock,
                          .cost = &clock,
                          .wardrobe = &running->wardrobe_};
        if (running->source_.buttons != nullptr) parts.buttons.push_back(running->source_.buttons.get());
        if (running->buttons_ != nullptr) parts.buttons.push_back(running->buttons_.get());
        if (screen.buttons() != nullptr) parts.buttons.push_back(screen.buttons());
        running->haveButtons_ = !parts.buttons.empty();
        Expected<std::unique_ptr<Mirror>> mirror = Mirror::create(settings, std::move(parts));
        if (!mirror) return std::move(mirror).error();
        running->mirror_ = std::move(*mirror);
        Expected<void> started = running->mirror_->start();
        if (!started) return std::move(started).error();
        // The driver has its own copy of each texture by now, and nobody else asks for them.
        std::vector<fitting::Material>().swap(running->wardrobe_.materials);
        log(Severity::notice, "drawing with " + running->mirror_->rendererDescription());
        return running;
    }

    [[nodiscard]] Mirror& mirror() { return *mirror_; }
    [[nodiscard]] const Wardrobe& wardrobe() const { return wardrobe_; }
    [[nodiscard]] bool haveButtons() const { return haveButtons_; }
    [[nodiscard]] ServiceEnd end() const { return hardware_ != nullptr ? hardware_->end() : ServiceEnd::stopped; }
    /// Refused garments, in short, for the service screen.
    [[nodiscard]] std::string refusals() const {
        std::string text;
        for (const Error& refusal : wardrobe_.refusals)
            text += (text.empty() ? "" : "  |  ") + serviceText(refusal);
        return text;
    }

  private:
    Running(const config::Settings& settings, hal::Clock& clock)
        : wardrobe_(loadWardrobe(wardrobeOptions(settings))),
          source_(makeFrameSource(settings, clock)),
          buttons_(makeButtons(settings, clock)) {
        for (const Error& refusal : wardrobe_.refusals)
            log(Severity::warning, refusal.message(), message::kGarmentRefused);
        // Only a real sensor has a place on the bus.
        if (settings.sensor.source == config::SensorSource::openni)
            hardware_ = std::make_unique<HostHardware>(hostHardwareOptions(settings), clock);
    }

    Wardrobe wardrobe_;
    FrameSource source_;
    std::unique_ptr<hal::Buttons> buttons_;
    std::unique_ptr<HostHardware> hardware_;
    bool haveButtons_ = false;
    std::unique_ptr<Mirror> mirror_;
};

/// The service's state between signals.
class Service {
  public:
    explicit Service(const ServiceOptions& options) : options_(options) {}

    Expected<void> begin() {
        config::LoadedSettings loaded = load();
        settings_ = loaded.settings;
        Expected<std::unique_ptr<ServiceControl>> control = ServiceControl::begin(settings_, clock_);
        if (!control) return std::move(control).error();
        control_ = std::move(*control);
        Expected<std::unique_ptr<Screen>> screen = Screen::open(settings_, clock_);
        if (!screen) return std::move(screen).error();
        screen_ = std::move(*screen);
        Expected<void> lit = light();
        if (lit && options_.started) options_.started(screen_->address());
        return lit;
    }

    void reload() {
        manager_.reloading();
        config::LoadedSettings loaded = load();
        if (!loaded.good()) {
            log(Severity::error, "the settings are refused; the last good ones stay in force");
            tell();
            return;
        }
        const config::Settings before = std::exchange(settings_, loaded.settings);
        Expected<void> lit = relight(before);
        if (lit) {
            log(Severity::notice, "new settings are in force");
            return;
        }
        // What the new settings ask for does not work: a mirror that works is worth more.
        problem_ = serviceText(lit.error());
        log(Severity::error, lit.error().message());
        const config::Settings failed = std::exchange(settings_, before);
        lit = relight(failed);
        if (!lit) log(Severity::error, lit.error().message());
    }

    [[nodiscard]] bool running() const { return running_ != nullptr; }
    void report() {
        if (running_ == nullptr) return;
        const MirrorStatus status = running_->mirror().status();
        screen_->setStatus(statusLine(status));
        manager_.report(status, problem_);
        control_->report({.mirror = running_->mirror(),
                          .wardrobe = running_->wardrobe(),
                          .settings = settings_,
                          .settingsProblem = problem_,
                          .haveButtons = running_->haveButtons()});
        if (options_.status) options_.status(status);
    }
    /// Why it ends, where it was not asked to.
    ServiceEnd end() {
        manager_.stopping();
        const ServiceEnd end = running_->end();
        running_.reset();
        return end;
    }
    [[nodiscard]] ServiceManager& manager() { return manager_; }

  private:
    config::LoadedSettings load() {
        config::LoadedSettings loaded = config::loadSettings(options_.settings);
        problem_.clear();
        for (const Error& problem : loaded.problems)
            log(Severity::error, problem.message(), message::kSettingsRefused);
        if (!loaded.good()) problem_ = serviceText(loaded.problems.front());
        return loaded;
    }

    Expected<void> light() {
        Expected<std::unique_ptr<Running>> running = Running::start(settings_, *screen_, control_->commands(), clock_);
        if (!running) return std::move(running).error();
        running_ = std::move(*running);
        tell();
        return {};
    }

    Expected<void> relight(const config::Settings& before) {
        running_.reset();
        control_->settingsChange(settings_);
        if (!Screen::same(before, settings_)) {
            screen_.reset();
            Expected<std::unique_ptr<Screen>> screen = Screen::open(settings_, clock_);
            if (!screen) return std::move(screen).error();
            screen_ = std::move(*screen);
            if (!screen_->address().empty()) log(Severity::notice, "the mirror is at " + screen_->address());
        }
        return light();
    }

    void tell() {
        const std::string refusals = running_->refusals();
        running_->mirror().setNotice(problem_ + (problem_.empty() || refusals.empty() ? "" : "  |  ") + refusals);
    }

    const ServiceOptions& options_;
    hal::SteadyClock clock_;
    ServiceManager manager_ = ServiceManager::ofThisProcess(clock_);
    config::Settings settings_;
    std::string problem_;
    std::unique_ptr<ServiceControl> control_;
    std::unique_ptr<Screen> screen_;
    std::unique_ptr<Running> running_;
};

}  // namespace

void blockSignals() {
    const sigset_t signals = awaitedSignals();
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

Expected<ServiceEnd> runService(const ServiceOptions& options) {
    if (rebootIsDue(hostHardwareOptions({}))) return ServiceEnd::reboot;
    Service service(options);
    Expected<void> begun = service.begin();
    if (!begun) {
        service.manager().failed(begun.error());
        return std::move(begun).error();
    }
    const sigset_t signals = awaitedSignals();
    while (service.running()) {
        const std::timespec pause{.tv_sec = 0, .tv_nsec = service.manager().pause().count()};
        const int signal = sigtimedwait(&signals, nullptr, &pause);
        if (signal == SIGTERM || signal == SIGINT) break;
        if (signal == SIGHUP) service.reload();
        service.report();
    }
    if (!service.running()) {
        const Error error{.code = ErrorCode::unavailable,
                          .cause = "the mirror could not be lit again",
                          .mend = "read the messages before this one"};
        service.manager().failed(error);
        return error;
    }
    return service.end();
}

}  // namespace cheval::daemon

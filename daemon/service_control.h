// What the service has besides the mirror: the lock against a second one, its health, and the bus that tells it.
#pragma once

#include <memory>
#include <string>

#include "config/settings.h"
#include "daemon/control_bus.h"
#include "daemon/health.h"
#include "daemon/instance_lock.h"
#include "daemon/mirror.h"
#include "daemon/remote_commands.h"
#include "hal/clock.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// Thread-bound (the main thread's); the bus has a thread of its own.
class ServiceControl {
  public:
    /// What report() looks at; borrowed for the call.
    struct Subject {
        const Mirror& mirror;
        const Wardrobe& wardrobe;
        const config::Settings& settings;
        const std::string& settingsProblem;  ///< Empty: they are good.
        bool haveButtons = false;
    };

    /// Errors: unavailable, where a second mirror is refused. `clock` outlives it.
    static Expected<std::unique_ptr<ServiceControl>> begin(const config::Settings& settings, const hal::Clock& clock);

    /// For MirrorParts; valid as long as this is.
    [[nodiscard]] RemoteCommands* commands() const { return commands_.get(); }
    /// Other settings are about to be in force: what waits was meant for the old ones, and the bus may be another.
    void settingsChange(const config::Settings& settings);
    /// Judges and publishes; call it about twice a second. Takes memory.
    void report(const Subject& subject);
    /// As of the last report().
    [[nodiscard]] const std::vector<PartHealth>& health() const { return board_.parts(); }

  private:
    ServiceControl(InstanceLock lock, const hal::Clock& clock);
    Expected<void> startBus(config::BusKind kind);

    InstanceLock lock_;
    HealthBoard board_;
    std::shared_ptr<RemoteCommands> commands_ = std::make_shared<RemoteCommands>();
    config::BusKind kind_ = config::BusKind::none;
    std::unique_ptr<ControlBus> bus_;
    std::string busProblem_;  ///< Where there is no bus_.
};

}  // namespace cheval::daemon

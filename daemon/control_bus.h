// org.cheval.Mirror1 on D-Bus: what the mirror is doing and how it is, and what technicians may ask of it. The
// interface is written down in mirror_interface.h.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "config/settings.h"
#include "daemon/health.h"
#include "daemon/mirror.h"
#include "daemon/remote_commands.h"
#include "daemon/scheduler.h"
#include "hal/clock.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// What the bus tells, as it stood at one time.
struct ControlSnapshot {
    struct Outfit {
        std::string id;
        std::string name;
    };
    MirrorStatus mirror;
    std::vector<Outfit> outfits;
    std::vector<PartHealth> health;
    std::vector<TaskStatistics> tasks;  ///< Names of static storage.
    std::vector<std::pair<std::string, std::uint64_t>> recovery;
    std::string renderer;
};

struct ControlBusOptions {
    config::BusKind kind = config::BusKind::system;
    std::string version;
    std::shared_ptr<RemoteCommands> commands;                   ///< Where wishes go.
    std::function<void()> reload;                               ///< Called in the bus's thread; must not wait.
    hal::Duration firstPause = std::chrono::milliseconds(500);  ///< Before the bus is tried again; doubles …
    hal::Duration longestPause = std::chrono::seconds(30);      ///< … up to this; a bus that answers sets it back.
    hal::Duration startLimit = std::chrono::seconds(2);         ///< How long start() waits for the first try.
};

/// Serves in a thread of its own and never keeps anybody else waiting. A bus that is not there, goes away or refuses
/// the name is tried again for as long as this lives; problem() says so meanwhile. Thread-safe.
class ControlBus {
  public:
    /// Errors: unavailable, where another mirror owns the name. Anything else that goes wrong is a problem() only. With
    /// kind none it does nothing at all.
    static Expected<std::unique_ptr<ControlBus>> start(const ControlBusOptions& options);
    /// Ends the thread within about a tenth of a second; a bus that hangs while it is being reached is left behind.
    ~ControlBus();
    ControlBus(const ControlBus&) = delete;
    ControlBus& operator=(const ControlBus&) = delete;

    /// From now on the bus tells this.
    void publish(ControlSnapshot snapshot);
    /// Why nobody can ask the mirror anything, with a mend; empty: they can.
    [[nodiscard]] std::string problem() const;

  private:
    struct Core;
    class Connected;
    explicit ControlBus(std::shared_ptr<Core> core) : core_(std::move(core)) {}
    static void serve(const std::shared_ptr<Core>& core);

    std::shared_ptr<Core> core_;  ///< Shared with the thread, which may outlive this in a bus that hangs.
    std::thread thread_;
};

}  // namespace cheval::daemon

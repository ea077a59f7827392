#include "daemon/control_bus.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include <poll.h>

#include "daemon/clean_text.h"
#include "daemon/log.h"
#include "daemon/mirror_interface.h"

namespace cheval::daemon {

namespace {

using namespace mirror1;
using std::chrono::milliseconds;

/// PropertiesChanged comes at most this often.
constexpr hal::Duration kSignalEvery = milliseconds(500);
/// The longest wait for the bus; how soon the thread sees that it should end.
constexpr hal::Duration kLongestWait = milliseconds(100);
/// Of a call of ours to the bus itself.
constexpr std::chrono::seconds kCallLimit{2};
/// For the thread to end before it is left behind.
constexpr milliseconds kEndLimit{500};

std::uint64_t microseconds(hal::Duration duration) {
    const auto count = std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
    return count < 0 ? 0 : static_cast<std::uint64_t>(count);
}

std::vector<HealthRow> healthRows(const std::vector<PartHealth>& parts) {
    std::vector<HealthRow> rows;
    rows.reserve(parts.size());
    for (const PartHealth& part : parts) {
        rows.emplace_back(std::string(part.part), std::string(name(part.state)), cleanText(part.reason),
                          microseconds(part.sinceWall.time_since_epoch()), microseconds(part.since.time_since_epoch()));
    }
    return rows;
}

std::vector<TaskRow> taskRows(const std::vector<TaskStatistics>& tasks) {
    std::vector<TaskRow> rows;
    rows.reserve(tasks.size());
    for (const TaskStatistics& task : tasks) {
        const std::uint64_t whole = task.name.ends_with("whole frame") ? 1 : 0;
        rows.emplace_back(std::string(task.name), microseconds(task.budget), microseconds(task.minimum),
                          microseconds(task.mean), microseconds(task.p99), microseconds(task.maximum), task.runs,
                          task.overruns, task.skips, whole);
    }
    return rows;
}

std::string outfitId(const ControlSnapshot& snapshot) {
    const std::size_t index = snapshot.mirror.outfitIndex;
    return index < snapshot.outfits.size() ? cleanText(snapshot.outfits[index].id) : std::string();
}

std::string stateOf(const std::optional<ControlSnapshot>& snapshot) {
    return snapshot ? std::string(name(snapshot->mirror.state)) : "starting";
}

bool sameHealth(const std::vector<PartHealth>& a, const std::vector<PartHealth>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PartHealth& one, const PartHealth& other) {
        return one.part == other.part && one.state == other.state && one.since == other.since &&
               one.reason == other.reason;
    });
}

std::string_view busName(config::BusKind kind) {
    return kind == config::BusKind::session ? "session bus" : "system bus";
}

/// Somebody else owns the name: sd-bus says it with this errno.
bool nameTaken(const sdbus::Error& error) {
    return error.getName() == sdbus::createError(EEXIST, "").getName();
}

std::string problemText(const sdbus::Error& error, config::BusKind kind) {
    if (nameTaken(error)) {
        return std::string("another program owns ") + kName + " on the " + std::string(busName(kind)) +
               ". Mend: end it; the name is asked for again";
    }
    if (error.getName() == "org.freedesktop.DBus.Error.AccessDenied") {
        return std::string("the ") + std::string(busName(kind)) + " does not let this account own " + kName +
               ". Mend: install org.cheval.Mirror1.conf and run the mirror as the user cheval; it is tried again";
    }
    // Without what the system says: that changes from one try to the next, and the trouble is one and the same.
    return "the " + std::string(busName(kind)) +
           " cannot be reached. Mend: see that dbus runs, or set bus.kind; it is tried again";
}

}  // namespace

/// What both threads share.
struct ControlBus::Core {
    enum class FirstTry : std::uint8_t { pending, settled, taken };

    explicit Core(ControlBusOptions given) : options(std::move(given)) {}

    const ControlBusOptions options;
    hal::SteadyClock clock;
    const hal::TimePoint started = clock.now();
    hal::Interrupt stopping;

    mutable std::mutex mutex;  ///< Guards what follows.
    std::condition_variable changed;
    std::optional<ControlSnapshot> snapshot;
    std::string problem = "the bus has not answered yet";
    FirstTry firstTry = FirstTry::pending;
    bool ended = false;

    /// Reads from the snapshot, or gives what `T` is made with before there is any.
    template <typename T, typename Read>
    T read(Read&& get) const {
        const std::lock_guard lock(mutex);
        return snapshot ? T(get(*snapshot)) : T();
    }

    void settle(FirstTry outcome, const std::string& trouble, const std::string& detail = {}) {
        const bool wasNew = [&] {
            const std::lock_guard lock(mutex);
            if (firstTry == FirstTry::pending) firstTry = outcome;
            return std::exchange(problem, trouble) != trouble;
        }();
        changed.notify_all();
        // Told when it changes, not at every try.
        if (!wasNew || outcome == FirstTry::taken) return;
        if (trouble.empty()) {
            log(Severity::notice, std::string(kName) + " is on the " + std::string(busName(options.kind)));
        } else {
            log(Severity::warning, trouble + (detail.empty() ? "" : ". Why: " + detail));
        }
    }

    void ask(const RemoteCommand& command) const {
        if (!options.commands->push(command))
            throw sdbus::Error(kBusy, "too many wishes at once; the mirror takes them frame by frame, so ask again");
    }
};

/// One connection, from the first byte to the loss of the bus. Bound to the bus's thread.
class ControlBus::Connected {
  public:
    /// Throws sdbus::Error where the bus or the name cannot be had.
    explicit Connected(Core& core) : core_(core), connection_(connect(core.options.kind)) {
        connection_->setMethodCallTimeout(kCallLimit);
        object_ = sdbus::createObject(*connection_, kPath);
        describe();
        remember();
        connection_->requestName(kName);
    }

    /// Until the bus goes away (throws sdbus::Error) or the end.
    void serve() {
        hal::TimePoint nextSignal = core_.clock.now();
        while (!core_.stopping.raised()) {
            while (!core_.stopping.raised() && connection_->processPendingRequest()) {
            }
            if (core_.clock.now() >= nextSignal && signalChanges()) nextSignal = core_.clock.now() + kSignalEvery;
            const sdbus::IConnection::PollData wishes = connection_->getEventLoopPollData();
            const int longest = static_cast<int>(std::chrono::duration_cast<milliseconds>(kLongestWait).count());
            const int wanted = wishes.getPollTimeout();
            pollfd descriptor{.fd = wishes.fd, .events = wishes.events, .revents = 0};
            poll(&descriptor, 1, wanted < 0 ? longest : std::min(wanted, longest));
        }
    }

  private:
    static std::unique_ptr<sdbus::IConnection> connect(config::BusKind kind) {
        return kind == config::BusKind::session ? sdbus::createSessionBusConnection()
                                                : sdbus::createSystemBusConnection();
    }

    template <typename T, typename Read>
    void property(const char* propertyName, bool signalled, Read read) {
        object_->registerProperty(propertyName)
            .onInterface(kInterface)
            .withGetter([this, read]() -> T { return core_.read<T>(read); })
            .withUpdateBehavior(signalled ? sdbus::Flags::EMITS_CHANGE_SIGNAL : sdbus::Flags::EMITS_NO_SIGNAL);
    }

    void describe() {
        using Snapshot = ControlSnapshot;
        using Number = std::uint64_t;
        using Text = std::string;
        object_->registerProperty("State").onInterface(kInterface).withGetter([this]() -> Text {
            const std::lock_guard lock(core_.mutex);
            return stateOf(core_.snapshot);
        });
        property<Text>("Outfit", true, outfitId);
        property<std::vector<OutfitRow>>("Outfits", false, [](const Snapshot& snapshot) {
            std::vector<OutfitRow> rows;
            for (const Snapshot::Outfit& outfit : snapshot.outfits)
                rows.emplace_back(cleanText(outfit.id), cleanText(outfit.name));
            return rows;
        });
        property<Text>("View", false,
                       [](const Snapshot& snapshot) { return snapshot.mirror.avatarView ? "avatar" : "mirror"; });
        property<double>("FramesPerSecond", false,
                         [](const Snapshot& snapshot) { return snapshot.mirror.framesPerSecond; });
        property<std::uint32_t>("DegradeLevel", false, [](const Snapshot& snapshot) {
            return static_cast<std::uint32_t>(snapshot.mirror.degradeLevel);
        });
        property<Text>("DegradeName", false, [](const Snapshot& snapshot) { return snapshot.mirror.degradeName; });
        property<Number>("Visits", false, [](const Snapshot& snapshot) { return snapshot.mirror.visits; });
        property<Number>("Frames", false, [](const Snapshot& snapshot) { return snapshot.mirror.frames; });
        property<Number>("Pictures", false, [](const Snapshot& snapshot) { return snapshot.mirror.pictures; });
        property<Text>("Renderer", false, [](const Snapshot& snapshot) { return cleanText(snapshot.renderer); });
        property<std::vector<HealthRow>>("Health", true,
                                         [](const Snapshot& snapshot) { return healthRows(snapshot.health); });
        property<Text>("Overall", true, [](const Snapshot& snapshot) { return name(overall(snapshot.health)); });
        property<std::vector<TaskRow>>("Tasks", false,
                                       [](const Snapshot& snapshot) { return taskRows(snapshot.tasks); });
        property<std::vector<RecoveryRow>>("Recovery", false, [](const Snapshot& snapshot) {
            std::vector<RecoveryRow> rows;
            for (const auto& [rung, count] : snapshot.recovery)
                rows.emplace_back(cleanText(rung), count);
            return rows;
        });
        object_->registerProperty("Uptime")
            .onInterface(kInterface)
            .withGetter([this]() -> Number { return microseconds(core_.clock.now() - core_.started) / 1'000'000; })
            .withUpdateBehavior(sdbus::Flags::EMITS_NO_SIGNAL);
        object_->registerProperty("Version")
            .onInterface(kInterface)
            .withGetter([this]() -> Text { return core_.options.version; })
            .withUpdateBehavior(sdbus::Flags::EMITS_NO_SIGNAL);

        object_->registerMethod("NextOutfit").onInterface(kInterface).implementedAs([this] {
            core_.ask({.kind = RemoteCommand::Kind::next});
        });
        object_->registerMethod("PreviousOutfit").onInterface(kInterface).implementedAs([this] {
            core_.ask({.kind = RemoteCommand::Kind::previous});
        });
        object_->registerMethod("SetOutfit")
            .onInterface(kInterface)
            .withInputParamNames("outfit")
            .implementedAs([this](const Text& wanted) { setOutfit(wanted); });
        object_->registerMethod("SetView")
            .onInterface(kInterface)
            .withInputParamNames("view")
            .implementedAs([this](const Text& wanted) { setView(wanted); });
        object_->registerMethod("Reload").onInterface(kInterface).implementedAs([this] {
            if (core_.options.reload) core_.options.reload();
        });
        object_->finishRegistration();
    }

    void setOutfit(const std::string& wanted) const {
        const std::size_t index = [&] {
            const std::lock_guard lock(core_.mutex);
            if (!core_.snapshot) throw sdbus::Error(kNotReady, "the mirror is not lit yet; ask again");
            const std::vector<ControlSnapshot::Outfit>& outfits = core_.snapshot->outfits;
            const auto found = std::find_if(outfits.begin(), outfits.end(), [&](const ControlSnapshot::Outfit& outfit) {
                return wanted == cleanText(outfit.id) || wanted == cleanText(outfit.name);
            });
            if (found != outfits.end()) return static_cast<std::size_t>(found - outfits.begin());
            std::string known;
            for (const ControlSnapshot::Outfit& outfit : outfits)
                known += (known.empty() ? "" : ", ") + cleanText(outfit.id);
            throw sdbus::Error(kUnknownOutfit, "there is no outfit \"" + cleanText(wanted) +
                                                   "\"; there are: " + (known.empty() ? "none" : known));
        }();
        core_.ask({.kind = RemoteCommand::Kind::choose, .outfit = index});
    }

    void setView(const std::string& wanted) const {
        if (wanted != "mirror" && wanted != "avatar") {
            throw sdbus::Error(kUnknownView,
                               "there is no view \"" + cleanText(wanted) + "\"; there are: mirror, avatar");
        }
        core_.ask({.kind = wanted == "avatar" ? RemoteCommand::Kind::avatarView : RemoteCommand::Kind::mirrorView});
    }

    /// What listeners know, for signalChanges().
    void remember() {
        const std::lock_guard lock(core_.mutex);
        state_ = stateOf(core_.snapshot);
        outfit_ = core_.snapshot ? outfitId(*core_.snapshot) : "";
        health_ = core_.snapshot ? core_.snapshot->health : std::vector<PartHealth>();
    }

    bool signalChanges() {
        std::vector<std::string> names;
        {
            const std::lock_guard lock(core_.mutex);
            if (!core_.snapshot) return false;
            if (state_ != stateOf(core_.snapshot)) names.emplace_back("State");
            if (outfit_ != outfitId(*core_.snapshot)) names.emplace_back("Outfit");
            if (!sameHealth(health_, core_.snapshot->health)) {
                names.emplace_back("Health");
                if (overall(health_) != overall(core_.snapshot->health)) names.emplace_back("Overall");
            }
        }
        if (names.empty()) return false;
        remember();
        object_->emitPropertiesChangedSignal(kInterface, names);
        return true;
    }

    Core& core_;
    std::unique_ptr<sdbus::IConnection> connection_;
    std::unique_ptr<sdbus::IObject> object_;
    std::string state_;
    std::string outfit_;
    std::vector<PartHealth> health_;
};

void ControlBus::serve(const std::shared_ptr<Core>& core) {
    hal::Duration pause = core->options.firstPause;
    while (!core->stopping.raised()) {
        try {
            Connected connected(*core);
            core->settle(Core::FirstTry::settled, "");
            pause = core->options.firstPause;
            connected.serve();
        } catch (const sdbus::Error& error) {
            const bool taken = nameTaken(error);
            core->settle(taken ? Core::FirstTry::taken : Core::FirstTry::settled,
                         problemText(error, core->options.kind), cleanText(error.getMessage()));
        }
        core->clock.waitUntil(core->clock.now() + pause, core->stopping);
        pause = std::min(pause * 2, core->options.longestPause);
    }
    const std::lock_guard lock(core->mutex);
    core->ended = true;
    core->changed.notify_all();
}

Expected<std::unique_ptr<ControlBus>> ControlBus::start(const ControlBusOptions& options) {
    std::unique_ptr<ControlBus> bus(new ControlBus(std::make_shared<Core>(options)));
    Core& core = *bus->core_;
    if (options.kind == config::BusKind::none) {
        core.problem.clear();
        return bus;
    }
    bus->thread_ = std::thread([shared = bus->core_] { serve(shared); });
    std::unique_lock lock(core.mutex);
    core.changed.wait_for(lock, options.startLimit, [&] { return core.firstTry != Core::FirstTry::pending; });
    if (core.firstTry == Core::FirstTry::taken) {
        lock.unlock();
        return Error{
            .code = ErrorCode::conflict,
            .cause = std::string("another mirror owns ") + kName + " on the " + std::string(busName(options.kind)),
            .mend = "end it first (systemctl stop cheval), or set bus.kind to another bus or to \"none\"",
            .why = "two would fight over the sensor, the display and the buttons"};
    }
    return bus;
}

ControlBus::~ControlBus() {
    if (!thread_.joinable()) return;
    core_->stopping.raise();
    std::unique_lock lock(core_->mutex);
    const bool ended = core_->changed.wait_for(lock, kEndLimit, [this] { return core_->ended; });
    lock.unlock();
    // A bus that accepts and says nothing holds its caller for a minute and a half; the mirror ends within a second.
    if (ended) {
        thread_.join();
    } else {
        thread_.detach();
    }
}

void ControlBus::publish(ControlSnapshot snapshot) {
    const std::lock_guard lock(core_->mutex);
    core_->snapshot = std::move(snapshot);
}

std::string ControlBus::problem() const {
    const std::lock_guard lock(core_->mutex);
    return core_->problem;
}

}  // namespace cheval::daemon

#include "daemon/mirror_client.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/clean_text.h"
#include "daemon/mirror_interface.h"

namespace cheval::daemon {

namespace {

using namespace mirror1;
using Properties = std::map<std::string, sdbus::Variant>;

constexpr std::chrono::seconds kLimit{5};

std::unique_ptr<sdbus::IConnection> connect(config::BusKind bus) {
    return bus == config::BusKind::session ? sdbus::createSessionBusConnection() : sdbus::createSystemBusConnection();
}

Error explain(const sdbus::Error& error, config::BusKind bus, bool connected) {
    const std::string where = bus == config::BusKind::session ? "session bus" : "system bus";
    const std::string& name = error.getName();
    const auto isOneOf = [&name](std::initializer_list<std::string_view> names) {
        return std::any_of(names.begin(), names.end(), [&](std::string_view one) {
            return name == "org.freedesktop.DBus.Error." + std::string(one);
        });
    };
    if (!connected) {
        return {.code = ErrorCode::unavailable,
                .cause = "the " + where + " cannot be reached: " + cleanText(error.getMessage()),
                .mend = bus == config::BusKind::session
                            ? "set DBUS_SESSION_BUS_ADDRESS, or ask with --bus system"
                            : "see that dbus runs (systemctl status dbus), or ask another bus with --bus"};
    }
    if (name.starts_with("org.cheval.Error.")) {
        return {.code = ErrorCode::notFound, .cause = cleanText(error.getMessage())};
    }
    if (isOneOf({"ServiceUnknown", "NameHasNoOwner"})) {
        return {.code = ErrorCode::unavailable,
                .cause = "no mirror is running on the " + where,
                .mend =
                    "start it (systemctl start cheval), read why it ended (journalctl -u cheval), or ask another "
                    "bus with --bus",
                .why = std::string("nobody owns ") + kName};
    }
    if (isOneOf({"AccessDenied", "AuthFailed"})) {
        return {.code = ErrorCode::invalidInput,
                .cause = "this account may not ask the mirror",
                .mend = "use sudo, or add it to the group cheval",
                .why = "whoever may ask sees what the shop does, and may change it"};
    }
    if (isOneOf({"NoReply", "Timeout", "TimedOut"})) {
        return {.code = ErrorCode::timedOut,
                .cause = "the mirror does not answer within " + std::to_string(kLimit.count()) + " s",
                .mend = "try again; if it stays so, restart it (systemctl restart cheval)"};
    }
    return {.code = ErrorCode::unavailable,
            .cause = "the mirror's answer is an error: " + cleanText(error.getMessage()),
            .mend = "see that chevalctl and chevald are of one version",
            .why = cleanText(name)};
}

/// What is missing (an older daemon) stays at its default.
template <typename T>
T get(const Properties& properties, const char* key) {
    const auto found = properties.find(key);
    return found == properties.end() ? T() : found->second.get<T>();
}

hal::Duration fromMicroseconds(std::uint64_t count) {
    return std::chrono::microseconds(static_cast<std::int64_t>(count));
}

MirrorReport reportOf(const Properties& properties) {
    MirrorReport report;
    report.version = get<std::string>(properties, "Version");
    report.uptimeSeconds = get<std::uint64_t>(properties, "Uptime");
    report.state = get<std::string>(properties, "State");
    report.outfit = get<std::string>(properties, "Outfit");
    report.view = get<std::string>(properties, "View");
    for (const OutfitRow& row : get<std::vector<OutfitRow>>(properties, "Outfits"))
        report.outfits.push_back({.id = row.get<0>(), .name = row.get<1>()});
    report.framesPerSecond = get<double>(properties, "FramesPerSecond");
    report.degradeLevel = get<std::uint32_t>(properties, "DegradeLevel");
    report.degradeName = get<std::string>(properties, "DegradeName");
    report.visits = get<std::uint64_t>(properties, "Visits");
    report.frames = get<std::uint64_t>(properties, "Frames");
    report.pictures = get<std::uint64_t>(properties, "Pictures");
    report.renderer = get<std::string>(properties, "Renderer");
    report.overall = get<std::string>(properties, "Overall");
    const hal::TimePoint now = hal::SteadyClock().now();
    for (const HealthRow& row : get<std::vector<HealthRow>>(properties, "Health")) {
        const hal::Duration age = now - hal::TimePoint(fromMicroseconds(row.get<4>()));
        report.health.push_back({.part = row.get<0>(),
                                 .state = row.get<1>(),
                                 .reason = row.get<2>(),
                                 .since = std::chrono::system_clock::time_point(fromMicroseconds(row.get<3>())),
                                 .age = std::max(age, hal::Duration::zero())});
    }
    for (const TaskRow& row : get<std::vector<TaskRow>>(properties, "Tasks")) {
        report.tasks.push_back({.name = row.get<0>(),
                                .budget = fromMicroseconds(row.get<1>()),
                                .minimum = fromMicroseconds(row.get<2>()),
                                .mean = fromMicroseconds(row.get<3>()),
                                .p99 = fromMicroseconds(row.get<4>()),
                                .maximum = fromMicroseconds(row.get<5>()),
                                .runs = row.get<6>(),
                                .overruns = row.get<7>(),
                                .skips = row.get<8>(),
                                .wholeFrame = row.get<9>() != 0});
    }
    for (const RecoveryRow& row : get<std::vector<RecoveryRow>>(properties, "Recovery"))
        report.recovery.emplace_back(row.get<0>(), row.get<1>());
    return report;
}

/// Runs `ask` with a proxy of the mirror; what sdbus-c++ throws becomes an Error.
template <typename T, typename Ask>
Expected<T> withMirror(config::BusKind bus, Ask&& ask) {
    bool connected = false;
    try {
        const std::unique_ptr<sdbus::IConnection> connection = connect(bus);
        connected = true;
        const std::unique_ptr<sdbus::IProxy> mirror = sdbus::createProxy(*connection, kName, kPath);
        return ask(*mirror);
    } catch (const sdbus::Error& error) {
        return explain(error, bus, connected);
    }
}

}  // namespace

Expected<MirrorReport> askMirror(config::BusKind bus) {
    return withMirror<MirrorReport>(bus, [](sdbus::IProxy& mirror) -> Expected<MirrorReport> {
        Properties properties;
        mirror.callMethod("GetAll")
            .onInterface("org.freedesktop.DBus.Properties")
            .withTimeout(kLimit)
            .withArguments(kInterface)
            .storeResultsTo(properties);
        return reportOf(properties);
    });
}

Expected<void> tellMirror(config::BusKind bus, const std::string& method, const std::optional<std::string>& argument) {
    return withMirror<void>(bus, [&](sdbus::IProxy& mirror) -> Expected<void> {
        if (argument) {
            mirror.callMethod(method).onInterface(kInterface).withTimeout(kLimit).withArguments(*argument);
        } else {
            mirror.callMethod(method).onInterface(kInterface).withTimeout(kLimit);
        }
        return {};
    });
}

}  // namespace cheval::daemon

#include "daemon/control_commands.h"

#include <cstdlib>
#include <map>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "daemon/log.h"
#include "daemon/mirror_client.h"
#include "daemon/status_report.h"

namespace cheval::daemon {

namespace {

constexpr int kGood = 0;
constexpr int kFailed = 1;

int failed(const Error& error) {
    log(Severity::error, error.message());
    return kFailed;
}

bool colourWanted() {
    const char* off = std::getenv("NO_COLOR");
    return isatty(STDOUT_FILENO) != 0 && (off == nullptr || *off == '\0');
}

int tell(config::BusKind bus, const char* method, const std::optional<std::string>& argument = std::nullopt) {
    const Expected<void> told = tellMirror(bus, method, argument);
    return told ? kGood : failed(told.error());
}

}  // namespace

ControlCommands::ControlCommands(CLI::App& app) {
    static const std::map<std::string, config::BusKind> kBuses{{"system", config::BusKind::system},
                                                               {"session", config::BusKind::session}};
    // The transformer would list the values twice, once as numbers.
    const auto addBus = [this](CLI::App* command) {
        command
            ->add_option_function<std::string>(
                "--bus", [this](const std::string& name) { bus_ = kBuses.at(name); },
                "Where the mirror is, see the setting bus.kind")
            ->check(CLI::IsMember({"system", "session"}))
            ->default_str("system");
    };
    status_ = app.add_subcommand("status", "Say how the running mirror is doing, part by part")->fallthrough();
    status_->footer("Exit status: 0 nothing is at fault; 1 the mirror cannot be reached; 4 some part is at fault.");
    status_->add_flag("--json", json_, "As JSON, for programs");
    outfit_ =
        app.add_subcommand("outfit", "Change the clothes of the running mirror")->require_subcommand(1)->fallthrough();
    next_ = outfit_->add_subcommand("next", "The next outfit")->fallthrough();
    previous_ = outfit_->add_subcommand("previous", "The previous outfit")->fallthrough();
    set_ = outfit_->add_subcommand("set", "This outfit")->fallthrough();
    set_->add_option("name", name_, "Its id or its name, see outfit list")->required();
    list_ = outfit_->add_subcommand("list", "Print the ids of the outfits that there are")->fallthrough();
    reload_ = app.add_subcommand("reload", "Let the running mirror read its settings again")->fallthrough();
    for (CLI::App* command : {status_, outfit_, reload_})
        addBus(command);
}

std::optional<int> ControlCommands::run() const {
    if (next_->parsed()) return tell(bus_, "NextOutfit");
    if (previous_->parsed()) return tell(bus_, "PreviousOutfit");
    if (set_->parsed()) return tell(bus_, "SetOutfit", name_);
    if (reload_->parsed()) {
        const int told = tell(bus_, "Reload");
        if (told == kGood) fmt::print("asked; chevalctl status says under \"settings\" whether they were taken\n");
        return told;
    }
    if (!status_->parsed() && !list_->parsed()) return std::nullopt;
    const Expected<MirrorReport> report = askMirror(bus_);
    if (!report) return failed(report.error());
    if (list_->parsed()) {
        for (const MirrorReport::Outfit& outfit : report->outfits)
            fmt::print("{}\n", outfit.id);
        return kGood;
    }
    fmt::print("{}", json_ ? statusAsJson(*report) : statusForPeople(*report, colourWanted()));
    return report->atFault() ? kAtFault : kGood;
}

}  // namespace cheval::daemon

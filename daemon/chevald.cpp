// The daemon: the mirror itself.
#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "config/loader.h"
#include "daemon/guarded_main.h"
#include "daemon/log.h"
#include "daemon/message_ids.h"
#include "daemon/once.h"
#include "daemon/service.h"
#include "daemon/status_line.h"

namespace {

using namespace cheval;
using daemon::MirrorStatus;
using daemon::Severity;

constexpr int kGood = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;
constexpr int kBadSettings = 3;
constexpr int kConflict = 4;
// What systemd/cheval.service acts upon.
constexpr int kRestart = 75;
constexpr int kReboot = 76;

constexpr const char* kFooter =
    "Exit status: 0 all went well; 1 the mirror could not be lit, or the visit of --once failed; 2 the command line "
    "is\n"
    "wrong; 3 the settings are refused (--check-config, --once); 4 another mirror runs, or the preview's port is "
    "taken;\n"
    "75 the sensor needs the daemon started anew; 76 it needs the machine started anew.\n"
    "Signals: SIGTERM and SIGINT end it within a second; SIGHUP reads the settings again.";

/// One line that is written over and over on a terminal, and line after line elsewhere.
void printStatus(const MirrorStatus& status) {
    const bool terminal = isatty(STDOUT_FILENO) != 0;
    fmt::print("{}{}{}", terminal ? "\r\033[K" : "", daemon::statusLine(status), terminal ? "" : "\n");
    std::fflush(stdout);
}

int checkConfig(const config::LoadOptions& options) {
    const config::LoadedSettings loaded = config::loadSettings(options);
    for (const std::string& file : loaded.files)
        fmt::print("read {}\n", file);
    for (const Error& problem : loaded.problems)
        daemon::log(Severity::error, problem.message());
    if (loaded.good()) fmt::print("the settings are good\n");
    return loaded.good() ? kGood : kBadSettings;
}

int once(const config::LoadOptions& options, const std::string& report, bool statusLine) {
    const config::LoadedSettings loaded = config::loadSettings(options);
    for (const Error& problem : loaded.problems)
        daemon::log(Severity::error, problem.message());
    if (!loaded.good()) return kBadSettings;
    daemon::OnceOptions wishes{.report = report};
    if (statusLine) wishes.status = printStatus;
    const Expected<daemon::OnceResult> result = daemon::runOnce(loaded.settings, wishes);
    if (statusLine && isatty(STDOUT_FILENO) != 0) fmt::print("\n");
    if (!result) {
        daemon::log(Severity::error, result.error().message());
        return kFailed;
    }
    fmt::print("one visit of {:.1f} s: {} frames, {} pictures, dressed {} time(s), drawn with {}\n",
               result->visitSeconds, result->status.frames, result->status.pictures, result->status.visits,
               result->renderer);
    return kGood;
}

int serve(const config::LoadOptions& options, bool statusLine) {
    daemon::ServiceOptions wishes{.settings = options};
    wishes.started = [](const std::string& address) {
        if (!address.empty()) fmt::print("The mirror is at {}\n", address);
        std::fflush(stdout);
    };
    if (statusLine) wishes.status = printStatus;
    const Expected<daemon::ServiceEnd> ended = daemon::runService(wishes);
    if (statusLine && isatty(STDOUT_FILENO) != 0) fmt::print("\n");
    if (ended) {
        switch (*ended) {
            case daemon::ServiceEnd::stopped:
                return kGood;
            case daemon::ServiceEnd::restart:
                return kRestart;
            case daemon::ServiceEnd::reboot:
                return kReboot;
        }
    }
    daemon::log(Severity::error, ended.error().message(), daemon::message::kNotLit);
    return ended.error().code == ErrorCode::conflict ? kConflict : kFailed;
}

int run(int argc, char** argv) {
    CLI::App app{"The virtual fitting mirror's daemon."};
    app.footer(kFooter);
    std::string folder;
    std::string report;
    bool check = false;
    bool oneVisit = false;
    bool statusLine = false;
    app.add_option("--config", folder, "Folder with cheval.toml and cheval.toml.d/*.toml (default: /etc/cheval)");
    auto* checkFlag = app.add_flag("--check-config", check, "Check the settings and exit");
    auto* onceFlag = app.add_flag("--once", oneVisit, "One visit of the simulated shopper on virtual time, then exit")
                         ->excludes(checkFlag);
    app.add_option("--report", report,
                   "With --once: leave a contact sheet, an animated picture and the frame budget in this folder")
        ->needs(onceFlag);
    app.add_flag("--status-line", statusLine, "Show a live line of status on standard output");
    app.set_version_flag("--version", "chevald " CHEVAL_VERSION);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? kGood : kUsage;
    }
    config::LoadOptions options;
    if (!folder.empty()) {
        options.folder = folder;
        options.folderRequired = true;
    }
    if (check) return checkConfig(options);
    if (oneVisit) return once(options, report, statusLine || isatty(STDOUT_FILENO) != 0);
    daemon::blockSignals();
    return serve(options, statusLine || isatty(STDOUT_FILENO) != 0);
}

}  // namespace

int main(int argc, char** argv) {
    return cheval::daemon::guardedMain(run, argc, argv, kFailed);
}

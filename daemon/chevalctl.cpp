// For technicians and merchandisers.
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "config/loader.h"
#include "config/settings_table.h"
#include "daemon/control_commands.h"
#include "daemon/guarded_main.h"
#include "daemon/hands_run.h"
#include "daemon/log.h"
#include "daemon/record_run.h"
#include "daemon/replay_run.h"

namespace {

using namespace cheval;
using daemon::Severity;

constexpr int kGood = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;
constexpr int kBadSettings = 3;

constexpr const char* kFooter =
    "Exit status: 0 all went well; 1 it could not be done; 2 the command line is wrong; 3 the settings are "
    "refused; 4 a part of the mirror is at fault (status).";

const std::map<std::string, daemon::ReplayView> kReplayViews{{"mirror", daemon::ReplayView::mirror},
                                                             {"avatar", daemon::ReplayView::avatar},
                                                             {"tracking", daemon::ReplayView::tracking}};

struct ReplayArguments {
    daemon::ReplayRunOptions options;
    std::string view = "mirror";
    std::string speed = "max";
    std::string size;
};

void printProblems(const config::LoadedSettings& loaded) {
    for (const Error& problem : loaded.problems)
        daemon::log(Severity::error, problem.message());
}

int showConfig(const config::LoadOptions& options, bool defaults) {
    if (defaults) {
        fmt::print("{}", config::describeSettings(config::defaultSettings(), {}));
        return kGood;
    }
    const config::LoadedSettings loaded = config::loadSettings(options);
    fmt::print("{}", config::describeSettings(loaded.settings, loaded.origins));
    printProblems(loaded);
    return loaded.good() ? kGood : kBadSettings;
}

int checkConfig(const config::LoadOptions& options) {
    const config::LoadedSettings loaded = config::loadSettings(options);
    for (const std::string& file : loaded.files)
        fmt::print("read {}\n", file);
    printProblems(loaded);
    if (loaded.good()) fmt::print("the settings are good\n");
    return loaded.good() ? kGood : kBadSettings;
}

/// Reads digits off the front of `text`; false where there are none, or more than a size can have.
bool takeNumber(std::string_view& text, int& value) {
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc() || value < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return true;
}

/// Puts "WIDTHxHEIGHT" in place of the display's size; empty leaves it as it is.
Expected<void> applySize(const std::string& size, config::Settings& settings) {
    if (size.empty()) return {};
    int width = 0;
    int height = 0;
    std::string_view rest = size;
    const bool wide = takeNumber(rest, width) && rest.starts_with('x');
    if (wide) rest.remove_prefix(1);
    if (!wide || !takeNumber(rest, height) || !rest.empty()) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "--size: \"" + size + "\" is no size",
                     .mend = "write it like 1080x1920"};
    }
    for (const config::Setting& setting : config::settingsTable()) {
        const bool isWidth = setting.path == "display.width";
        if (!isWidth && setting.path != "display.height") continue;
        const int value = isWidth ? width : height;
        if (value < setting.low || value > setting.high) {
            return Error{
                .code = ErrorCode::invalidInput,
                .cause = fmt::format("--size: \"{}\" has a {} out of range", size, isWidth ? "width" : "height"),
                .mend = fmt::format("give a {} of {} to {} pixels", isWidth ? "width" : "height", setting.low,
                                    setting.high)};
        }
        setting.set(settings, std::int64_t{value});
    }
    return {};
}

int replay(const config::LoadOptions& where, ReplayArguments& arguments) {
    config::LoadedSettings loaded = config::loadSettings(where);
    printProblems(loaded);
    if (!loaded.good()) return kBadSettings;
    const Expected<void> sized = applySize(arguments.size, loaded.settings);
    if (!sized) {
        daemon::log(Severity::error, sized.error().message());
        return kUsage;
    }
    if (arguments.view == "tracking" && !arguments.size.empty()) {
        daemon::log(Severity::error, Error{.code = ErrorCode::invalidInput,
                                           .cause = "--size: the tracking view is always twice the sensor's picture",
                                           .mend = "leave --size out, or choose another --view"}
                                         .message());
        return kUsage;
    }
    arguments.options.view = kReplayViews.at(arguments.view);
    arguments.options.realTime = arguments.speed == "real";
    const Expected<daemon::ReplayReport> report = daemon::replayRecording(loaded.settings, arguments.options);
    if (!report) {
        daemon::log(Severity::error, report.error().message());
        return kFailed;
    }
    for (const std::string& warning : report->warnings)
        daemon::log(Severity::warning, warning);
    fmt::print("{} frames: a person in {}, dressed in {}, {} pictures written{}{}\n", report->frames, report->seen,
               report->dressed, report->pictures, report->renderer.empty() ? "" : ", drawn with ", report->renderer);
    fmt::print("{:<12}{:>10}{:>10}{:>10}{:>10}{:>10}{:>8}\n", "task", "budget", "mean", "p99", "max", "overruns",
               "runs");
    for (const daemon::TaskStatistics& row : report->tasks) {
        if (row.runs == 0) continue;
        fmt::print("{:<12}{:>7.2f} ms{:>7.2f} ms{:>7.2f} ms{:>7.2f} ms{:>10}{:>8}\n", row.name,
                   hal::seconds(row.budget) * 1e3, hal::seconds(row.mean) * 1e3, hal::seconds(row.p99) * 1e3,
                   hal::seconds(row.maximum) * 1e3, row.overruns, row.runs);
    }
    return kGood;
}

int hands(const std::string& folder, bool json) {
    const Expected<daemon::HandsReport> report = daemon::readHands(folder);
    if (!report) {
        daemon::log(Severity::error, report.error().message());
        return kFailed;
    }
    for (const std::string& warning : report->warnings)
        daemon::log(Severity::warning, warning);
    for (const daemon::HandReading& reading : report->readings) {
        const std::string_view state = fitting::nameOf(reading.state);
        if (json) {
            fmt::print("{}\n", nlohmann::json{{"picture", reading.name},
                                              {"state", state},
                                              {"confidence", reading.confidence},
                                              {"fingers", reading.fingers}}
                                   .dump());
        } else {
            fmt::print("{} {} {:.2f}\n", reading.name, state, reading.confidence);
        }
    }
    return kGood;
}

int record(const config::LoadOptions& where, daemon::RecordOptions& options) {
    const config::LoadedSettings loaded = config::loadSettings(where);
    printProblems(loaded);
    if (!loaded.good()) return kBadSettings;
    daemon::StopSignals signals;
    options.stop = [&signals] { return signals.requested(); };
    options.started = [&options](const hal::CameraInfo& info) {
        daemon::log(Severity::notice, fmt::format("recording {} into {}; Ctrl+C ends it", info.name, options.folder));
    };
    hal::SteadyClock clock;
    const Expected<daemon::RecordReport> report = daemon::recordSensor(loaded.settings, options, clock);
    if (!report) {
        daemon::log(Severity::error, report.error().message());
        return kFailed;
    }
    fmt::print("{} frames written with {}, {} dropped for want of time, {} lost by the sensor\n",
               report->frames.written, report->colour ? "colour" : "depth alone", report->frames.dropped,
               report->missed);
    if (!report->fault) return kGood;
    daemon::log(Severity::error, report->fault->message());
    return kFailed;
}

int run(int argc, char** argv) {
    CLI::App app{"Looks after a fitting mirror."};
    app.footer(kFooter);
    app.require_subcommand(1);
    app.set_version_flag("--version", "chevalctl " CHEVAL_VERSION);
    std::string folder;
    app.add_option("--config", folder, "Folder with cheval.toml and cheval.toml.d/*.toml (default: /etc/cheval)");

    auto* configCommand = app.add_subcommand("config", "The settings")->require_subcommand(1)->fallthrough();
    auto* show =
        configCommand
            ->add_subcommand("show", "Print every setting with its sentence, range, value and where it came from")
            ->fallthrough();
    bool defaults = false;
    show->add_flag("--defaults", defaults, "Print the defaults instead, as the shipped cheval.toml");
    auto* check = configCommand->add_subcommand("check", "Check the settings")->fallthrough();

    ReplayArguments arguments;
    auto* replayCommand =
        app.add_subcommand("replay", "Play a recording through the mirror's own pipeline")->fallthrough();
    replayCommand
        ->add_option("source", arguments.options.source,
                     "An .oni file, or a folder of 16-bit depth PNGs with a sensor.json")
        ->required();
    replayCommand->add_option("--tracks", arguments.options.tracks,
                              "Write joints, hands, measurements and events as JSON lines");
    replayCommand->add_option("--frames", arguments.options.frames,
                              "Write what the mirror shows, or the tracking view, as PNG files into this folder");
    replayCommand->add_option("--outfit", arguments.options.outfit, "Garments to wear, e.g. tshirt,trousers");
    replayCommand
        ->add_option("--view", arguments.view,
                     "What is drawn: mirror, avatar, or what tracking sees in the depth picture")
        ->check(CLI::IsMember({"mirror", "avatar", "tracking"}))
        ->capture_default_str();
    replayCommand->add_option("--speed", arguments.speed, "As fast as it goes (max) or at the recording's pace (real)")
        ->check(CLI::IsMember({"max", "real"}))
        ->capture_default_str();
    replayCommand->add_option("--every", arguments.options.every, "Draw every n-th frame only")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    replayCommand->add_option("--size", arguments.size,
                              "Size of the pictures, e.g. 540x960 (default: display.width x display.height)");
    std::string handsFolder;
    bool handsJson = false;
    auto* handsCommand =
        app.add_subcommand("hands", "Read pictures of one hand: open, closed or unknown")->fallthrough();
    handsCommand->add_option("folder", handsFolder, "A folder of 16-bit depth PNGs with a sensor.json")->required();
    handsCommand->add_flag("--json", handsJson, "One JSON object a picture, with the fingers that are stretched");
    daemon::RecordOptions recordOptions;
    auto* recordCommand =
        app.add_subcommand("record", "Record what the sensor sees, for replay (needs privacy.recording)")
            ->fallthrough();
    recordCommand->add_option("folder", recordOptions.folder, "Folder to record into: a new one, or an empty one")
        ->required();
    recordCommand->add_option("--seconds", recordOptions.seconds, "End after this long (default: at Ctrl+C)")
        ->check(CLI::Range(0.1, 86'400.0));
    recordCommand->add_option("--frames", recordOptions.frames, "End after so many frames")
        ->check(CLI::Range(1, 1'000'000));
    const daemon::ControlCommands control(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? kGood : kUsage;
    }
    if (const std::optional<int> status = control.run()) return *status;
    config::LoadOptions options;
    if (!folder.empty()) {
        options.folder = folder;
        options.folderRequired = true;
    }
    if (show->parsed()) return showConfig(options, defaults);
    if (check->parsed()) return checkConfig(options);
    if (recordCommand->parsed()) return record(options, recordOptions);
    if (handsCommand->parsed()) return hands(handsFolder, handsJson);
    return replay(options, arguments);
}

}  // namespace

int main(int argc, char** argv) {
    return cheval::daemon::guardedMain(run, argc, argv, kFailed);
}

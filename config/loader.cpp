#include "config/loader.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "config/nearest_name.h"
#include "config/settings_table.h"
#include "config/text_file.h"
#include "config/toml_reader.h"

namespace cheval::config {

namespace {

namespace fs = std::filesystem;

LoadedSettings startFromDefaults() {
    LoadedSettings loaded;
    loaded.settings = defaultSettings();
    loaded.origins.resize(settingsTable().size());
    return loaded;
}

void readFile(const fs::path& path, LoadedSettings& loaded) {
    Expected<std::string> text = readText(path.string(), kMaximumFileBytes, "settings files");
    if (!text) {
        addProblem(loaded, std::move(text).error());
        return;
    }
    loaded.files.push_back(path.string());
    readToml(*text, path.string(), loaded);
}

std::vector<fs::path> dropIns(const fs::path& folder, LoadedSettings& loaded) {
    std::vector<fs::path> files;
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
        const fs::path& path = entry->path();
        if (path.extension() != ".toml" || path.filename().string().starts_with('.')) continue;
        if (files.size() == kMaximumDropIns) {
            addProblem(loaded, Error{.code = ErrorCode::invalidInput,
                                     .cause = "there are too many drop-ins",
                                     .mend = "keep at most " + std::to_string(kMaximumDropIns),
                                     .file = folder.string()});
            break;
        }
        files.push_back(path);
    }
    std::sort(files.begin(), files.end());
    return files;
}

std::size_t rowOf(std::string_view path) {
    const std::span<const Setting> table = settingsTable();
    return static_cast<std::size_t>(
        std::find_if(table.begin(), table.end(), [path](const Setting& setting) { return setting.path == path; }) -
        table.begin());
}

void restore(LoadedSettings& loaded, std::string_view path) {
    const Setting& setting = settingsTable()[rowOf(path)];
    setting.set(loaded.settings, setting.fallback);
}

/// Rules between settings; the problem points at where `path` was set.
void refuse(LoadedSettings& loaded, std::string_view path, std::string cause, std::string mend, std::string why) {
    const SettingOrigin& origin = loaded.origins[rowOf(path)];
    addProblem(loaded, Error{.code = ErrorCode::invalidInput,
                             .cause = std::move(cause),
                             .mend = std::move(mend),
                             .why = std::move(why),
                             .file = origin.file,
                             .line = origin.line,
                             .key = std::string(path)});
}

/// What no file says follows what one does: without other garments there are no outfits of them, and a visit starts
/// with one that there is.
void followGarments(LoadedSettings& loaded) {
    auto& wardrobe = loaded.settings.wardrobe;
    const auto said = [&](std::string_view path) { return !loaded.origins[rowOf(path)].file.empty(); };
    if (said("wardrobe.garments") && !said("wardrobe.outfits")) {
        std::erase_if(wardrobe.outfits, [&](const std::string& outfit) {
            for (std::size_t begin = 0; begin <= outfit.size();) {
                const std::size_t end = std::min(outfit.find('+', begin), outfit.size());
                const std::string name = outfit.substr(begin, end - begin);
                if (std::find(wardrobe.garments.begin(), wardrobe.garments.end(), name) == wardrobe.garments.end()) {
                    return true;
                }
                begin = end + 1;
            }
            return false;
        });
        if (wardrobe.outfits.empty()) {
            const auto most = static_cast<std::size_t>(settingsTable()[rowOf("wardrobe.outfits")].high);
            wardrobe.outfits = wardrobe.garments;
            if (wardrobe.outfits.size() > most) wardrobe.outfits.resize(most);
        }
    }
    if (!said("wardrobe.start_outfit") && !wardrobe.outfits.empty() &&
        std::find(wardrobe.outfits.begin(), wardrobe.outfits.end(), wardrobe.startOutfit) == wardrobe.outfits.end()) {
        wardrobe.startOutfit = wardrobe.outfits.front();
    }
}

void checkOutfits(LoadedSettings& loaded) {
    followGarments(loaded);
    const auto& wardrobe = loaded.settings.wardrobe;
    const std::vector<std::string_view> garments(wardrobe.garments.begin(), wardrobe.garments.end());
    for (const std::string& garment : wardrobe.garments) {
        if (garment.find_first_of("/+") == std::string::npos && !garment.starts_with('.')) continue;
        refuse(loaded, "wardrobe.garments", "\"" + garment + "\" is not a garment's name",
               "give the file's name without folder and .glb",
               "names are joined by + to outfits, and garments come from wardrobe.folder alone");
        return;
    }
    for (const std::string& outfit : wardrobe.outfits) {
        for (std::size_t begin = 0; begin <= outfit.size();) {
            const std::size_t end = std::min(outfit.find('+', begin), outfit.size());
            const std::string name = outfit.substr(begin, end - begin);
            if (std::find(garments.begin(), garments.end(), name) == garments.end()) {
                std::string cause = "\"";
                cause.append(outfit).append("\" names \"").append(name).append("\", which is not in wardrobe.garments");
                refuse(loaded, "wardrobe.outfits", std::move(cause),
                       garments.empty() ? "add it to wardrobe.garments"
                                        : "did you mean \"" + std::string(nearestName(name, garments)) +
                                              "\"? Else add it to wardrobe.garments",
                       "an outfit is made of garments that are loaded");
            }
            begin = end + 1;
        }
    }
    const std::vector<std::string_view> outfits(wardrobe.outfits.begin(), wardrobe.outfits.end());
    if (!outfits.empty() && std::find(outfits.begin(), outfits.end(), wardrobe.startOutfit) == outfits.end()) {
        refuse(loaded, "wardrobe.start_outfit", "\"" + wardrobe.startOutfit + "\" is not in wardrobe.outfits",
               "did you mean \"" + std::string(nearestName(wardrobe.startOutfit, outfits)) + "\"?",
               "a visit starts with one of the outfits");
    }
}

/// Of two settings that do not go together, the one that a file sets, so that the problem can point at a line.
std::string_view whoeverWasSet(const LoadedSettings& loaded, std::string_view path, std::string_view other) {
    const auto said = [&](std::string_view any) { return !loaded.origins[rowOf(any)].file.empty(); };
    return said(path) || !said(other) ? path : other;
}

void checkGestures(LoadedSettings& loaded) {
    const auto& gestures = loaded.settings.gestures;
    const bool endsFirst = gestures.swipeEndSpeed > gestures.swipeStartSpeed;
    const bool startsAbovePeak = gestures.swipeStartSpeed > gestures.swipePeakSpeed;
    if (endsFirst) {
        refuse(loaded, whoeverWasSet(loaded, "gestures.swipe_end_speed", "gestures.swipe_start_speed"),
               "a swipe would be over before it begins",
               "make gestures.swipe_end_speed at most gestures.swipe_start_speed",
               "a hand just fast enough to start a swipe would be slow enough to end it, and none would count");
    }
    if (startsAbovePeak) {
        refuse(loaded, whoeverWasSet(loaded, "gestures.swipe_peak_speed", "gestures.swipe_start_speed"),
               "a swipe would start faster than it need be at its fastest",
               "make gestures.swipe_peak_speed at least gestures.swipe_start_speed",
               "whatever starts would be fast enough, and swipe_peak_speed would do nothing");
    }
    if (endsFirst || startsAbovePeak) {
        restore(loaded, "gestures.swipe_end_speed");
        restore(loaded, "gestures.swipe_start_speed");
        restore(loaded, "gestures.swipe_peak_speed");
    }
    if (gestures.grabClosedLeastSeconds >= gestures.grabClosedLongestSeconds) {
        refuse(loaded, whoeverWasSet(loaded, "gestures.grab_closed_least_s", "gestures.grab_closed_longest_s"),
               "a grab would have to last longer than it may",
               "make gestures.grab_closed_least_s less than gestures.grab_closed_longest_s", "no grab would count");
        restore(loaded, "gestures.grab_closed_least_s");
        restore(loaded, "gestures.grab_closed_longest_s");
    }
    if (gestures.holdMovement >= gestures.holdAway) {
        refuse(loaded, whoeverWasSet(loaded, "gestures.hold_movement", "gestures.hold_away"),
               "a hand could be away and still at once", "make gestures.hold_movement less than gestures.hold_away",
               "a hand that trembles would confirm again and again");
        restore(loaded, "gestures.hold_movement");
        restore(loaded, "gestures.hold_away");
    }
}

/// Each rule that is broken also puts its settings back to their defaults, so that what is left goes together.
void checkTogether(LoadedSettings& loaded) {
    const Settings& settings = loaded.settings;
    if (settings.sensor.source == SensorSource::replay && settings.sensor.folder.empty()) {
        refuse(loaded, "sensor.source", "there is no recording to play", "set sensor.folder",
               "source \"replay\" plays the folder that sensor.folder names");
    }
    if (settings.display.kind == DisplayKind::preview && !settings.preview.enabled) {
        refuse(
            loaded, "display.kind", "the preview is not enabled", "set preview.enabled = true, or another display.kind",
            "the preview shows what the camera sees to whoever uses this machine, so it is off unless it is asked for");
        restore(loaded, "display.kind");
    }
    const auto& buttons = settings.buttons;
    if (buttons.source == ButtonSource::gpio && buttons.next.empty() && buttons.previous.empty() &&
        buttons.view.empty() && buttons.service.empty() && buttons.wake.empty()) {
        refuse(loaded, "buttons.source", "no button is wired",
               "name at least one line, such as next = \"GPIO17\", or set source = \"none\"",
               "without a line there is nothing to press");
        restore(loaded, "buttons.source");
    }
    if (settings.zone.nearMetres >= settings.zone.farMetres) {
        refuse(loaded, "zone.near_m", "the zone ends before it begins", "make zone.near_m less than zone.far_m",
               "nobody could stand in it");
        restore(loaded, "zone.near_m");
        restore(loaded, "zone.far_m");
    }
    checkGestures(loaded);
    const std::size_t before = loaded.problems.size();
    checkOutfits(loaded);
    if (loaded.problems.size() != before) {
        restore(loaded, "wardrobe.garments");
        restore(loaded, "wardrobe.outfits");
        restore(loaded, "wardrobe.start_outfit");
    }
}

/// Checks what was read as a whole. Where values were refused already, what follows from that is put right without a
/// word.
void settle(LoadedSettings& loaded) {
    if (loaded.good()) {
        checkTogether(loaded);
        return;
    }
    LoadedSettings quiet = loaded;
    quiet.problems.clear();
    checkTogether(quiet);
    loaded.settings = std::move(quiet.settings);
}

std::string indented(std::string_view sentence) {
    return "# " + std::string(sentence) + "\n";
}

}  // namespace

LoadedSettings loadSettings(const LoadOptions& options) {
    LoadedSettings loaded = startFromDefaults();
    std::error_code failed;
    if (!options.shippedFile.empty() && fs::exists(options.shippedFile, failed)) readFile(options.shippedFile, loaded);
    const fs::path folder(options.folder);
    if (!options.folder.empty()) {
        const std::size_t before = loaded.files.size() + loaded.problems.size();
        if (fs::exists(folder / "cheval.toml", failed)) readFile(folder / "cheval.toml", loaded);
        for (const fs::path& file : dropIns(folder / "cheval.toml.d", loaded))
            readFile(file, loaded);
        if (options.folderRequired && loaded.files.size() + loaded.problems.size() == before) {
            addProblem(loaded, Error{.code = ErrorCode::notFound,
                                     .cause = "there are no settings in this folder",
                                     .mend = "put a cheval.toml in it, or name another folder with --config",
                                     .why = "settings are read from cheval.toml and cheval.toml.d/*.toml",
                                     .file = options.folder});
        }
    }
    settle(loaded);
    return loaded;
}

LoadedSettings loadSettingsText(std::string_view text, const std::string& name) {
    LoadedSettings loaded = startFromDefaults();
    if (text.size() > kMaximumFileBytes) {
        addProblem(loaded, Error{.code = ErrorCode::invalidInput, .cause = "the text is too long", .file = name});
        return loaded;
    }
    loaded.files.push_back(name);
    readToml(text, name, loaded);
    settle(loaded);
    return loaded;
}

std::string describeSettings(const Settings& settings, const std::vector<SettingOrigin>& origins) {
    std::string text;
    const std::span<const Setting> table = settingsTable();
    for (const Section& section : settingsSections()) {
        if (!text.empty()) text += '\n';
        text += indented(section.sentence) + "[" + std::string(section.name) + "]\n";
        for (std::size_t i = 0; i < table.size(); ++i) {
            const Setting& setting = table[i];
            if (setting.section != section.name) continue;
            text += indented(setting.sentence);
            std::string limits;
            if (setting.kind == SettingKind::integer) {
                limits = std::to_string(static_cast<std::int64_t>(setting.low)) + " to " +
                         std::to_string(static_cast<std::int64_t>(setting.high));
            } else if (setting.kind == SettingKind::real) {
                limits = toToml(setting.low) + " to " + toToml(setting.high);
            } else if (setting.kind == SettingKind::choice) {
                for (const std::string_view name : choiceNames(setting))
                    limits += (limits.empty() ? "\"" : ", \"") + std::string(name) + "\"";
            }
            if (!setting.unit.empty()) limits += " " + std::string(setting.unit);
            if (!limits.empty()) text += indented(limits);
            text += std::string(setting.key) + " = " + toToml(setting.get(settings));
            if (i < origins.size() && !origins[i].file.empty())
                text += "  # " + origins[i].file + ":" + std::to_string(origins[i].line);
            text += '\n';
        }
    }
    return text;
}

}  // namespace cheval::config

#include "hal/replay/sensor_json.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>

#include <nlohmann/json.hpp>

#include "hal/intrinsics_check.h"

namespace cheval::hal {

namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxBytes = std::size_t{1} << 16;

// Reads keys one by one and ends with an error where a key is missing, wrong or left over. The first error wins.
class KeyReader {
  public:
    KeyReader(const Json& object, std::string prefix, const std::string& file)
        : object_(object), prefix_(std::move(prefix)), file_(file) {}

    // Reads a number into `value`, which must lie in [low, high].
    template <typename Number>
    void number(const char* key, Number& value, double low, double high, bool required) {
        const Json* found = find(key, required);
        if (found == nullptr) return;
        if (!found->is_number()) return fail(key, "this is not a number", "write a number");
        const double real = found->get<double>();
        if (!(real >= low && real <= high)) {
            return fail(key, "it is " + found->dump(), "write a number from " + text(low) + " to " + text(high));
        }
        if constexpr (std::is_integral_v<Number>) {
            if (real != std::floor(real)) return fail(key, "it is " + found->dump(), "write a whole number");
        }
        value = static_cast<Number>(real);
    }

    void boolean(const char* key, bool& value) {
        const Json* found = find(key, false);
        if (found == nullptr) return;
        if (!found->is_boolean()) return fail(key, "this is neither true nor false", "write true or false");
        value = found->get<bool>();
    }

    const Json* object(const char* key) {
        const Json* found = find(key, false);
        if (found != nullptr && !found->is_object()) {
            fail(key, "this is not an object", "write {…}");
            return nullptr;
        }
        return found;
    }

    // Everything that nobody asked for is an error.
    Expected<void> finish() {
        if (error_.cause.empty()) {
            for (const auto& [key, value] : object_.items()) {
                if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
                std::string all;
                for (const std::string& name : known_)
                    all += (all.empty() ? "" : ", ") + name;
                fail(key.substr(0, 64), "this key is unknown", "correct or remove it", "the keys are " + all);
                break;
            }
        }
        if (!error_.cause.empty()) return std::move(error_);
        return {};
    }

  private:
    static std::string text(double value) { return Json(value).dump(); }

    const Json* find(const char* key, bool required) {
        known_.emplace_back(key);
        const auto found = object_.find(key);
        if (found != object_.end()) return &*found;
        if (required) fail(key, "this key is missing", "add it", "a depth picture means nothing without its camera");
        return nullptr;
    }

    void fail(const std::string& key, std::string cause, std::string mend, std::string why = {}) {
        if (!error_.cause.empty()) return;
        error_ = {.code = ErrorCode::invalidInput,
                  .cause = std::move(cause),
                  .mend = std::move(mend),
                  .why = std::move(why),
                  .file = file_,
                  .key = prefix_ + key};
    }

    const Json& object_;
    std::string prefix_;
    const std::string& file_;
    std::vector<std::string> known_;
    Error error_;
};

Expected<Json> parseObject(std::string_view text, const std::string& file) {
    if (text.size() > kMaxBytes) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the file has " + std::to_string(text.size()) + " bytes",
                     .mend = "keep only the sensor's keys",
                     .why = "at most " + std::to_string(kMaxBytes) + " are read",
                     .file = file};
    }
    try {
        Json json = Json::parse(text);
        if (json.is_object()) return json;
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "this is not a JSON object",
                     .mend = "write {\"width\": …, …}",
                     .file = file};
    } catch (const Json::exception& exception) {
        // The library's message cites the input, which need not be text.
        const auto* syntax = dynamic_cast<const Json::parse_error*>(&exception);
        const std::size_t byte = syntax == nullptr ? 0 : std::min(syntax->byte, text.size());
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n');
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the file is not valid JSON",
                     .mend = "correct it at byte " + std::to_string(byte),
                     .why = "the sensor's intrinsics come from it",
                     .file = file,
                     .line = static_cast<int>(line)};
    }
}

// A float with the fewest digits that give it back, so that 570.3 does not become 570.2999877929688.
double shortest(float value) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    double nearest = 0.0;
    std::from_chars(digits.data(), end, nearest);
    return nearest;
}

}  // namespace

Expected<SensorDescription> parseSensorJson(std::string_view text, const std::string& file) {
    Expected<Json> json = parseObject(text, file);
    if (!json) return std::move(json).error();
    SensorDescription description;
    Intrinsics& camera = description.intrinsics;
    KeyReader keys(*json, "", file);
    keys.number("width", camera.width, 16, 4096, true);
    keys.number("height", camera.height, 16, 4096, true);
    keys.number("fx", camera.fx, 1, 100000, true);
    keys.number("fy", camera.fy, 1, 100000, true);
    keys.number("cx", camera.cx, -4096, 8192, true);
    keys.number("cy", camera.cy, -4096, 8192, true);
    keys.number("depth_unit_mm", description.depthUnitMm, 0.001, 100, false);
    keys.number("fps", description.framesPerSecond, 0.1, 240, false);
    keys.boolean("independent", description.independent);
    const Json* mount = keys.object("mount");
    if (auto done = keys.finish(); !done) return std::move(done).error();
    if (auto plausible = checkIntrinsics(camera); !plausible) {
        Error error = std::move(plausible).error();
        error.file = file;
        return error;
    }
    if (mount == nullptr) return description;

    KeyReader mountKeys(*mount, "mount.", file);
    mountKeys.number("height_mm", description.mount.heightMm, 0, 5000, false);
    mountKeys.number("tilt_deg", description.mount.tiltDeg, -90, 90, false);
    mountKeys.number("roll_deg", description.mount.rollDeg, -180, 180, false);
    if (auto done = mountKeys.finish(); !done) return std::move(done).error();
    description.mount.known = true;
    return description;
}

std::string formatSensorJson(const SensorDescription& description) {
    const Intrinsics& camera = description.intrinsics;
    nlohmann::ordered_json json{{"width", camera.width},
                                {"height", camera.height},
                                {"fx", shortest(camera.fx)},
                                {"fy", shortest(camera.fy)},
                                {"cx", shortest(camera.cx)},
                                {"cy", shortest(camera.cy)},
                                {"depth_unit_mm", description.depthUnitMm},
                                {"fps", description.framesPerSecond}};
    if (description.mount.known) {
        json["mount"] = {{"height_mm", shortest(description.mount.heightMm)},
                         {"tilt_deg", shortest(description.mount.tiltDeg)},
                         {"roll_deg", shortest(description.mount.rollDeg)}};
    }
    if (description.independent) json["independent"] = true;
    return json.dump(1) + "\n";
}

}  // namespace cheval::hal

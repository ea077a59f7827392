// Fuzzes what a recording brings in besides its pictures: sensor.json and the names of its files.
#include <string>

#include "hal/replay/recording.h"
#include "hal/replay/sensor_json.h"
#include "tests/support/fuzz.h"

using namespace cheval;

namespace {

void fuzzSensorJson(std::string_view text) {
    const auto sensor = hal::parseSensorJson(text, "sensor.json");
    if (!sensor) {
        if (sensor.error().cause.empty() || sensor.error().mend.empty()) __builtin_trap();
        return;
    }
    // What was accepted survives being written and read again.
    const std::string written = hal::formatSensorJson(*sensor);
    const auto back = hal::parseSensorJson(written, "sensor.json");
    if (!back || hal::formatSensorJson(*back) != written) __builtin_trap();
}

void fuzzNames(std::string_view text) {
    std::vector<std::string> names(1);
    for (const char c : text) {
        if (c == '\n') {
            names.emplace_back();
        } else {
            names.back() += c;
        }
    }
    for (const bool stills : {false, true}) {
        const hal::Recording recording = hal::arrangeRecording(names, stills);
        for (std::size_t i = 1; i < recording.pictures.size(); ++i) {
            if (recording.pictures[i].tick <= recording.pictures[i - 1].tick) __builtin_trap();
        }
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    fuzzSensorJson(text);
    fuzzNames(text);
    return 0;
}

namespace cheval::test {

std::vector<FuzzInput> fuzzSeeds() {
    std::vector<FuzzInput> seeds;
    for (
        const std::string_view text :
        {R"({"width": 640, "height": 480, "fx": 570.3, "fy": 570.3, "cx": 319.5, "cy": 239.5, "depth_unit_mm": 1, "fps": 15,
              "mount": {"height_mm": 1250, "tilt_deg": -4, "roll_deg": 0.3}, "independent": false})",
         R"({"width": 640, "height": 480, "fx": 476.007, "fy": 476.007, "cx": 313.683, "cy": 242.755, "depth_unit_mm": 0.125, "fps": 1, "independent": true})",
         "depth-0000.png\ndepth-0001.png\ndepth-0003.png\ncolor-0001.png\nmask-0000.png\nsensor.json",
         "depth-18446744073709551615.png\ndepth-0.png\n20210326-230536-030.png\n20210326-230536-070.png"}) {
        seeds.emplace_back(text.begin(), text.end());
    }
    return seeds;
}

}  // namespace cheval::test

// A recording made by the test itself, in a folder that goes when the test does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "hal/image.h"
#include "hal/png/png.h"
#include "tests/support/temporary_folder.h"

namespace cheval::test {

/// A folder of its own under the tests' temporary folder. Thread-bound.
class RecordingFolder {
  public:
    static constexpr int kWidth = 32;
    static constexpr int kHeight = 24;
    static constexpr const char* kSensorJson =
        R"({"width": 32, "height": 24, "fx": 28.5, "fy": 28.5, "cx": 15.5, "cy": 11.5, "depth_unit_mm": 1, "fps": 15})";

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] std::string path(const std::string& name) const { return path_ + "/" + name; }

    bool text(const std::string& name, const std::string& content) const {
        return hal::writeBytes(path(name), std::as_bytes(std::span(content))).hasValue();
    }
    /// A ramp that starts with `first`, so that every picture can be told from the others by its first pixel.
    bool depth(const std::string& name, std::uint16_t first, int width = kWidth, int height = kHeight) const {
        hal::Image<std::uint16_t> picture(width, height);
        for (std::size_t i = 0; i < picture.pixels.size(); ++i)
            picture.pixels[i] = static_cast<std::uint16_t>(first + i);
        return hal::writePng(path(name), picture.view()).hasValue();
    }
    bool colour(const std::string& name, hal::Rgb8 fill, int width = kWidth, int height = kHeight) const {
        return hal::writePng(path(name), hal::Image<hal::Rgb8>(width, height, fill).view()).hasValue();
    }
    /// sensor.json and `count` pictures depth-0.png …; picture i begins with 1000 · (i + 1).
    bool recording(int count, const std::string& sensorJson = kSensorJson, int width = kWidth,
                   int height = kHeight) const {
        bool good = text("sensor.json", sensorJson);
        for (int i = 0; i < count; ++i) {
            good = depth("depth-" + std::to_string(i) + ".png", static_cast<std::uint16_t>(1000 * (i + 1)), width,
                         height) &&
                   good;
        }
        return good;
    }

  private:
    TemporaryFolder temporary_;
    std::string path_ = temporary_.path().string();
};

}  // namespace cheval::test

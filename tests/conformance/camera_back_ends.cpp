#include "tests/conformance/camera_back_ends.h"

#include <filesystem>

#include "hal/replay/replay_camera.h"
#include "hal/sim/world.h"
#include "tests/hal/replay/recording_folder.h"

namespace cheval::test {

namespace {

class ReplayRig final : public CameraRig {
  public:
    explicit ReplayRig(std::string more) : more_(std::move(more)) { write("15"); }

    std::unique_ptr<hal::DepthCamera> make(hal::Clock& clock) override { return open(clock); }
    std::unique_ptr<hal::DepthCamera> makeSlow(hal::Clock& clock) override {
        write("0.1");
        return open(clock);
    }
    void lose() override {
        for (int i = 0; i < kPictures; ++i)
            std::filesystem::remove(folder_.path("depth-" + std::to_string(i) + ".png"));
    }
    void bringBack() override { write("15"); }

  private:
    static constexpr int kPictures = 60;

    void write(const std::string& rate) {
        good_ = folder_.recording(
            kPictures,
            R"({"width": 32, "height": 24, "fx": 28, "fy": 28, "cx": 15.5, "cy": 11.5, "fps": )" + rate + more_ + "}");
    }
    std::unique_ptr<hal::DepthCamera> open(hal::Clock& clock) {
        auto made = hal::makeReplayCamera({.folder = folder_.path(), .stillRepeats = 3}, clock);
        if (!good_ || !made) return nullptr;
        return std::move(*made);
    }

    RecordingFolder folder_;
    std::string more_;
    bool good_ = false;
};

class SimulatedRig final : public CameraRig {
  public:
    std::unique_ptr<hal::DepthCamera> make(hal::Clock& clock) override { return make(clock, 30.0); }
    std::unique_ptr<hal::DepthCamera> makeSlow(hal::Clock& clock) override { return make(clock, 0.1); }
    void lose() override { world_->setFault(hal::sim::CameraFault::lost); }
    void bringBack() override { world_->setFault(hal::sim::CameraFault::none); }

  private:
    std::unique_ptr<hal::DepthCamera> make(hal::Clock& clock, double rate) {
        world_ = hal::sim::makeWorld({.framesPerSecond = rate});
        return hal::sim::makeSimulatedCamera(world_, clock);
    }

    std::shared_ptr<hal::sim::World> world_;
};

}  // namespace

std::vector<CameraBackEnd> cameraBackEnds() {
    return {{.name = "replay",
             .rig = [] { return std::make_unique<ReplayRig>(""); },
             .ends = true,
             .canBeLost = true,
             .canBeSlow = true},
            {.name = "replayOfStills",
             .rig = [] { return std::make_unique<ReplayRig>(R"(, "independent": true)"); },
             .ends = true,
             .canBeLost = true},
            {.name = "simulated",
             .rig = [] { return std::make_unique<SimulatedRig>(); },
             .canBeLost = true,
             .canBeSlow = true}};
}

}  // namespace cheval::test

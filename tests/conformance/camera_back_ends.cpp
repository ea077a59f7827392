#include "tests/conformance/camera_back_ends.h"

#include <filesystem>

#include "hal/replay/replay_camera.h"
#include "hal/sensor_process/process_camera.h"
#include "hal/sim/world.h"
#include "tests/hal/replay/recording_folder.h"
#include "tests/support/sensor_world.h"

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

// The real OpenNI2 in a process of its own, with our driver in place of a sensor maker's.
class OpenNiRig : public CameraRig {
  public:
    std::unique_ptr<hal::DepthCamera> make(hal::Clock& clock) override {
        world_ = std::make_unique<SensorWorld>(spec());
        return hal::makeProcessCamera(
            {.program = CHEVAL_SENSOR, .environment = world_->environment(), .openWait = std::chrono::seconds(60)},
            clock);
    }
    // No sensor offers a frame in ten seconds; one that stalls is as slow.
    std::unique_ptr<hal::DepthCamera> makeSlow(hal::Clock& clock) override {
        auto camera = make(clock);
        world_->tell("stall");
        return camera;
    }
    void lose() override { world_->tell("unplug"); }
    void bringBack() override { world_->tell("plug"); }

  protected:
    virtual std::string spec() = 0;

  private:
    std::unique_ptr<SensorWorld> world_;
};

class OpenNiWorldRig final : public OpenNiRig {
  protected:
    std::string spec() override { return "sim:seed=1,noise=0"; }
};

class OpenNiFolderRig final : public OpenNiRig {
  protected:
    std::string spec() override {
        folder_.recording(20,
                          R"({"width": 640, "height": 480, "fx": 570, "fy": 570, "cx": 319.5, "cy": 239.5, "fps": 30})",
                          640, 480);
        return "folder:" + folder_.path();
    }

  private:
    RecordingFolder folder_;
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
             .canBeSlow = true},
            {.name = "openniOfTheSimulation",
             .rig = [] { return std::make_unique<OpenNiWorldRig>(); },
             .canBeLost = true,
             .canBeSlow = true,
             .live = true},
            {.name = "openniOfAFolder",
             .rig = [] { return std::make_unique<OpenNiFolderRig>(); },
             .canBeLost = true,
             .canBeSlow = true,
             .live = true}};
}

}  // namespace cheval::test

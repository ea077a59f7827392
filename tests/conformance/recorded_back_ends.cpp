#include "hal/replay/replay_camera.h"
#include "tests/conformance/camera_back_ends.h"

namespace cheval::test {

namespace {

class RecordedRig final : public CameraRig {
  public:
    explicit RecordedRig(const char* folder) : folder_(std::string(CHEVAL_DATA) + "/" + folder) {}

    std::unique_ptr<hal::DepthCamera> make(hal::Clock& clock) override {
        auto made = hal::makeReplayCamera({.folder = folder_, .stillRepeats = 4}, clock);
        if (!made) return nullptr;
        return std::move(*made);
    }

  private:
    std::string folder_;
};

}  // namespace

std::vector<CameraBackEnd> cameraBackEnds() {
    return {{.name = "replayOfAShopper",
             .rig = [] { return std::make_unique<RecordedRig>("shoppers/seq01"); },
             .ends = true},
            {.name = "replayOfARealSensor",
             .rig = [] { return std::make_unique<RecordedRig>("real-upper-body"); },
             .ends = true}};
}

}  // namespace cheval::test

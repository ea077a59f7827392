// The depth cameras that the conformance suite runs over. Each test program has its own list.
#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "hal/clock.h"
#include "hal/depth_camera.h"

namespace cheval::test {

/// One world with one device in it, new for each test.
class CameraRig {
  public:
    virtual ~CameraRig() = default;
    CameraRig(const CameraRig&) = delete;
    CameraRig& operator=(const CameraRig&) = delete;

    /// The camera; null fails the test.
    virtual std::unique_ptr<hal::DepthCamera> make(hal::Clock& clock) = 0;
    /// Where canBeSlow: a camera that may send one frame at once, and then none for ten seconds.
    virtual std::unique_ptr<hal::DepthCamera> makeSlow(hal::Clock& /*clock*/) { return nullptr; }
    /// Where canBeLost: takes the device away, and brings it back.
    virtual void lose() {}
    virtual void bringBack() {}

  protected:
    CameraRig() = default;
};

struct CameraBackEnd {
    std::string name;
    std::function<std::unique_ptr<CameraRig>()> rig;
    bool ends = false;  ///< A recording, which is the same from its start whenever it is opened.
    bool canBeLost = false;
    bool canBeSlow = false;
    bool live = false;  ///< Runs in real time, and skips what nobody waited for.
};

/// gtest's name for a parameter.
inline void PrintTo(const CameraBackEnd& backEnd, std::ostream* out) {  // NOLINT(readability-identifier-naming)
    *out << backEnd.name;
}

std::vector<CameraBackEnd> cameraBackEnds();

}  // namespace cheval::test

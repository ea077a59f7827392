// A camera that does what a script says, on a virtual clock.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <utility>

#include "hal/depth_camera.h"

namespace cheval::daemon::test {

/// What the camera does next; the last step of a script repeats.
enum class Does { frame, timeOut, lose, end, refuseToOpen };

struct CameraScript {
    std::deque<Does> steps;
    int opened = 0;
    int closed = 0;
    std::uint64_t sequence = 0;
    int width = 640;  ///< Of the depth picture.
    int height = 480;
    hal::Duration period = std::chrono::microseconds(33'333);
    int colourWidth = 640;  ///< Another than the depth's is a fault of the camera.

    Does next() {
        const Does does = steps.front();
        if (steps.size() > 1) steps.pop_front();
        return does;
    }
};

/// Frames without a reading, 30 a second unless the script says otherwise.
class FakeCamera final : public hal::DepthCamera {
  public:
    FakeCamera(CameraScript& script, hal::Clock& clock)
        : script_(script),
          clock_(clock),
          depth_(script.width, script.height),
          colour_(script.colourWidth, script.height) {}
    ~FakeCamera() override { close(); }
    FakeCamera(const FakeCamera&) = delete;
    FakeCamera& operator=(const FakeCamera&) = delete;

  protected:
    Expected<hal::CameraInfo> doOpen() override {
        if (script_.steps.front() == Does::refuseToOpen) {
            script_.next();
            return Error{.code = ErrorCode::unavailable, .cause = "busy", .mend = "wait"};
        }
        ++script_.opened;
        const hal::Intrinsics usual;
        const float larger = static_cast<float>(script_.width) / static_cast<float>(usual.width);
        return hal::CameraInfo{.name = "fake",
                               .intrinsics = {.width = script_.width,
                                              .height = script_.height,
                                              .fx = larger * usual.fx,
                                              .fy = larger * usual.fy,
                                              .cx = 0.5F * static_cast<float>(script_.width - 1),
                                              .cy = 0.5F * static_cast<float>(script_.height - 1)}};
    }
    void doClose() override { ++script_.closed; }
    hal::FrameStatus doWaitFrame(hal::Duration timeout, hal::DepthFrame& frame, hal::Interrupt& interrupt) override {
        if (interrupt.raised()) return hal::FrameStatus::closed;
        switch (script_.next()) {
            case Does::frame:
                clock_.waitUntil(clock_.now() + script_.period, interrupt);
                frame = {.sequence = ++script_.sequence,
                         .sourceIndex = script_.sequence,
                         .captureTime = clock_.now(),
                         .lastOfStill = true,
                         .depth = std::as_const(depth_).view(),
                         .colour = std::as_const(colour_).view()};
                return hal::FrameStatus::frame;
            case Does::timeOut:
            case Does::refuseToOpen:
                clock_.waitUntil(clock_.now() + timeout, interrupt);
                return hal::FrameStatus::timedOut;
            case Does::lose:
                return hal::FrameStatus::lost;
            case Does::end:
                return hal::FrameStatus::ended;
        }
        return hal::FrameStatus::lost;
    }

  private:
    CameraScript& script_;
    hal::Clock& clock_;
    hal::Image<std::uint16_t> depth_;
    hal::Image<hal::Rgb8> colour_;
};

}  // namespace cheval::daemon::test

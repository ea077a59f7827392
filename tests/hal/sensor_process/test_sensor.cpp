// A sensor process without a sensor's library: it serves the simulated camera, well or badly, as its argument says.
#include <csignal>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include <sys/eventfd.h>
#include <unistd.h>

#include "hal/sensor_process/message.h"
#include "hal/sensor_process/ring_layout.h"
#include "hal/sensor_process/sensor_server.h"
#include "hal/sim/world.h"

namespace {

using namespace cheval;

/// Passes everything on to the simulated camera, but for what it does badly.
class BadCamera final : public hal::DepthCamera {
  public:
    explicit BadCamera(std::string_view deed) : deed_(deed) {}

  protected:
    Expected<hal::CameraInfo> doOpen() override {
        if (deed_ == "hang-open") forEver();
        if (deed_ == "refuse")
            return Error{.code = ErrorCode::unavailable, .cause = "another process holds it", .mend = "stop it"};
        if (deed_ == "exit") std::_Exit(3);
        auto opened = inner_->open();
        if (!opened) return std::move(opened).error();
        hal::CameraInfo info = inner_->info();
        if (deed_ == "impossible-size") {
            info.intrinsics.width = 1 << 20;
            info.intrinsics.fx = 1 << 20;
        }
        if (deed_ == "impossible-lens") info.intrinsics.fx = 10.0F;
        if (deed_ == "other-size") {
            info.intrinsics.width = 480;
            info.intrinsics.cx = 239.5F;
        }
        return info;
    }
    void doClose() override { inner_->close(); }
    Expected<void> doRestartStream() override {
        deed_ = "";
        return {};
    }
    hal::FrameStatus doWaitFrame(hal::Duration timeout, hal::DepthFrame& frame, hal::Interrupt&) override {
        if (deed_ == "hang-read" && frames_ == 3) forEver();
        if (deed_ == "crash" && frames_ == 3) std::abort();
        if (deed_ == "silent-after-three" && frames_ >= 3) {
            hal::Interrupt none;
            clock_.waitUntil(clock_.now() + timeout, none);
            return hal::FrameStatus::timedOut;
        }
        if (deed_ == "lose" && frames_ == 3) return hal::FrameStatus::lost;
        ++frames_;
        return inner_->waitFrame(timeout, frame);
    }

  private:
    [[noreturn]] static void forEver() {
        while (true)
            ::pause();
    }

    std::string deed_;
    hal::SteadyClock clock_;
    std::unique_ptr<hal::DepthCamera> inner_ =
        hal::sim::makeSimulatedCamera(hal::sim::makeWorld({.sensorNoise = false}), clock_);
    int frames_ = 0;
};

/// Says that it is open, and then publishes what cannot be.
int lie() {
    auto ring = hal::RingMemory::attach(hal::Descriptor(hal::kRingDescriptor));
    if (!ring) return EXIT_FAILURE;
    hal::Message message;
    while (true) {
        if (hal::receiveMessage(hal::kControlDescriptor, message) != hal::Received::message) continue;
        if (message.kind == hal::MessageKind::open) break;
    }
    hal::Message opened{.kind = hal::MessageKind::opened, .opening = message.opening, .framesPerSecond = 30.0};
    hal::sendMessage(hal::kControlDescriptor, opened);
    hal::ring_layout::Slot& slot = hal::ring_layout::slot(ring->data(), 1);
    slot.serial = 1;
    slot.frame = {.width = 0xffffffffU, .height = 0xffffffffU, .opening = message.opening};
    hal::ring_layout::header(ring->data()).newest.store(1U << hal::ring_layout::kSlotBits | 1U);
    ::eventfd_write(hal::kFramesDescriptor, 1);
    while (hal::receiveMessage(hal::kControlDescriptor, message) != hal::Received::gone)
        continue;
    return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string deed = argc > 1 ? argv[1] : "";
    if (deed == "lie") return lie();
    if (deed == "chatter") {
        // No message of this release.
        return ::write(hal::kControlDescriptor, "hello", 5) == 5 ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    hal::endWithTheOtherSide();
    BadCamera camera(deed);
    const auto served = hal::serveSensor(camera, {});
    return served ? EXIT_SUCCESS : EXIT_FAILURE;
}

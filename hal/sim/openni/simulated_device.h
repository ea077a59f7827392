// The simulated sensor as OpenNI2 sees it: a device with a depth stream and a colour stream that one thread feeds.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "hal/sim/openni/driver_api.h"
#include "hal/sim/openni/faults.h"
#include "hal/sim/openni/sensor_spec.h"

namespace cheval::hal::sim {

class SimulatedDevice;

/// One stream. Thread-safe towards the device's thread.
class SimulatedStream final : public oni::driver::StreamBase {
  public:
    SimulatedStream(SimulatedDevice& device, OniSensorType sensor);

    OniStatus start() override;
    void stop() override;
    OniStatus getProperty(int property, void* data, int* size) override;
    OniStatus setProperty(int property, const void* data, int size) override;
    OniBool isPropertySupported(int property) override;

    /// From the device's thread: hands a frame on if the stream runs.
    void deliver(const DepthFrame& frame, int shrink, bool lie);
    [[nodiscard]] bool running() const { return running_; }

  private:
    SimulatedDevice& device_;
    OniSensorType sensor_;
    std::mutex mutex_;  ///< Held while a frame is handed on, so that none comes after stop().
    std::atomic<bool> running_{false};
    std::atomic<bool> mirrored_{false};
};

class SimulatedDevice final : public oni::driver::DeviceBase {
  public:
    /// `camera` is closed. Both are borrowed for as long as the device lives.
    SimulatedDevice(std::unique_ptr<DepthCamera> camera, const CameraInfo& info, Faults& faults);
    ~SimulatedDevice() override;
    SimulatedDevice(const SimulatedDevice&) = delete;
    SimulatedDevice& operator=(const SimulatedDevice&) = delete;

    OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override;
    oni::driver::StreamBase* createStream(OniSensorType sensor) override;
    void destroyStream(oni::driver::StreamBase* stream) override;
    OniStatus getProperty(int property, void* data, int* size) override;
    OniStatus setProperty(int property, const void* data, int size) override;
    OniBool isPropertySupported(int property) override;
    OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override;

    /// Of a stream: the one mode that is offered now.
    [[nodiscard]] OniVideoMode mode(OniSensorType sensor) const;
    [[nodiscard]] const CameraInfo& info() const { return info_; }
    /// A stream was started: sees to it that the thread runs.
    void feed();

  private:
    void run();
    void spoil(DepthFrame& frame);

    std::unique_ptr<DepthCamera> camera_;
    CameraInfo info_;
    Faults& faults_;
    std::array<OniVideoMode, 2> modes_{};
    std::array<OniSensorInfo, 2> sensors_{};
    std::mutex streamsMutex_;
    std::vector<std::unique_ptr<SimulatedStream>> streams_;
    std::atomic<int> registration_{ONI_IMAGE_REGISTRATION_OFF};
    std::atomic<bool> stopping_{false};
    std::mutex threadMutex_;
    std::thread thread_;
    SteadyClock clock_;
    Image<std::uint16_t> noise_;
};

}  // namespace cheval::hal::sim

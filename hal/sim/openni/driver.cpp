// OpenNI2's way in: the runtime loads this library as it loads a sensor maker's, and asks it for devices.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "hal/sim/openni/control_link.h"
#include "hal/sim/openni/driver_api.h"
#include "hal/sim/openni/faults.h"
#include "hal/sim/openni/sensor_spec.h"
#include "hal/sim/openni/simulated_device.h"

namespace cheval::hal::sim {

namespace {

constexpr const char* kSpecVariable = "CHEVAL_SIMULATED_SENSOR";
constexpr const char* kControlVariable = "CHEVAL_SIMULATED_SENSOR_CONTROL";
constexpr std::string_view kScheme = "cheval:";

std::string fromEnvironment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::string() : std::string(value);
}

class SimulatedDriver final : public oni::driver::DriverBase {
  public:
    explicit SimulatedDriver(OniDriverServices* services) : DriverBase(services) {}

    OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                         oni::driver::DeviceDisconnectedCallback disconnected,
                         oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
        DriverBase::initialize(connected, disconnected, changed, cookie);
        const std::string spec = fromEnvironment(kSpecVariable);
        if (spec.empty()) return ONI_STATUS_OK;
        if (!describe(spec)) return ONI_STATUS_OK;
        const std::string control = fromEnvironment(kControlVariable);
        // The first packet says how things are, before anything is connected.
        if (!control.empty() && !link_.start(control, [this](std::string_view command) { return obey(command); }))
            std::fprintf(stderr, "simulated sensor: nobody listens on %s\n", control.c_str());
        const std::lock_guard lock(mutex_);
        started_ = true;
        if (faults_.plugged) deviceConnected(&device_);
        return ONI_STATUS_OK;
    }

    OniStatus tryDevice(const char* uri) override {
        const std::string_view name(uri);
        if (!name.starts_with(kScheme) || !describe(std::string(name.substr(kScheme.size())))) return ONI_STATUS_ERROR;
        deviceConnected(&device_);
        return ONI_STATUS_OK;
    }

    oni::driver::DeviceBase* deviceOpen(const char* /*uri*/, const char* /*mode*/) override {
        faults_.passThrough(HangingCall::open);
        if (!faults_.plugged || faults_.busy) {
            getServices().errorLoggerAppend(faults_.busy ? "the device is already open in another process"
                                                         : "the device is not there");
            return nullptr;
        }
        Expected<std::unique_ptr<DepthCamera>> camera = makeSpecCamera(spec_, world_, clock_);
        if (!camera) {
            getServices().errorLoggerAppend("%s", camera.error().message().c_str());
            return nullptr;
        }
        // What it says of itself it says once it is open; the device's thread opens it anew when a stream starts.
        const Expected<void> opened = (*camera)->open();
        if (!opened) return nullptr;
        const CameraInfo info = (*camera)->info();
        (*camera)->close();
        return new SimulatedDevice(std::move(*camera), info, faults_);
    }

    void deviceClose(oni::driver::DeviceBase* device) override {
        faults_.passThrough(HangingCall::close);
        delete device;
    }

    void shutdown() override { link_.stop(); }

    void* enableFrameSync(oni::driver::StreamBase** /*streams*/, int /*count*/) override { return this; }

  private:
    bool describe(const std::string& text) {
        Expected<SensorSpec> spec = parseSensorSpec(text);
        const std::string uri = std::string(kScheme) + text;
        if (!spec || uri.size() >= sizeof device_.uri) {
            std::fprintf(stderr, "simulated sensor: %s\n",
                         spec ? "the description is too long" : spec.error().message().c_str());
            return false;
        }
        spec_ = std::move(*spec);
        device_ = {};
        uri.copy(device_.uri, sizeof device_.uri - 1);
        std::strncpy(device_.vendor, "Cheval", sizeof device_.vendor - 1);
        std::strncpy(device_.name, spec_.folder.empty() ? "simulated sensor" : "recorded sensor",
                     sizeof device_.name - 1);
        return true;
    }

    std::string obey(std::string_view command) {
        if (command == "plug" || command == "unplug") {
            const bool plug = command == "plug";
            bool event = false;
            {
                const std::lock_guard lock(mutex_);
                event = faults_.plugged.exchange(plug) != plug && started_;
            }
            if (event && plug) deviceConnected(&device_);
            if (event && !plug) deviceDisconnected(&device_);
            return "ok";
        }
        return faults_.obey(command) ? "ok" : "error: no such command";
    }

    SteadyClock clock_;
    SensorSpec spec_;
    std::shared_ptr<World> world_;
    OniDeviceInfo device_{};
    Faults faults_;
    std::mutex mutex_;
    bool started_ = false;  ///< The runtime has been told of the device.
    ControlLink link_;
};

}  // namespace

}  // namespace cheval::hal::sim

ONI_EXPORT_DRIVER(cheval::hal::sim::SimulatedDriver)

// The only process that links OpenNI2: it may hang, leak or die, and chevald kills and starts it again.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>

#include "daemon/guarded_main.h"
#include "daemon/log.h"
#include "hal/openni/openni_camera.h"
#include "hal/sensor_process/sensor_server.h"

namespace {

using namespace cheval;
using daemon::Severity;

constexpr int kGood = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;

constexpr const char* kFooter =
    "chevald starts this program and hands it the shared memory (descriptor 3), a socket (4) and an event counter (5).";

int run(int argc, char** argv) {
    CLI::App app{"Reads a depth sensor through OpenNI2 for chevald."};
    app.footer(kFooter);
    hal::OpenNiOptions options;
    bool noColour = false;
    app.add_option("--device", options.device, "OpenNI2's URI of the sensor (default: the first that there is)");
    app.add_option("--recording", options.recording, "Play an .oni file in place of a sensor");
    app.add_flag("--no-colour", noColour, "Depth alone");
    app.set_version_flag("--version", "cheval-sensor " CHEVAL_VERSION);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? kGood : kUsage;
    }
    options.colour = !noColour;
    if (::fcntl(hal::kControlDescriptor, F_GETFD) < 0) {
        daemon::log(Severity::error,
                    "cheval-sensor is started by chevald. Mend: run chevald with sensor.source = \"openni\"");
        return kUsage;
    }
    hal::endWithTheOtherSide();
    Expected<std::unique_ptr<hal::OpenNiCamera>> camera = hal::makeOpenNiCamera(options);
    if (!camera) {
        daemon::log(Severity::error, camera.error().message());
        return kFailed;
    }
    hal::OpenNiCamera& sensor = **camera;
    const Expected<void> served = hal::serveSensor(
        sensor, {.recording = !options.recording.empty(), .arrived = [&sensor] { return sensor.takeArrival(); }});
    if (!served) {
        daemon::log(Severity::error, served.error().message());
        return kFailed;
    }
    // The device is closed by now. OpenNI2's own end may hang or crash, and nothing is left that needs it.
    std::fflush(nullptr);
    std::_Exit(kGood);
}

}  // namespace

int main(int argc, char** argv) {
    return cheval::daemon::guardedMain(run, argc, argv, kFailed);
}

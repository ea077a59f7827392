// A sensor that is opened and closed ten thousand times: descriptors, threads and memory of both processes are told and
// held, for SDKs leak at each start of a stream.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include <unistd.h>

#include "hal/sensor_process/process_camera.h"
#include "tests/support/sensor_world.h"

namespace {

using namespace cheval;

constexpr double kAllowedGrowth = 2.0;  ///< Megabytes, of either process.

struct Use {
    long descriptors = 0;
    long threads = 0;
    double megabytes = 0.0;
};

Use useOf(pid_t process) {
    const std::string folder = "/proc/" + std::to_string(process);
    const auto count = [](const std::string& path) {
        return static_cast<long>(
            std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()));
    };
    std::ifstream statm(folder + "/statm");
    long total = 0;
    long resident = 0;
    statm >> total >> resident;
    return {.descriptors = count(folder + "/fd"),
            .threads = count(folder + "/task"),
            .megabytes = static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6};
}

void print(int cycle, const Use& own, const Use& sensor) {
    std::printf("%6d cycles: this process %ld descriptors, %ld threads, %.1f MB; sensor process %ld, %ld, %.1f MB\n",
                cycle, own.descriptors, own.threads, own.megabytes, sensor.descriptors, sensor.threads,
                sensor.megabytes);
    std::fflush(stdout);
}

/// Memory counts only over a run long enough to tell growth from caches (and a sanitizer's quarantine).
bool flat(const Use& before, const Use& after, bool memory) {
    return after.descriptors <= before.descriptors && after.threads <= before.threads &&
           (!memory || after.megabytes <= before.megabytes + kAllowedGrowth);
}

int soak(int cycles, bool memory) {
    // Quick frames, so that a cycle is mostly opening and closing.
    const test::SensorWorld world("sim:seed=2,noise=0,fps=100");
    hal::SteadyClock clock;
    const auto camera = hal::makeProcessCamera({.program = CHEVAL_SENSOR, .environment = world.environment()}, clock);
    Use ownFirst;
    Use sensorFirst;
    const int warm = std::min(200, cycles / 10 + 1);
    for (int cycle = 1; cycle <= cycles; ++cycle) {
        const Expected<void> opened = camera->open();
        if (!opened) {
            std::fprintf(stderr, "cycle %d: %s\n", cycle, opened.error().message().c_str());
            return EXIT_FAILURE;
        }
        hal::DepthFrame frame;
        if (camera->waitFrame(std::chrono::seconds(20), frame) != hal::FrameStatus::frame) {
            std::fprintf(stderr, "cycle %d: no frame\n", cycle);
            return EXIT_FAILURE;
        }
        if (cycle == warm || cycle % 1000 == 0 || cycle == cycles) {
            const Use own = useOf(::getpid());
            const Use sensor = useOf(camera->process());
            print(cycle, own, sensor);
            if (cycle == warm) {
                ownFirst = own;
                sensorFirst = sensor;
            }
            if (cycle == cycles) {
                const bool good =
                    flat(ownFirst, own, memory) && flat(sensorFirst, sensor, memory) && camera->starts() == 1;
                std::printf("%s\n", good ? "passed" : "FAILED");
                return good ? EXIT_SUCCESS : EXIT_FAILURE;
            }
        }
        camera->close();
    }
    return EXIT_FAILURE;
}

}  // namespace

/// soak_reopen [CYCLES]: 10 000, memory held too, if nothing is said; with CYCLES, descriptors and threads alone are
/// held.
int main(int argc, char** argv) {
    const int cycles = argc > 1 ? std::atoi(argv[1]) : 10'000;
    if (cycles < 1) {
        std::fprintf(stderr, "usage: soak_reopen [CYCLES], at least one\n");
        return 2;
    }
    return soak(cycles, argc <= 1);
}

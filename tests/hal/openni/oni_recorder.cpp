// Records a few frames of whatever OpenNI2 finds into an .oni file: oni_recorder FILE FRAMES.
#include <cstdio>
#include <cstdlib>

#include <OpenNI.h>

int main(int argc, char** argv) {
    if (argc != 3 || openni::OpenNI::initialize() != openni::STATUS_OK) return EXIT_FAILURE;
    openni::Device device;
    openni::VideoStream depth;
    openni::VideoStream colour;
    openni::Recorder recorder;
    if (device.open(openni::ANY_DEVICE) != openni::STATUS_OK ||
        depth.create(device, openni::SENSOR_DEPTH) != openni::STATUS_OK ||
        colour.create(device, openni::SENSOR_COLOR) != openni::STATUS_OK ||
        recorder.create(argv[1]) != openni::STATUS_OK || recorder.attach(depth) != openni::STATUS_OK ||
        recorder.attach(colour) != openni::STATUS_OK) {
        std::fprintf(stderr, "%s\n", openni::OpenNI::getExtendedError());
        return EXIT_FAILURE;
    }
    depth.setMirroringEnabled(false);
    colour.setMirroringEnabled(false);
    if (depth.start() != openni::STATUS_OK || colour.start() != openni::STATUS_OK ||
        recorder.start() != openni::STATUS_OK)
        return EXIT_FAILURE;
    int frames = 0;
    for (int waits = 0; frames < std::atoi(argv[2]) && waits < 5000; ++waits) {
        openni::VideoStream* streams[] = {&depth, &colour};
        int ready = -1;
        if (openni::OpenNI::waitForAnyStream(streams, 2, &ready, 100) != openni::STATUS_OK) continue;
        openni::VideoFrameRef frame;
        if ((ready == 0 ? depth : colour).readFrame(&frame) != openni::STATUS_OK) return EXIT_FAILURE;
        frames += ready == 0 ? 1 : 0;
    }
    recorder.stop();
    recorder.destroy();
    std::fflush(nullptr);
    // OpenNI2's own end may hang, and the file is written.
    std::_Exit(EXIT_SUCCESS);
}

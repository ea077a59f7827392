// Resets the depth sensor, in a process that may be given up on; what it ends with is for hal/usb/usb_reset.cpp.
#include <cstdio>
#include <string>

#include "hal/usb/usb_reset.h"

int main(int argc, char** argv) {
    constexpr int kUsage = 2;
    const std::string port = argc == 2 ? argv[1] : "";  // NOLINT(cppcoreguidelines-pro-bounds-pointer-arithmetic)
    if (argc > 2 || port.starts_with('-')) {
        std::fputs("usage: cheval-usb-reset [PORT]\n  PORT: where the sensor is plugged in, e.g. 1-2.3\n", stderr);
        return kUsage;
    }
    std::string message;
    const int status = cheval::hal::resetSensorHere(port, message);
    if (!message.empty()) {
        std::fputs(message.c_str(), stderr);
        std::fputc('\n', stderr);
    }
    return status;
}

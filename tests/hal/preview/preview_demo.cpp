// A server for the browser test: a moving picture whose colour changes with Next. Prints its address and runs until its
// input ends or SIGTERM comes; either way it ends as a mirror does, with status 0.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <string>

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "hal/preview/preview_server.h"

using namespace cheval;

namespace {

constexpr std::array<hal::Rgba8, 3> kColours{hal::Rgba8{200, 60, 60, 255}, hal::Rgba8{60, 160, 80, 255},
                                             hal::Rgba8{70, 90, 200, 255}};

// A figure of one colour that sways before a light wall.
void draw(hal::ImageView<hal::Rgba8> pixels, int frame, hal::Rgba8 colour) {
    const int sway = std::abs(frame % 60 - 30) - 15;
    for (int y = 0; y < pixels.height; ++y) {
        std::fill_n(pixels.row(y), pixels.width, hal::Rgba8{225, 222, 214, 255});
        const int left = pixels.width / 3 + sway * pixels.width / 200;
        if (y > pixels.height / 5) std::fill_n(pixels.row(y) + left, pixels.width / 3, colour);
    }
}

// SIGTERM as something to poll. Called before there is any thread, so that none of them is ended by it.
int openTermination() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    return ::signalfd(-1, &signals, SFD_CLOEXEC);
}

bool over(int termination, hal::Duration limit) {
    std::array<pollfd, 2> ends{pollfd{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0},
                               pollfd{.fd = termination, .events = POLLIN, .revents = 0}};
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(limit).count();
    if (::poll(ends.data(), ends.size(), static_cast<int>(milliseconds)) <= 0) return false;
    if (ends[1].revents != 0) return true;
    char byte = 0;
    return ::read(STDIN_FILENO, &byte, 1) <= 0;
}

}  // namespace

int main() {
    const int termination = openTermination();
    if (termination < 0) return 1;
    hal::SteadyClock clock;
    auto server = hal::startPreview({.mode = {.width = 270, .height = 480}, .port = 0, .streamWidth = 270}, clock);
    if (!server) {
        std::fprintf(stderr, "%s\n", server.error().message().c_str());
        return 1;
    }
    hal::Display& display = (*server)->display();
    if (!display.open()) return 1;
    std::printf("%s\n", (*server)->address().c_str());
    std::fflush(stdout);
    std::size_t chosen = 0;
    for (int frame = 0; !over(termination, std::chrono::milliseconds(33)); ++frame) {
        std::array<hal::ButtonEvent, 8> events;
        const auto pressed = (*server)->buttons().poll(events);
        for (std::size_t i = 0; pressed && i < *pressed; ++i) {
            if (events[i].button == hal::Button::next) chosen = (chosen + 1) % kColours.size();
            if (events[i].button == hal::Button::previous) chosen = (chosen + kColours.size() - 1) % kColours.size();
        }
        (*server)->setStatus("garment " + std::to_string(chosen + 1) + " of " + std::to_string(kColours.size()));
        const auto buffer = display.lend(hal::Duration::zero());
        if (!buffer) return 1;
        draw(buffer->pixels, frame, kColours[chosen]);
        if (!display.present(*buffer, clock.now())) return 1;
    }
    return 0;
}

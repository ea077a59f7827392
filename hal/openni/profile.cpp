#include "hal/openni/profile.h"

#include <array>

namespace cheval::hal {

namespace {

struct Rung {
    int width;
    int height;
    int slowest;
    int enlarge;
};
constexpr std::array<Rung, 4> kLadder = {{{640, 480, 30, 1}, {640, 480, 15, 1}, {320, 240, 30, 2}, {320, 240, 15, 2}}};
constexpr int kWanted = 30;

/// Is `a` better than `b`, both of one rung? Nearest above 30 Hz; below it, the fastest.
bool better(const DepthMode& a, const DepthMode& b) {
    if (a.framesPerSecond != b.framesPerSecond) {
        if (a.framesPerSecond >= kWanted && b.framesPerSecond >= kWanted) return a.framesPerSecond < b.framesPerSecond;
        return a.framesPerSecond > b.framesPerSecond;
    }
    return !a.tenths && b.tenths;
}

}  // namespace

std::optional<DepthProfile> chooseProfile(std::span<const DepthMode> modes) {
    for (const Rung& rung : kLadder) {
        std::optional<std::size_t> best;
        for (std::size_t i = 0; i < modes.size(); ++i) {
            const DepthMode& mode = modes[i];
            if (mode.width != rung.width || mode.height != rung.height || mode.framesPerSecond < rung.slowest) continue;
            if (!best || better(mode, modes[*best])) best = i;
        }
        if (best) return DepthProfile{.mode = *best, .enlarge = rung.enlarge};
    }
    return std::nullopt;
}

}  // namespace cheval::hal

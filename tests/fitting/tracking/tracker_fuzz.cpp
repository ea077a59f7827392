// Fuzzes the tracker with whole frames: each eight bytes of input draw a box or speckle, or send the frame off.
#include <algorithm>
#include <cmath>
#include <span>

#include "fitting/tracking/tracker.h"
#include "tests/support/fuzz.h"

using namespace cheval;

namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr std::size_t kRecord = 8;
constexpr int kMostFrames = 4;
constexpr std::size_t kMostRecords = 64;

std::uint16_t millimetres(const std::uint8_t* at) {
    return static_cast<std::uint16_t>(at[0] | at[1] << 8U);
}

void drawBox(std::vector<std::uint16_t>& depth, const std::uint8_t* at, bool speckled) {
    const int left = at[1] * kWidth / 256;
    const int top = at[2] * kHeight / 256;
    const int right = std::min(kWidth, left + at[3] * 3);
    const int bottom = std::min(kHeight, top + at[4] * 2);
    for (int row = top; row < bottom; ++row) {
        for (int column = left; column < right; ++column) {
            if (speckled && (row * 31 + column * 17 + at[7]) % 5 != 0) continue;
            depth[static_cast<std::size_t>(row) * kWidth + static_cast<std::size_t>(column)] = millimetres(at + 5);
        }
    }
}

/// What every answer must be, whatever was seen.
void check(const fitting::Tracker& tracker) {
    if (tracker.users().count > tracker.users().users.size()) __builtin_trap();
    if (!tracker.placement().translation.allFinite() || !tracker.placement().rotation.allFinite()) __builtin_trap();
    for (const fitting::JointState& joint : tracker.skeleton().joints) {
        if (!joint.position.allFinite() || !(joint.confidence >= 0.0F && joint.confidence <= 1.0F)) __builtin_trap();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    // One for all inputs, as in a mirror: making it costs more than a frame does.
    static fitting::Tracker tracker(fitting::TrackerOptions{});
    tracker.reset();
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(kWidth) * kHeight);
    hal::DepthFrame frame;
    frame.depth = {depth.data(), kWidth, kHeight, kWidth};
    int frames = 0;
    const std::size_t records = std::min(size / kRecord, kMostRecords);
    for (std::size_t i = 0; i < records && frames < kMostFrames; ++i) {
        const std::uint8_t* at = data + i * kRecord;
        if (at[0] % 4 != 0) {
            drawBox(depth, at, at[0] % 4 == 3);
            continue;
        }
        // Time may stand still, jump by half an hour or go back; intrinsics may be anybody's.
        frame.captureTime += std::chrono::milliseconds(millimetres(at + 1) * (at[4] == 255   ? -1
                                                                              : at[4] == 254 ? 30
                                                                                             : 1));
        frame.restart = at[5] == 255;
        if (at[6] != 0) frame.intrinsics.fx = frame.intrinsics.fy = static_cast<float>(at[6]) * 8.0F;
        if (at[7] != 0) frame.intrinsics.cx = static_cast<float>(at[7]) * 4.0F - 200.0F;
        hal::DepthFrame shown = frame;
        if (at[5] == 254) shown.depth = {};
        tracker.track(shown);
        tracker.readHands(shown);
        check(tracker);
        ++frames;
    }
    return 0;
}

std::vector<cheval::test::FuzzInput> cheval::test::fuzzSeeds() {
    // A wall, then a body with a head before it that steps to the side, at 30 Hz; an empty view; a jump in time.
    const FuzzInput send = {0, 33, 0, 0, 0, 0, 0, 0};
    const FuzzInput wall = {1, 0, 0, 255, 255, 0x88, 0x13, 0};
    const FuzzInput body = {1, 110, 70, 40, 160, 0xC4, 0x09, 0};
    const FuzzInput head = {1, 117, 30, 16, 40, 0xC4, 0x09, 0};
    const FuzzInput empty = {0, 33, 0, 0, 0, 254, 0, 0};
    const FuzzInput jump = {0, 255, 255, 0, 254, 0, 20, 10};
    const FuzzInput speckle = {3, 0, 0, 255, 255, 0xFF, 0xFF, 3};
    const auto joined = [](std::initializer_list<FuzzInput> parts) {
        FuzzInput all;
        for (const FuzzInput& part : parts)
            all.insert(all.end(), part.begin(), part.end());
        return all;
    };
    return {joined({wall, send, body, head, send, send, send}),
            joined({wall, body, head, send, empty, send, jump, send}), joined({wall, speckle, send, body, send, jump})};
}

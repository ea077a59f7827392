// What chevald and cheval-sensor say to each other, one packet a message, over a SOCK_SEQPACKET pair. Both are of one
// release; still, what comes from the other process is checked before it is believed.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "hal/depth_camera.h"
#include "hal/expected.h"

namespace cheval::hal {

enum class MessageKind : std::uint32_t {
    // To the sensor process.
    open = 1,       ///< Open the device and stream; `opening` names this opening from now on.
    close,          ///< Stop and close the device; the process stays.
    restartStream,  ///< Stop and start the stream of the open device.
    next,           ///< Recordings: one more frame.
    quit,           ///< Close and exit.
    // From it.
    opened,   ///< The device streams; `info` and `recording` are set.
    refused,  ///< It could not be opened; the texts say why.
    lost,     ///< It is gone, or broken.
    ended,    ///< The recording is over.
    arrived,  ///< A device was plugged in.
    done,     ///< What `close` or `restartStream` asked for: the process still answers.
};

/// Texts are cut to their room, and end with a zero.
template <std::size_t N>
struct MessageText {
    std::array<char, N> bytes{};
    void assign(std::string_view text) {
        const std::size_t length = text.size() < N - 1 ? text.size() : N - 1;
        bytes = {};
        text.copy(bytes.data(), length);
    }
    /// Whatever the other side wrote, the view ends within the room.
    [[nodiscard]] std::string_view view() const {
        const std::string_view whole(bytes.data(), N);
        return whole.substr(0, whole.find('\0'));
    }
};

struct Message {
    MessageKind kind = MessageKind::open;
    std::uint32_t opening = 0;  ///< Which `open` it belongs to.
    std::uint32_t recording = 0;
    ErrorCode code = ErrorCode::internal;
    Intrinsics intrinsics;
    Mount mount;
    std::uint32_t colour = 0;
    double framesPerSecond = 0.0;
    MessageText<128> name;
    MessageText<512> cause;
    MessageText<256> mend;
    MessageText<256> why;
};

enum class Received : std::uint8_t { message, nothing, gone };

/// Sends without waiting; false when the other side is gone or does not read.
bool sendMessage(int socket, const Message& message);
/// Receives without waiting. A packet of another size counts as gone: that is no sensor process of this release.
Received receiveMessage(int socket, Message& message);

/// What `opened` says, or why it cannot be believed: sizes beyond the ring's, numbers that are none.
Expected<CameraInfo> cameraInfo(const Message& message);
/// What `refused` and `lost` say.
Error errorOf(const Message& message);
void setError(Message& message, const Error& error);

}  // namespace cheval::hal

#include "hal/sensor_process/message.h"

#include <cerrno>
#include <cmath>
#include <string>
#include <type_traits>

#include <sys/socket.h>

#include "hal/sensor_process/frame_ring.h"

namespace cheval::hal {

static_assert(std::is_trivially_copyable_v<Message>);

bool sendMessage(int socket, const Message& message) {
    return ::send(socket, &message, sizeof message, MSG_NOSIGNAL | MSG_DONTWAIT) == ssize_t{sizeof message};
}

Received receiveMessage(int socket, Message& message) {
    Message received;
    const ssize_t size = ::recv(socket, &received, sizeof received, MSG_DONTWAIT | MSG_TRUNC);
    if (size < 0) return errno == EAGAIN || errno == EINTR ? Received::nothing : Received::gone;
    if (size != ssize_t{sizeof received}) return Received::gone;
    message = received;
    return Received::message;
}

Expected<CameraInfo> cameraInfo(const Message& message) {
    const Intrinsics& says = message.intrinsics;
    const Mount& mount = message.mount;
    const bool sizes = says.width > 0 && says.height > 0 && says.width <= static_cast<int>(kRingMaxWidth) &&
                       says.height <= static_cast<int>(kRingMaxHeight);
    bool numbers = says.fx > 0.0F && says.fy > 0.0F && message.framesPerSecond > 0.0;
    for (const double value :
         {double{says.fx}, double{says.fy}, double{says.cx}, double{says.cy}, message.framesPerSecond,
          double{mount.heightMm}, double{mount.tiltDeg}, double{mount.rollDeg}})
        numbers = numbers && std::isfinite(value);
    if (!sizes || !numbers) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = "the sensor process describes a picture of " + std::to_string(says.width) + "×" +
                              std::to_string(says.height) + " that cannot be",
                     .mend = "install chevald and cheval-sensor of one and the same release"};
    }
    return CameraInfo{.name = std::string(message.name.view()),
                      .intrinsics = says,
                      .framesPerSecond = message.framesPerSecond,
                      .mount = mount,
                      .colour = message.colour != 0};
}

Error errorOf(const Message& message) {
    return {.code = message.code,
            .cause = std::string(message.cause.view()),
            .mend = std::string(message.mend.view()),
            .why = std::string(message.why.view())};
}

void setError(Message& message, const Error& error) {
    message.code = error.code;
    message.cause.assign(error.file.empty() ? error.cause : error.file + ": " + error.cause);
    message.mend.assign(error.mend);
    message.why.assign(error.why);
}

}  // namespace cheval::hal

#include "hal/sensor_process/sensor_server.h"

#include <cstdlib>
#include <thread>
#include <utility>

#include <poll.h>
#include <sys/eventfd.h>

#include "hal/sensor_process/message.h"

namespace cheval::hal {

namespace {

using std::chrono::milliseconds;

constexpr Duration kFrameWait = milliseconds(50);
constexpr int kIdleWaitMs = 50;

class SensorServer {
  public:
    SensorServer(DepthCamera& camera, SensorServerOptions options, RingMemory memory)
        : camera_(camera), options_(std::move(options)), writer_(std::move(memory)) {}

    void run() {
        while (obey()) {
            if (options_.arrived && options_.arrived()) say(Message{.kind = MessageKind::arrived});
            if (streaming_ && (!options_.recording || asked_ > 0)) {
                serveFrame();
            } else {
                pollfd waits{.fd = options_.control.get(), .events = POLLIN, .revents = 0};
                ::poll(&waits, 1, kIdleWaitMs);
            }
        }
        camera_.close();
    }

  private:
    void say(Message message) {
        message.opening = opening_;
        sendMessage(options_.control.get(), message);
    }

    void sayError(MessageKind kind, const Error& error) {
        Message message{.kind = kind};
        setError(message, error);
        say(message);
    }

    /// False: it is over.
    bool obey() {
        Message message;
        while (true) {
            const Received received = receiveMessage(options_.control.get(), message);
            if (received == Received::nothing) return true;
            if (received == Received::gone || message.kind == MessageKind::quit) return false;
            switch (message.kind) {
                case MessageKind::open:
                    opening_ = message.opening;
                    open();
                    break;
                case MessageKind::close:
                    camera_.close();
                    streaming_ = false;
                    say(Message{.kind = MessageKind::done});
                    break;
                case MessageKind::restartStream:
                    restart();
                    say(Message{.kind = MessageKind::done});
                    break;
                case MessageKind::next:
                    ++asked_;
                    break;
                default:
                    break;
            }
        }
    }

    void open() {
        camera_.close();
        asked_ = 0;
        const Expected<void> opened = camera_.open();
        streaming_ = opened.hasValue();
        if (!opened) {
            sayError(MessageKind::refused, opened.error());
            return;
        }
        const CameraInfo& info = camera_.info();
        Message message{.kind = MessageKind::opened,
                        .recording = options_.recording ? 1U : 0U,
                        .intrinsics = info.intrinsics,
                        .mount = info.mount,
                        .colour = info.colour ? 1U : 0U,
                        .framesPerSecond = info.framesPerSecond};
        message.name.assign(info.name);
        say(message);
    }

    void restart() {
        if (!streaming_) return;
        const Expected<void> restarted = camera_.restartStream();
        if (!restarted) lose(restarted.error());
    }

    void lose(const Error& why) {
        camera_.close();
        streaming_ = false;
        sayError(MessageKind::lost, why);
    }

    void serveFrame() {
        DepthFrame frame;
        switch (camera_.waitFrame(kFrameWait, frame)) {
            case FrameStatus::frame: {
                const Expected<void> written = writer_.write(frame, opening_);
                if (!written) return lose(written.error());
                if (asked_ > 0) --asked_;
                ::eventfd_write(options_.frames.get(), 1);
                return;
            }
            case FrameStatus::timedOut:
                return;
            case FrameStatus::ended:
                streaming_ = false;
                return say(Message{.kind = MessageKind::ended});
            case FrameStatus::lost:
            case FrameStatus::closed:
                return lose(camera_.lossReason().value_or(
                    Error{.code = ErrorCode::unavailable,
                          .cause = "the sensor is gone",
                          .mend = "check its cable and its power; it is reopened by itself"}));
        }
    }

    DepthCamera& camera_;
    SensorServerOptions options_;
    RingWriter writer_;
    std::uint32_t opening_ = 0;
    std::uint64_t asked_ = 0;  ///< Frames of a recording that were asked for and not sent.
    bool streaming_ = false;
};

void waitForTheEnd(int control) {
    while (true) {
        pollfd waits{.fd = control, .events = POLLRDHUP, .revents = 0};
        if (::poll(&waits, 1, 1000) > 0 && (waits.revents & (POLLHUP | POLLRDHUP | POLLERR | POLLNVAL)) != 0) break;
    }
    std::_Exit(EXIT_SUCCESS);
}

}  // namespace

void endWithTheOtherSide(int control) {
    std::thread(waitForTheEnd, control).detach();
}

Expected<void> serveSensor(DepthCamera& camera, SensorServerOptions options) {
    auto memory = RingMemory::attach(std::move(options.ring));
    if (!memory) return std::move(memory).error();
    SensorServer(camera, std::move(options), std::move(*memory)).run();
    return {};
}

}  // namespace cheval::hal

#include "hal/sensor_process/process_camera.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "hal/child_process.h"
#include "hal/sensor_process/frame_ring.h"
#include "hal/sensor_process/message.h"

namespace cheval::hal {

namespace {

using std::chrono::milliseconds;

constexpr Duration kSlice = milliseconds(20);               ///< A wait looks for close() this often.
constexpr Duration kQuitLimit = milliseconds(200);          ///< For the process to end in order.
constexpr Duration kAnswerLimit = std::chrono::seconds(3);  ///< For `close` and `restartStream` to be done.
constexpr int kMessagesAtOnce = 64;
constexpr Duration kRecordingLimit = std::chrono::seconds(10);  ///< For one frame of a recording to be read.

constexpr const char* kByItself = "it is started again by itself; if that does not help, see journalctl -u cheval";

/// One life of the sensor process, with what is shared with it.
struct SensorProcess {
    ChildProcess child;
    Descriptor control;
    Descriptor frames;  ///< An eventfd, written when a frame was published.
    RingReader reader;
};

Expected<SensorProcess> startProcess(const ProcessCameraOptions& options) {
    auto memory = RingMemory::create();
    if (!memory) return std::move(memory).error();
    std::array<int, 2> ends{-1, -1};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
        return Error{.code = ErrorCode::resource, .cause = std::string("socketpair failed: ") + std::strerror(errno)};
    Descriptor ours(ends[0]);
    const Descriptor theirs(ends[1]);
    Descriptor frames(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (!frames.valid())
        return Error{.code = ErrorCode::resource, .cause = std::string("eventfd failed: ") + std::strerror(errno)};
    auto child = ChildProcess::start({.program = options.program,
                                      .arguments = options.arguments,
                                      .environment = options.environment,
                                      .descriptors = {memory->descriptor(), theirs.get(), frames.get()}});
    if (!child) return std::move(child).error();
    return SensorProcess{.child = std::move(*child),
                         .control = std::move(ours),
                         .frames = std::move(frames),
                         .reader = RingReader(std::move(*memory))};
}

class ProcessCameraImplementation final : public ProcessCamera {
  public:
    ProcessCameraImplementation(const ProcessCameraOptions& options, Clock& clock) : options_(options), clock_(clock) {}
    ~ProcessCameraImplementation() override {
        close();
        if (!process_) return;
        // In order if it can: a device that is closed is found sound by whoever opens it next.
        if (sendMessage(process_->control.get(), Message{.kind = MessageKind::quit}))
            process_->child.waitEnd(kQuitLimit);
    }
    ProcessCameraImplementation(const ProcessCameraImplementation&) = delete;
    ProcessCameraImplementation& operator=(const ProcessCameraImplementation&) = delete;

    [[nodiscard]] pid_t process() const override { return process_ ? process_->child.pid() : -1; }
    [[nodiscard]] std::uint64_t starts() const override { return starts_; }
    [[nodiscard]] Duration handOver() const override { return handOver_; }
    [[nodiscard]] std::optional<Error> lossReason() const override { return loss_; }

  protected:
    bool doTakeArrival() override {
        if (process_ && !isOpen()) listen();
        return std::exchange(arrived_, false);
    }

    Expected<CameraInfo> doOpen() override {
        if (process_ && !process_->child.running()) process_.reset();
        if (!process_) {
            auto started = startProcess(options_);
            if (!started) return std::move(started).error().within("while starting the sensor process");
            process_.emplace(std::move(*started));
            opening_ = 0;
            asked_ = false;
            answers_ = 0;
            ++starts_;
        }
        if (!asked_) {
            answer_.reset();
            loss_.reset();
            sendMessage(process_->control.get(), Message{.kind = MessageKind::open, .opening = ++opening_});
            asked_ = true;
        }
        const SteadyClock steady;
        const TimePoint limit = steady.now() + options_.openWait;
        while (true) {
            listen();
            if (loss_) {
                asked_ = false;
                return *loss_;
            }
            if (answer_) return takeAnswer();
            const TimePoint now = steady.now();
            if (now >= limit || closing()) {
                return Error{.code = ErrorCode::timedOut,
                             .cause = "the sensor is still being opened",
                             .mend = "wait; a sensor's firmware may take some seconds"};
            }
            waitForIt(std::min<Duration>(limit - now, kSlice));
        }
    }

    void doClose() override {
        pending_ = false;
        if (process_) expectAnswer(Message{.kind = MessageKind::close, .opening = opening_});
    }

    Expected<void> doRestartStream() override {
        if (process_ && expectAnswer(Message{.kind = MessageKind::restartStream, .opening = opening_})) return {};
        return Error{.code = ErrorCode::unavailable, .cause = "the sensor process does not listen", .mend = kByItself};
    }

    FrameStatus doWaitFrame(Duration timeout, DepthFrame& frame, Interrupt& interrupt) override {
        return recording_ ? waitRecorded(timeout, frame, interrupt) : waitLive(timeout, frame, interrupt);
    }

  private:
    /// Takes in what the process has said, and notices when it is gone.
    void listen() {
        Message message;
        for (int i = 0; i < kMessagesAtOnce; ++i) {
            const Received received = receiveMessage(process_->control.get(), message);
            if (received == Received::nothing) break;
            if (received == Received::gone) {
                process_->child.waitEnd(kQuitLimit);
                dropProcess();
                return;
            }
            take(message);
        }
        if (!process_->child.running()) return dropProcess();
        if (answers_ == 0 || SteadyClock().now() - askedAt_ < kAnswerLimit) return;
        dropProcess();
        loss_->cause = "the sensor process did not answer any more";
    }

    /// Asks for something that is answered by `done`, as long as the process does not hang.
    bool expectAnswer(const Message& message) {
        if (!sendMessage(process_->control.get(), message)) return false;
        if (answers_++ == 0) askedAt_ = SteadyClock().now();
        return true;
    }

    void take(const Message& message) {
        if (message.kind == MessageKind::arrived) arrived_ = true;
        if (message.kind == MessageKind::done && answers_ > 0) {
            --answers_;
            askedAt_ = SteadyClock().now();
        }
        if (message.opening != opening_) return;  // Of an opening that is over.
        if (message.kind == MessageKind::opened || message.kind == MessageKind::refused) answer_ = message;
        if (message.kind == MessageKind::lost) loss_ = errorOf(message);
        if (message.kind == MessageKind::ended) ended_ = true;
    }

    void dropProcess() {
        process_->child.kill();
        loss_ = Error{.code = ErrorCode::unavailable,
                      .cause = "the sensor process " + process_->child.ending(),
                      .mend = kByItself,
                      .why = "a depth sensor's library may fail; the mirror does not fail with it"};
        process_.reset();
    }

    Expected<CameraInfo> takeAnswer() {
        asked_ = false;
        const Message answer = *std::exchange(answer_, std::nullopt);
        if (answer.kind == MessageKind::refused) return errorOf(answer);
        auto info = cameraInfo(answer);
        if (!info) return info;
        intrinsics_ = info->intrinsics;
        recording_ = answer.recording != 0;
        ended_ = false;
        pending_ = false;
        fresh_ = true;
        firstSequence_ = nextSequence_ = 0;
        start_ = clock_.now();
        return info;
    }

    /// Until a frame was published, something was said, the process ended, or the time is over.
    void waitForIt(Duration limit) {
        if (!process_) return;
        std::array<pollfd, 3> waits = {pollfd{.fd = process_->frames.get(), .events = POLLIN, .revents = 0},
                                       pollfd{.fd = process_->control.get(), .events = POLLIN, .revents = 0},
                                       pollfd{.fd = process_->child.descriptor(), .events = POLLIN, .revents = 0}};
        const timespec time{.tv_sec = 0, .tv_nsec = std::clamp<Duration>(limit, Duration::zero(), kSlice).count()};
        if (::ppoll(waits.data(), waits.size(), &time, nullptr) <= 0 || (waits[0].revents & POLLIN) == 0) return;
        eventfd_t published = 0;
        ::eventfd_read(process_->frames.get(), &published);
    }

    /// The newest frame of this opening, if there is one. A writer that breaks the rules is ended.
    FrameStatus takeFrame(DepthFrame& frame) {
        const RingReader::Status status = process_->reader.take(frame);
        if (status == RingReader::Status::nothing) return FrameStatus::timedOut;
        const RingFrame& meta = process_->reader.meta();
        if (status == RingReader::Status::frame && meta.opening != opening_) return FrameStatus::timedOut;
        const bool sound = status == RingReader::Status::frame && frame.depth.width == intrinsics_.width &&
                           frame.depth.height == intrinsics_.height;
        if (!sound) {
            dropProcess();
            loss_->cause = status == RingReader::Status::frame
                               ? "the sensor process sends pictures of another size than it said"
                               : "the sensor process breaks the rules of the frame ring";
            return FrameStatus::lost;
        }
        handOver_ = SteadyClock().now().time_since_epoch() - Duration(meta.publishedNs);
        frame.intrinsics = intrinsics_;
        frame.restart = std::exchange(fresh_, false) || frame.restart;
        return FrameStatus::frame;
    }

    FrameStatus waitLive(Duration timeout, DepthFrame& frame, Interrupt& interrupt) {
        const TimePoint limit = clock_.now() + std::max(timeout, Duration::zero());
        while (true) {
            if (interrupt.raised()) return FrameStatus::closed;
            if (!process_) return FrameStatus::lost;
            const FrameStatus status = takeFrame(frame);
            if (status != FrameStatus::timedOut) return status;
            listen();
            if (loss_) return FrameStatus::lost;
            if (ended_) return FrameStatus::ended;
            const TimePoint now = clock_.now();
            if (now >= limit) return FrameStatus::timedOut;
            waitForIt(limit - now);
        }
    }

    FrameStatus waitRecorded(Duration timeout, DepthFrame& frame, Interrupt& interrupt) {
        const TimePoint begin = clock_.now();
        if (!pending_) {
            FrameStatus fetched = fetch(interrupt);
            if (fetched == FrameStatus::ended && options_.loop && nextSequence_ > firstSequence_) {
                fetched = startAgain();
                if (fetched == FrameStatus::frame) fetched = fetch(interrupt);
            }
            if (fetched != FrameStatus::frame) return fetched;
            recorded_.sequence += firstSequence_;
            nextSequence_ = recorded_.sequence + 1;
        }
        const TimePoint due = start_ + recorded_.captureTime.time_since_epoch();
        const TimePoint limit = begin + std::max(timeout, Duration::zero());
        if (due > limit) return clock_.waitUntil(limit, interrupt) ? FrameStatus::timedOut : FrameStatus::closed;
        if (!clock_.waitUntil(due, interrupt)) return FrameStatus::closed;
        pending_ = false;
        frame = recorded_;
        frame.captureTime = due;
        return FrameStatus::frame;
    }

    /// Opens the recording anew, its times and numbers going on from here.
    FrameStatus startAgain() {
        const TimePoint start = clock_.now();
        const std::uint64_t next = nextSequence_;
        asked_ = false;
        const Expected<CameraInfo> opened = doOpen();
        if (!opened) {
            loss_ = opened.error();
            return FrameStatus::lost;
        }
        start_ = start;
        firstSequence_ = nextSequence_ = next;
        return FrameStatus::frame;
    }

    /// Asks for the recording's next frame and waits until it is read, which takes no time of the recording's.
    FrameStatus fetch(Interrupt& interrupt) {
        if (ended_) return FrameStatus::ended;
        if (!process_) return FrameStatus::lost;
        sendMessage(process_->control.get(), Message{.kind = MessageKind::next, .opening = opening_});
        const SteadyClock steady;
        const TimePoint limit = steady.now() + kRecordingLimit;
        while (steady.now() < limit) {
            if (interrupt.raised()) return FrameStatus::closed;
            const FrameStatus status = takeFrame(recorded_);
            pending_ = status == FrameStatus::frame;
            if (status != FrameStatus::timedOut) return status;
            listen();
            if (loss_) return FrameStatus::lost;
            if (ended_) return FrameStatus::ended;
            waitForIt(kSlice);
        }
        dropProcess();
        loss_->cause = "the recording's next frame could not be read within 10 s";
        return FrameStatus::lost;
    }

    ProcessCameraOptions options_;
    Clock& clock_;
    std::optional<SensorProcess> process_;
    std::uint64_t starts_ = 0;
    std::uint32_t opening_ = 0;
    int answers_ = 0;      ///< `done` messages that are to come.
    TimePoint askedAt_{};  ///< Since when.
    bool asked_ = false;   ///< `open` was sent and not answered yet.
    std::optional<Message> answer_;
    std::optional<Error> loss_;
    bool arrived_ = false;

    Intrinsics intrinsics_;
    bool recording_ = false;
    bool ended_ = false;
    bool fresh_ = true;     ///< The next frame is the first of this opening.
    bool pending_ = false;  ///< recorded_ was fetched and is not due yet.
    DepthFrame recorded_;
    std::uint64_t firstSequence_ = 0;  ///< Of this pass of the recording.
    std::uint64_t nextSequence_ = 0;
    TimePoint start_{};
    Duration handOver_{};
};

}  // namespace

std::unique_ptr<ProcessCamera> makeProcessCamera(const ProcessCameraOptions& options, Clock& clock) {
    return std::make_unique<ProcessCameraImplementation>(options, clock);
}

}  // namespace cheval::hal

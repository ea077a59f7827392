// What to do when a sensor sends no frames: one ladder, from reading again to a reboot. A pure state machine: it is
// told what happened and says what to do; CameraSupervisor does it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "hal/clock.h"
#include "hal/expected.h"

namespace cheval::daemon {

/// The rungs, each dearer than the one before.
enum class RecoveryRung : std::uint8_t {
    retryRead,      ///< Wait for another frame's time.
    restartStream,  ///< Stop and start the stream of the open device.
    reopenDevice,   ///< Close and open the device.
    recycle,        ///< End the sensor process and start a new one.
    resetUsb,       ///< Make the device enumerate anew.
    powerCycle,     ///< Switch its power off and on, where a line is wired to it.
    restartDaemon,  ///< End with an error: systemd starts the daemon anew.
    reboot,         ///< End with the status at which systemd reboots the machine.
};
constexpr std::size_t kRecoveryRungCount = 8;
/// In the words of settings and status: retry, stream, device, process, usb, power, daemon, machine.
std::string_view name(RecoveryRung rung);

enum class RecoveryState : std::uint8_t {
    closed,     ///< Not begun.
    opening,    ///< A device is being opened.
    unproven,   ///< Something was done; no frame has come yet.
    streaming,  ///< Frames flow.
    doubtful,   ///< They should, and are late.
    resting,    ///< Waiting before the next rung; a stream that is open may still come back.
    ended,      ///< A recording is over.
};
std::string_view name(RecoveryState state);

enum class RecoveryEvent : std::uint8_t {
    begin,     ///< The mirror starts.
    opened,    ///< What was asked for is done, and the device streams.
    prepared,  ///< A rung above recycle has done its part; opening the device begins.
    refused,   ///< It could not be done.
    frame,     ///< A frame came.
    lost,      ///< The device, or its process, is gone.
    arrived,   ///< A sensor was plugged in.
    timer,     ///< deadline() is reached.
    ended,     ///< The recording is over.
};
std::string_view name(RecoveryEvent event);

/// What the supervisor must do now.
enum class RecoveryAction : std::uint8_t {
    none,
    open,     ///< Open, making the camera if there is none.
    perform,  ///< What `rung()` says.
};

struct RecoveryOptions {
    /// Without a frame for this long the sensor is taken in hand, half of it before it is doubted; std::nullopt: never
    /// (a recording's gap is no fault).
    std::optional<hal::Duration> silence = std::chrono::seconds(1);
    hal::Duration openLimit = std::chrono::seconds(15);         ///< An opening that takes longer hangs.
    hal::Duration firstFrame = std::chrono::seconds(3);         ///< From opened to the first frame.
    hal::Duration firstPause = std::chrono::milliseconds(500);  ///< Before the second rung; doubles …
    hal::Duration longestPause = std::chrono::seconds(30);      ///< … up to this.
    hal::Duration healthy = std::chrono::seconds(1);            ///< Frames for this long, and all is forgotten.
    hal::Duration restartAfter = std::chrono::minutes(15);      ///< Without frames, before RecoveryRung::restartDaemon.
    std::uint32_t restartsBefore = 0;              ///< How often the daemon was restarted for this already, in a row.
    RecoveryRung highest = RecoveryRung::recycle;  ///< No rung above it is ever taken.
    /// Whether a rung above recycle can be taken at this moment (a sensor is on the bus, a line is wired); empty: none.
    std::function<bool(RecoveryRung)> available;
};

/// The rungs above recycle, whose hardware and whose host only a port knows. Thread-bound.
class RecoveryHardware {
  public:
    virtual ~RecoveryHardware() = default;
    RecoveryHardware(const RecoveryHardware&) = delete;
    RecoveryHardware& operator=(const RecoveryHardware&) = delete;

    /// Whether this rung can be taken now: a sensor is on the bus, a power line is wired, a service manager is there.
    [[nodiscard]] virtual bool available(RecoveryRung rung) const = 0;
    /// Takes the rung, without waiting: ErrorCode::timedOut means that it is at work, and must be called again.
    virtual Expected<void> perform(RecoveryRung rung) = 0;
    /// True once for each sensor that was plugged in since the last call.
    virtual bool takeArrival() = 0;
    /// How often the daemon was restarted in a row because of the sensor, without frames in between.
    [[nodiscard]] virtual std::uint32_t restartsBefore() const = 0;
    /// Frames have flowed long enough to forget earlier restarts. Told with every frame; must be cheap.
    virtual void healthy() = 0;

  protected:
    RecoveryHardware() = default;
};

/// Thread-bound. No call takes heap memory.
class RecoveryMachine {
  public:
    explicit RecoveryMachine(const RecoveryOptions& options);

    RecoveryAction on(RecoveryEvent event, hal::TimePoint now);

    [[nodiscard]] RecoveryState state() const { return state_; }
    /// When RecoveryEvent::timer is due; TimePoint::max(): never.
    [[nodiscard]] hal::TimePoint deadline() const { return deadline_; }
    /// The rung that was taken last, or waits to be.
    [[nodiscard]] RecoveryRung rung() const { return rung_; }
    /// Frames have flowed for RecoveryOptions::healthy.
    [[nodiscard]] bool healthy() const { return state_ == RecoveryState::streaming && attempts_ == 0; }
    /// How often each rung was taken since the start, by RecoveryRung.
    [[nodiscard]] const std::array<std::uint64_t, kRecoveryRungCount>& counts() const { return counts_; }

  private:
    RecoveryAction enter(RecoveryState state, hal::TimePoint deadline);
    RecoveryAction open(hal::TimePoint now);
    RecoveryAction frame(hal::TimePoint now);
    RecoveryAction climb(RecoveryRung lowest, hal::TimePoint now);
    RecoveryAction take(hal::TimePoint now);
    RecoveryAction arrival(hal::TimePoint now);
    [[nodiscard]] RecoveryRung choose(RecoveryRung lowest, hal::TimePoint now);
    [[nodiscard]] bool allowed(RecoveryRung rung) const;
    void forget();

    RecoveryOptions options_;
    RecoveryState state_ = RecoveryState::closed;
    hal::TimePoint deadline_ = hal::TimePoint::max();
    hal::TimePoint streamingSince_{};
    hal::TimePoint lastGood_{};  ///< The last frame, or the start.
    RecoveryRung rung_ = RecoveryRung::retryRead;
    hal::TimePoint ownDoing_ = hal::TimePoint::min();  ///< Until then an arrival is what we did ourselves.
    std::size_t position_ = 0;                         ///< In the ladder: the next step to take.
    std::uint32_t attempts_ = 0;                       ///< Rungs taken since all was well.
    hal::Duration pause_{};                            ///< Before the next rung.
    std::array<std::uint64_t, kRecoveryRungCount> counts_{};
};

}  // namespace cheval::daemon

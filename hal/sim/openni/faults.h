// What is wrong with the simulated sensor at the moment.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

namespace cheval::hal::sim {

/// Calls of the driver that can be made to hang.
enum class HangingCall : std::uint8_t { none, open, close, read };

/// Thread-safe.
class Faults {
  public:
    /// "stall", "resume", "slow MS", "garbage", "lie", "sound", "busy", "free", "mode WxH", "hang open|close|read",
    /// "unhang". False: no such command. (plug and unplug are the driver's: they are events.)
    bool obey(std::string_view command);

    /// Returns when `call` may go on; a call that hangs waits here until unhang.
    void passThrough(HangingCall call);

    std::atomic<bool> plugged{true};
    std::atomic<bool> stalled{false};
    std::atomic<bool> garbage{false};  ///< Frames are noise.
    std::atomic<bool> lying{false};    ///< Frames say that they are larger than they are.
    std::atomic<bool> busy{false};     ///< Opening fails, as when another process holds the sensor.
    std::atomic<int> slowMs{0};
    std::atomic<int> shrink{1};  ///< The only mode that is offered is 640×480 divided by this.

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    HangingCall hanging_ = HangingCall::none;
};

}  // namespace cheval::hal::sim

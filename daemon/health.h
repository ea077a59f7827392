// How each part of the mirror is doing, and since when: for `chevalctl status`, the bus and the journal.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/mirror.h"
#include "hal/clock.h"

namespace cheval::daemon {

/// From good to bad; "absent by design" is as good as "ok", and never looks like a fault.
enum class HealthState : std::uint8_t {
    ok,
    absent,    ///< Not there because nobody asked for it.
    degraded,  ///< Works, but less well than it should.
    fault,     ///< Does not work; somebody must come, or the mirror is still trying.
};

/// "ok", "absent by design", "degraded", "at fault".
std::string_view name(HealthState state);

using WallTime = std::chrono::system_clock::time_point;

/// One part's health.
struct PartHealth {
    std::string_view part;  ///< "sensor", "display", "buttons", "wardrobe", "settings", "loop" or "bus".
    HealthState state = HealthState::ok;
    std::string reason;      ///< For people, with a mend where there is one; empty where there is nothing to say.
    hal::TimePoint since{};  ///< When state and reason became what they are, on the program's clock …
    WallTime sinceWall;      ///< … and by the calendar, as it stood then.
};

/// What is judged. Texts are for people already.
struct HealthInput {
    MirrorStatus mirror;
    double framesPerSecond = 30.0;      ///< As the settings ask for.
    bool sensorKeepsTime = true;        ///< False: a recording, which may have any number of frames a second.
    bool haveDisplay = true;            ///< False: headless on purpose.
    bool haveButtons = true;            ///< False: none are configured.
    bool haveBody = true;               ///< A mannequin was loaded.
    std::size_t outfits = 1;            ///< Loaded.
    std::vector<std::string> refusals;  ///< Of the wardrobe.
    std::string settingsProblem;        ///< Empty: the settings are good.
    bool busWanted = true;              ///< False: bus.kind is "none".
    std::string busProblem;             ///< Why nobody can ask the mirror anything; empty: they can.
};

/// Judges, and remembers since when. Thread-bound.
class HealthBoard {
  public:
    using WallClock = std::function<WallTime()>;
    /// The loop and the renderer hang when they have not turned for this long; even without a sensor the one turns ten
    /// times a second and the other four.
    static constexpr hal::Duration kHangs = std::chrono::seconds(3);
    /// Fewer pictures, or frames of the sensor, than asked for must last this long to count.
    static constexpr hal::Duration kSlow = std::chrono::seconds(5);

    explicit HealthBoard(const hal::Clock& clock, WallClock wall = std::chrono::system_clock::now);

    /// The list, always of the same parts in the same order; call it about twice a second.
    const std::vector<PartHealth>& update(const HealthInput& input);
    [[nodiscard]] const std::vector<PartHealth>& parts() const { return parts_; }

  private:
    struct Verdict {
        HealthState state = HealthState::ok;
        std::string reason;
    };

    /// A count that should rise.
    struct Pulse {
        std::uint64_t count = 0;
        std::optional<hal::TimePoint> moved;
        /// Any other count is a move: a mirror that is lit anew counts from zero.
        bool standsStill(std::uint64_t now, hal::TimePoint time);
    };

    /// Something that is slower than it should be. Once it counts, it must become clearly better to count no more.
    struct Slowness {
        std::optional<hal::TimePoint> since;
        bool slow = false;
        /// `share` of what is due is reached; `judged`: there is something to judge.
        bool update(bool judged, double share, hal::TimePoint time);
    };

    static Verdict judgeView(fitting::ViewFault fault);
    Verdict judgeSensor(const HealthInput& input);
    Verdict judgeLoop(const HealthInput& input);
    Verdict judgeDisplay(const HealthInput& input);
    void tell(std::string_view part, Verdict verdict);

    const hal::Clock& clock_;
    WallClock wall_;
    std::vector<PartHealth> parts_;
    Pulse turns_;
    Pulse pictures_;
    Slowness pictureRate_;
    Slowness sensorRate_;
};

/// The worst of the parts; ok where there are only parts that are ok or absent by design.
HealthState overall(const std::vector<PartHealth>& parts);

}  // namespace cheval::daemon

#include "daemon/recovery.h"

#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace cheval::daemon {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr std::array kAllStates = {RecoveryState::closed,    RecoveryState::opening,  RecoveryState::unproven,
                                   RecoveryState::streaming, RecoveryState::doubtful, RecoveryState::resting,
                                   RecoveryState::ended};
constexpr std::array kAllEvents = {RecoveryEvent::begin,   RecoveryEvent::opened, RecoveryEvent::prepared,
                                   RecoveryEvent::refused, RecoveryEvent::frame,  RecoveryEvent::lost,
                                   RecoveryEvent::arrived, RecoveryEvent::timer,  RecoveryEvent::ended};

/// A machine with its clock, driven by words: an event's name, or "3s"/"500ms" to let time pass with timers fired as
/// they come due.
class Driver {
  public:
    explicit Driver(const RecoveryOptions& options = {}) : machine_(options) {}

    void tell(RecoveryEvent event) { note(machine_.on(event, now_)); }
    /// Lets time pass; timers fire when they are due, and what they ask for is refused, as by a sensor that is gone,
    /// or opened, as by one that is silent.
    void pass(hal::Duration duration, RecoveryEvent answer) {
        const hal::TimePoint end = now_ + duration;
        while (machine_.deadline() <= end) {
            now_ = std::max(now_, machine_.deadline());
            const RecoveryAction action = machine_.on(RecoveryEvent::timer, now_);
            note(action);
            if (action != RecoveryAction::none) tell(answer);
        }
        now_ = end;
    }
    void framesFor(hal::Duration duration) {
        for (const hal::TimePoint end = now_ + duration; now_ < end; now_ += milliseconds(33))
            tell(RecoveryEvent::frame);
    }

    RecoveryMachine& machine() { return machine_; }
    [[nodiscard]] hal::TimePoint now() const { return now_; }
    /// What was done, e.g. "open stream device", and forgets it.
    std::string done() { return std::exchange(done_, std::string()); }

    void reach(RecoveryState state) {
        tell(RecoveryEvent::begin);
        if (state == RecoveryState::opening) return;
        if (state == RecoveryState::resting) return tell(RecoveryEvent::refused);
        if (state == RecoveryState::ended) return tell(RecoveryEvent::ended);
        tell(RecoveryEvent::opened);
        if (state == RecoveryState::unproven) return;
        framesFor(seconds(4));
        if (state == RecoveryState::streaming) return;
        now_ = machine_.deadline();
        tell(RecoveryEvent::timer);
    }

  private:
    void note(RecoveryAction action) {
        if (action == RecoveryAction::none) return;
        if (!done_.empty()) done_ += ' ';
        done_ += action == RecoveryAction::open ? "open" : std::string(name(machine_.rung()));
    }

    RecoveryMachine machine_;
    hal::TimePoint now_{seconds(100)};
    std::string done_;
};

/// One cell of the table: what the machine does, and where it is then.
std::string cell(RecoveryState state, RecoveryEvent event) {
    Driver driver;
    if (state != RecoveryState::closed) driver.reach(state);
    EXPECT_EQ(driver.machine().state(), state);
    driver.done();
    if (event == RecoveryEvent::timer) {
        if (driver.machine().deadline() == hal::TimePoint::max()) return "-";
        driver.pass(driver.machine().deadline() - driver.now(), RecoveryEvent::timer);
    } else {
        driver.tell(event);
    }
    std::string done = driver.done();
    return (done.empty() ? "" : done + " → ") + std::string(name(driver.machine().state()));
}

// The whole machine: a row an event, a column a state. A change of the machine changes this table, knowingly.
constexpr const char* kTable =
    R"(            closed          opening                   unproven                   streaming                  doubtful                   resting                    ended
begin       open → opening  opening                   unproven                   streaming                  doubtful                   resting                    ended
opened      closed          unproven                  unproven                   streaming                  doubtful                   resting                    ended
prepared    closed          opening                   unproven                   streaming                  doubtful                   resting                    ended
refused     closed          resting                   unproven                   streaming                  doubtful                   resting                    ended
frame       streaming       streaming                 streaming                  streaming                  streaming                  streaming                  ended
lost        device → opening resting           resting                    device → opening    device → opening    resting                    ended
arrived     closed          opening                   unproven                   streaming                  doubtful                   device → opening    ended
timer       -               resting                   resting                    doubtful                   stream → opening   device → opening    -
ended       ended           ended                     ended                      ended                      ended                      ended                      ended
)";

/// Runs of two and more blanks are one column's end.
std::string squeezed(const std::string& text) {
    std::string out;
    for (const char letter : text) {
        if (letter == ' ' && !out.empty() && (out.back() == ' ' || out.back() == '\n')) continue;
        out += letter;
    }
    return out;
}

TEST(RecoveryMachine, doesThisForEachEventInEachState) {
    std::ostringstream table;
    for (const RecoveryState state : kAllStates)
        table << ' ' << name(state);
    table << '\n';
    for (const RecoveryEvent event : kAllEvents) {
        table << name(event);
        for (const RecoveryState state : kAllStates)
            table << ' ' << cell(state, event);
        table << '\n';
    }
    EXPECT_EQ(squeezed(table.str()), squeezed(kTable));
    std::puts(kTable);
}

/// A chain of events, and what is done about them.
struct Chain {
    const char* name;
    std::function<void(Driver&)> happens;
    const char* done;
};
void PrintTo(const Chain& chain, std::ostream* out) {
    *out << chain.name;
}
class RecoveryChain : public testing::TestWithParam<Chain> {};

TEST_P(RecoveryChain, isExactlyThis) {
    RecoveryOptions options{.highest = RecoveryRung::reboot,
                            .available = [](RecoveryRung rung) { return rung != RecoveryRung::reboot; }};
    Driver driver(options);
    driver.reach(RecoveryState::streaming);
    driver.done();
    GetParam().happens(driver);
    EXPECT_EQ(driver.done(), GetParam().done);
}

INSTANTIATE_TEST_SUITE_P(Recovery, RecoveryChain,
                         testing::Values(Chain{"aLateFrameIsWaitedFor",
                                               [](Driver& driver) {
                                                   driver.pass(milliseconds(900), RecoveryEvent::opened);
                                                   driver.framesFor(seconds(1));
                                               },
                                               ""},
                                         Chain{"silenceClimbsFromTheStreamUp",
                                               [](Driver& driver) { driver.pass(minutes(1), RecoveryEvent::opened); },
                                               "stream device device process process usb power"},
                                         Chain{"aLossBeginsWithTheDevice",
                                               [](Driver& driver) {
                                                   driver.tell(RecoveryEvent::lost);
                                                   driver.tell(RecoveryEvent::refused);
                                                   driver.pass(seconds(10), RecoveryEvent::refused);
                                               },
                                               "device device process process usb"},
                                         Chain{"aHangingOpeningIsRecycled",
                                               [](Driver& driver) {
                                                   driver.tell(RecoveryEvent::lost);
                                                   driver.pass(seconds(20), RecoveryEvent::timer);
                                               },
                                               "device process"},
                                         Chain{"framesEndIt",
                                               [](Driver& driver) {
                                                   driver.tell(RecoveryEvent::lost);
                                                   driver.tell(RecoveryEvent::opened);
                                                   driver.framesFor(seconds(60));
                                               },
                                               "device"},
                                         Chain{"whatWasPluggedInIsOpenedAtOnce",
                                               [](Driver& driver) {
                                                   driver.tell(RecoveryEvent::lost);
                                                   driver.tell(RecoveryEvent::refused);
                                                   driver.pass(milliseconds(100), RecoveryEvent::refused);
                                                   driver.tell(RecoveryEvent::arrived);
                                               },
                                               "device device"}),
                         [](const testing::TestParamInfo<Chain>& test) { return test.param.name; });

TEST(RecoveryMachine, backsOffUpToABoundAndAnArrivalResetsIt) {
    Driver driver;
    driver.reach(RecoveryState::streaming);
    driver.tell(RecoveryEvent::lost);
    driver.tell(RecoveryEvent::refused);
    std::vector<double> pauses;
    for (int i = 0; i < 10; ++i) {
        ASSERT_EQ(driver.machine().state(), RecoveryState::resting);
        const hal::Duration pause = driver.machine().deadline() - driver.now();
        pauses.push_back(hal::seconds(pause));
        driver.pass(pause, RecoveryEvent::refused);
    }
    EXPECT_EQ(pauses, (std::vector<double>{0.5, 1, 2, 4, 8, 16, 30, 30, 30, 30}));
    driver.tell(RecoveryEvent::arrived);
    driver.tell(RecoveryEvent::refused);
    EXPECT_EQ(driver.machine().deadline() - driver.now(), milliseconds(500));
}

TEST(RecoveryMachine, anArrivalOfItsOwnMakingDoesNotBeginTheLadderAnew) {
    RecoveryOptions options{.highest = RecoveryRung::powerCycle, .available = [](RecoveryRung) { return true; }};
    Driver driver(options);
    driver.reach(RecoveryState::streaming);
    const auto taken = [&](RecoveryRung rung) { return driver.machine().counts()[static_cast<std::size_t>(rung)]; };
    while (taken(RecoveryRung::resetUsb) == 0)
        driver.pass(milliseconds(100), RecoveryEvent::opened);
    // The reset brings the device back onto the bus, and it stays silent.
    driver.tell(RecoveryEvent::prepared);
    driver.tell(RecoveryEvent::arrived);
    driver.tell(RecoveryEvent::opened);
    driver.pass(minutes(1), RecoveryEvent::opened);
    EXPECT_GE(taken(RecoveryRung::powerCycle), 1U);
    EXPECT_EQ(taken(RecoveryRung::restartStream), 1U);
}

TEST(RecoveryMachine, aRestartThatIsRefusedLeavesTheOtherRungsTheirTurn) {
    Driver driver({.highest = RecoveryRung::restartDaemon, .available = [](RecoveryRung) { return true; }});
    driver.reach(RecoveryState::streaming);
    driver.pass(minutes(40), RecoveryEvent::refused);
    const auto& counts = driver.machine().counts();
    EXPECT_GE(counts[static_cast<std::size_t>(RecoveryRung::restartDaemon)], 1U);
    EXPECT_LE(counts[static_cast<std::size_t>(RecoveryRung::restartDaemon)], 3U);
    EXPECT_GT(counts[static_cast<std::size_t>(RecoveryRung::recycle)], 10U);
}

TEST(RecoveryMachine, aSensorThatDiesAfterEachFrameIsNotReopenedWithoutPause) {
    Driver driver;
    driver.reach(RecoveryState::streaming);
    int tries = 0;
    const hal::TimePoint end = driver.now() + minutes(5);
    while (driver.now() < end) {
        driver.tell(RecoveryEvent::frame);
        driver.tell(RecoveryEvent::lost);
        if (driver.machine().state() == RecoveryState::resting)
            driver.pass(driver.machine().deadline() - driver.now(), RecoveryEvent::opened);
        else
            driver.tell(RecoveryEvent::opened);
        ++tries;
    }
    EXPECT_LT(tries, 20);
}

TEST(RecoveryMachine, neverGoesAboveTheHighestRungNorTakesWhatIsNotThere) {
    for (int highest = 0; highest < static_cast<int>(kRecoveryRungCount); ++highest) {
        RecoveryOptions options{.highest = static_cast<RecoveryRung>(highest),
                                .available = [](RecoveryRung rung) { return rung == RecoveryRung::powerCycle; }};
        Driver driver(options);
        driver.reach(RecoveryState::streaming);
        driver.pass(minutes(60), RecoveryEvent::refused);
        for (std::size_t rung = 0; rung < kRecoveryRungCount; ++rung) {
            const bool mayBe =
                static_cast<int>(rung) <= highest && (rung <= static_cast<std::size_t>(RecoveryRung::recycle) ||
                                                      rung == static_cast<std::size_t>(RecoveryRung::powerCycle));
            if (!mayBe && highest >= static_cast<int>(RecoveryRung::reopenDevice)) {
                EXPECT_EQ(driver.machine().counts()[rung], 0U)
                    << name(static_cast<RecoveryRung>(rung)) << " with " << highest;
            }
        }
    }
}

TEST(RecoveryMachine, restartsTheDaemonAfterAQuarterOfAnHourAndRebootsWhenThatWasTriedThreeTimes) {
    for (const std::uint32_t restarts : {0U, 2U, 3U}) {
        Driver driver({.restartsBefore = restarts, .highest = RecoveryRung::reboot, .available = [](RecoveryRung) {
                           return true;
                       }});
        driver.reach(RecoveryState::streaming);
        driver.pass(minutes(14), RecoveryEvent::refused);
        EXPECT_EQ(driver.machine().counts()[static_cast<std::size_t>(RecoveryRung::restartDaemon)], 0U);
        driver.pass(minutes(2), RecoveryEvent::refused);
        const bool reboots = restarts >= 3;
        EXPECT_EQ(driver.machine().counts()[static_cast<std::size_t>(RecoveryRung::reboot)] > 0, reboots);
        EXPECT_EQ(driver.machine().counts()[static_cast<std::size_t>(RecoveryRung::restartDaemon)] > 0, !reboots);
    }
}

TEST(RecoveryMachine, aRecordingsGapIsNoFault) {
    Driver driver({.silence = std::nullopt});
    driver.tell(RecoveryEvent::begin);
    driver.tell(RecoveryEvent::opened);
    EXPECT_EQ(driver.machine().deadline(), hal::TimePoint::max());
    driver.tell(RecoveryEvent::frame);
    EXPECT_EQ(driver.machine().deadline(), hal::TimePoint::max());
}

TEST(RecoveryMachine, countsEveryRungAndTakesNoMemory) {
    Driver driver;
    driver.reach(RecoveryState::streaming);
    const cheval::test::AllocationCounter counter;
    std::mt19937 random(5);  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same on every run.
    RecoveryMachine& machine = driver.machine();
    hal::TimePoint now = driver.now();
    std::array<std::uint64_t, kRecoveryRungCount> counted = machine.counts();
    for (int i = 0; i < 20'000; ++i) {
        now += milliseconds(random() % 700);
        const auto event = kAllEvents[random() % (kAllEvents.size() - 1)];
        const RecoveryState before = machine.state();
        const RecoveryAction action = machine.on(event, now);
        if (action == RecoveryAction::perform) ++counted[static_cast<std::size_t>(machine.rung())];
        if (before == RecoveryState::streaming && machine.state() == RecoveryState::doubtful) ++counted[0];
        ASSERT_NE(machine.state(), RecoveryState::ended);
    }
    EXPECT_EQ(counter.count(), 0U);
    EXPECT_EQ(counted, machine.counts());
}

}  // namespace
}  // namespace cheval::daemon

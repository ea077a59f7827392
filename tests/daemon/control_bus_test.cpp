#include "daemon/control_bus.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/mirror_client.h"
#include "daemon/mirror_interface.h"
#include "tests/daemon/private_bus.h"

namespace cheval::daemon {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::HasSubstr;
using Kind = RemoteCommand::Kind;

constexpr config::BusKind kSession = config::BusKind::session;

class ControlBusTest : public testing::Test {
  protected:
    void SetUp() override { bus_.start(); }

    ControlBusOptions options() {
        return {.kind = kSession,
                .version = "1.2.3",
                .commands = commands_,
                .reload = [this] { ++reloads_; },
                .firstPause = milliseconds(20),
                .longestPause = milliseconds(100),
                .startLimit = std::chrono::seconds(30)};
    }
    std::unique_ptr<ControlBus> start() {
        Expected<std::unique_ptr<ControlBus>> control = ControlBus::start(options());
        EXPECT_TRUE(control) << control.error().message();
        return control ? std::move(*control) : nullptr;
    }
    static ControlSnapshot snapshot() {
        ControlSnapshot snapshot{
            .outfits = {{.id = "tshirt", .name = "T-shirt"}, {.id = "tshirt+trousers", .name = "T-shirt + Trousers"}},
            .health = {{.part = "sensor", .state = HealthState::ok},
                       {.part = "buttons",
                        .state = HealthState::fault,
                        .reason = "caf\xE9\n",
                        .since = hal::TimePoint(std::chrono::seconds(5)),
                        .sinceWall = WallTime(std::chrono::seconds(1'000'000'000))}},
            .tasks = {{.name = "draw",
                       .budget = milliseconds(18),
                       .runs = 7,
                       .skips = 1,
                       .overruns = 2,
                       .mean = std::chrono::microseconds(1500)},
                      {.name = "renderer, whole frame", .runs = 7}},
            .recovery = {{"reopen device", 3}},
            .renderer = "a renderer"};
        snapshot.mirror.state = SessionState::wearing;
        snapshot.mirror.outfitIndex = 1;
        snapshot.mirror.avatarView = true;
        snapshot.mirror.framesPerSecond = 29.5;
        snapshot.mirror.degradeLevel = 2;
        snapshot.mirror.degradeName = "half";
        snapshot.mirror.frames = 11;
        snapshot.mirror.pictures = 12;
        snapshot.mirror.visits = 13;
        return snapshot;
    }
    std::vector<RemoteCommand> taken() {
        std::array<RemoteCommand, RemoteCommands::kMaximumWaiting> room{};
        const std::size_t count = commands_->take(room);
        return {room.begin(), room.begin() + static_cast<std::ptrdiff_t>(count)};
    }
    /// The name of the error that this call comes back with; empty: none.
    template <typename... Arguments>
    static std::string refusal(const std::string& method, const char* interface, Arguments... arguments) {
        try {
            const auto connection = sdbus::createSessionBusConnection();
            const auto mirror = sdbus::createProxy(*connection, mirror1::kName, mirror1::kPath);
            mirror->callMethod(method).onInterface(interface).withArguments(std::move(arguments)...);
        } catch (const sdbus::Error& error) {
            return error.getName();
        }
        return {};
    }
    template <typename... Arguments>
    static std::string refusal(const std::string& method, Arguments... arguments) {
        return refusal(method, mirror1::kInterface, std::move(arguments)...);
    }

    PrivateBus bus_;
    std::shared_ptr<RemoteCommands> commands_ = std::make_shared<RemoteCommands>();
    std::atomic<int> reloads_{0};
};

TEST_F(ControlBusTest, TellsWhatWasPublished) {
    const auto control = start();
    EXPECT_EQ(control->problem(), "");
    control->publish(snapshot());
    const Expected<MirrorReport> report = askMirror(kSession);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->version, "1.2.3");
    EXPECT_EQ(report->state, "wearing");
    EXPECT_EQ(report->outfit, "tshirt+trousers");
    EXPECT_EQ(report->view, "avatar");
    ASSERT_EQ(report->outfits.size(), 2U);
    EXPECT_EQ(report->outfits[1].name, "T-shirt + Trousers");
    EXPECT_EQ(report->framesPerSecond, 29.5);
    EXPECT_EQ(report->degradeLevel, 2U);
    EXPECT_EQ(report->degradeName, "half");
    EXPECT_EQ(report->frames, 11U);
    EXPECT_EQ(report->pictures, 12U);
    EXPECT_EQ(report->visits, 13U);
    EXPECT_EQ(report->renderer, "a renderer");
    EXPECT_EQ(report->overall, "at fault");
    EXPECT_TRUE(report->atFault());
    ASSERT_EQ(report->health.size(), 2U);
    EXPECT_EQ(report->health[1].part, "buttons");
    EXPECT_EQ(report->health[1].state, "at fault");
    EXPECT_EQ(report->health[1].reason, "caf\xEF\xBF\xBD\xEF\xBF\xBD") << "a bus takes UTF-8 alone";
    EXPECT_EQ(report->health[1].since, WallTime(std::chrono::seconds(1'000'000'000)));
    ASSERT_EQ(report->tasks.size(), 2U);
    EXPECT_EQ(report->tasks[0].name, "draw");
    EXPECT_EQ(report->tasks[0].budget, milliseconds(18));
    EXPECT_EQ(report->tasks[0].mean, std::chrono::microseconds(1500));
    EXPECT_EQ(report->tasks[0].runs, 7U);
    EXPECT_EQ(report->tasks[0].overruns, 2U);
    EXPECT_EQ(report->tasks[0].skips, 1U);
    EXPECT_FALSE(report->tasks[0].wholeFrame);
    EXPECT_TRUE(report->tasks[1].wholeFrame);
    EXPECT_THAT(report->recovery, testing::ElementsAre(std::pair<std::string, std::uint64_t>("reopen device", 3)));
}

TEST_F(ControlBusTest, BeforeTheMirrorIsLitItIsStartingAndKnowsNoOutfit) {
    const auto control = start();
    const Expected<MirrorReport> report = askMirror(kSession);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->state, "starting");
    EXPECT_TRUE(report->outfits.empty());
    EXPECT_EQ(refusal("SetOutfit", std::string("tshirt")), mirror1::kNotReady);
}

TEST_F(ControlBusTest, WishesReachTheLoopInTheirOrder) {
    const auto control = start();
    control->publish(snapshot());
    EXPECT_TRUE(tellMirror(kSession, "NextOutfit"));
    EXPECT_TRUE(tellMirror(kSession, "SetOutfit", "tshirt+trousers"));
    EXPECT_TRUE(tellMirror(kSession, "SetOutfit", "T-shirt"));
    EXPECT_TRUE(tellMirror(kSession, "PreviousOutfit"));
    EXPECT_TRUE(tellMirror(kSession, "SetView", "avatar"));
    EXPECT_TRUE(tellMirror(kSession, "SetView", "mirror"));
    std::vector<std::pair<Kind, std::size_t>> got;
    for (const RemoteCommand& command : taken())
        got.emplace_back(command.kind, command.outfit);
    EXPECT_THAT(got, testing::ElementsAre(std::pair(Kind::next, 0U), std::pair(Kind::choose, 1U),
                                          std::pair(Kind::choose, 0U), std::pair(Kind::previous, 0U),
                                          std::pair(Kind::avatarView, 0U), std::pair(Kind::mirrorView, 0U)));
    EXPECT_TRUE(tellMirror(kSession, "Reload"));
    EXPECT_EQ(reloads_, 1);
}

TEST_F(ControlBusTest, AnUnknownOutfitIsRefusedWithThoseThereAre) {
    const auto control = start();
    control->publish(snapshot());
    const Expected<void> told = tellMirror(kSession, "SetOutfit", "cape");
    ASSERT_FALSE(told);
    EXPECT_EQ(told.error().code, ErrorCode::notFound);
    EXPECT_THAT(told.error().message(), AllOf(HasSubstr("\"cape\""), HasSubstr("tshirt, tshirt+trousers")));
    EXPECT_EQ(refusal("SetOutfit", std::string("cape")), mirror1::kUnknownOutfit);
    EXPECT_EQ(refusal("SetView", std::string("inside out")), mirror1::kUnknownView);
    EXPECT_TRUE(taken().empty());
}

TEST_F(ControlBusTest, CallsThatAreWrongAreRefusedAndItLivesOn) {
    const auto control = start();
    control->publish(snapshot());
    const std::string prefix = "org.freedesktop.DBus.Error.";
    EXPECT_EQ(refusal("SetOutfit", std::int32_t{7}), prefix + "InvalidArgs");
    EXPECT_EQ(refusal("SetOutfit"), prefix + "InvalidArgs");
    EXPECT_EQ(refusal("NextOutfit", std::string("twice")), prefix + "InvalidArgs");
    EXPECT_EQ(refusal("Explode"), prefix + "UnknownMethod");
    const char* properties = "org.freedesktop.DBus.Properties";
    EXPECT_EQ(refusal("Set", properties, std::string(mirror1::kInterface), std::string("State"),
                      sdbus::Variant(std::string("wearing"))),
              prefix + "PropertyReadOnly");
    EXPECT_EQ(refusal("Get", properties, std::string(mirror1::kInterface), std::string("Colour")),
              prefix + "UnknownProperty");
    EXPECT_EQ(refusal("SetOutfit", std::string(1'000'000, 'x')), mirror1::kUnknownOutfit);
    EXPECT_TRUE(taken().empty());
    EXPECT_TRUE(askMirror(kSession));
}

TEST_F(ControlBusTest, AFloodIsBoundedToldAndSurvived) {
    const auto control = start();
    control->publish(snapshot());
    constexpr int kCalls = 1000;
    const auto connection = sdbus::createSessionBusConnection();
    const auto mirror = sdbus::createProxy(*connection, mirror1::kName, mirror1::kPath);
    int done = 0;
    int busy = 0;
    for (int i = 0; i < kCalls; ++i) {
        mirror->callMethodAsync("NextOutfit")
            .onInterface(mirror1::kInterface)
            .uponReplyInvoke([&](const sdbus::Error* error) {
                ++done;
                if (error != nullptr && error->getName() == mirror1::kBusy) ++busy;
            });
    }
    EXPECT_TRUE(eventually([&] {
        while (connection->processPendingRequest()) {
        }
        return done == kCalls;
    }));
    // Nobody took them meanwhile, so that just those that there was room for were taken.
    EXPECT_EQ(busy, kCalls - static_cast<int>(RemoteCommands::kMaximumWaiting));
    EXPECT_EQ(taken().size(), RemoteCommands::kMaximumWaiting);
    EXPECT_TRUE(tellMirror(kSession, "NextOutfit"));
}

TEST_F(ControlBusTest, TellsChangesOfStateOutfitAndHealthAndAtMostTwiceASecond) {
    const auto control = start();
    ControlSnapshot now = snapshot();
    control->publish(now);
    const auto listener = sdbus::createSessionBusConnection();
    const auto mirror = sdbus::createProxy(*listener, mirror1::kName, mirror1::kPath);
    std::set<std::string> names;
    int signals = 0;
    mirror->uponSignal("PropertiesChanged")
        .onInterface("org.freedesktop.DBus.Properties")
        .call([&](const std::string&, const std::map<std::string, sdbus::Variant>& changed,
                  const std::vector<std::string>&) {
            ++signals;
            for (const auto& [name, value] : changed)
                names.insert(name);
        });
    mirror->finishRegistration();
    const hal::SteadyClock clock;
    const hal::TimePoint began = clock.now();
    int published = 0;
    const auto step = [&] {
        while (listener->processPendingRequest()) {
        }
        ++published;
        now.mirror.frames += 1;
        now.mirror.outfitIndex ^= 1U;
        now.mirror.state = published % 2 == 0 ? SessionState::idle : SessionState::wearing;
        now.health[1].state = published % 4 < 2 ? HealthState::fault : HealthState::ok;
        control->publish(now);
        return signals >= 3;
    };
    EXPECT_TRUE(eventually(step));
    EXPECT_GE(hal::seconds(clock.now() - began), 2 * 0.5 - 0.11) << "three signals need two pauses";
    EXPECT_THAT(names, testing::IsSubsetOf({"State", "Outfit", "Health", "Overall"}));

    // Frames alone are no news.
    const int before = signals;
    const hal::TimePoint quietSince = clock.now();
    EXPECT_TRUE(eventually([&] {
        while (listener->processPendingRequest()) {
        }
        ++now.mirror.frames;
        control->publish(now);
        return clock.now() - quietSince > milliseconds(1300);
    }));
    EXPECT_LE(signals, before + 1) << "one may still be due for the last change";
}

TEST_F(ControlBusTest, ABusThatGoesAndComesIsReachedAgain) {
    const auto control = start();
    control->publish(snapshot());
    for (int round = 0; round < 3; ++round) {
        bus_.end();
        EXPECT_TRUE(eventually([&] { return !control->problem().empty(); }));
        EXPECT_THAT(control->problem(), AllOf(HasSubstr("session bus"), HasSubstr("Mend: ")));
        const Expected<MirrorReport> none = askMirror(kSession);
        ASSERT_FALSE(none);
        EXPECT_EQ(none.error().code, ErrorCode::unavailable);
        bus_.start();
        EXPECT_TRUE(eventually([&] { return control->problem().empty(); }));
        const Expected<MirrorReport> report = askMirror(kSession);
        ASSERT_TRUE(report) << report.error().message();
        EXPECT_EQ(report->state, "wearing") << "what was published before is still told";
    }
}

TEST_F(ControlBusTest, ABusThatIsNotThereYetIsNoErrorAndIsFoundLater) {
    bus_.end();
    const auto control = start();
    EXPECT_THAT(control->problem(), HasSubstr("cannot be reached"));
    bus_.start();
    EXPECT_TRUE(eventually([&] { return control->problem().empty(); }));
    EXPECT_TRUE(askMirror(kSession));
}

TEST_F(ControlBusTest, ASecondMirrorIsRefusedAndTheFirstIsNotReplaced) {
    auto first = start();
    first->publish(snapshot());
    const Expected<std::unique_ptr<ControlBus>> second = ControlBus::start(options());
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::conflict);
    EXPECT_THAT(second.error().message(), AllOf(HasSubstr("another mirror owns"), HasSubstr("Mend: ")));
    const Expected<MirrorReport> report = askMirror(kSession);
    ASSERT_TRUE(report) << report.error().message();
    EXPECT_EQ(report->state, "wearing");
    first.reset();
    EXPECT_NE(start(), nullptr);
}

TEST_F(ControlBusTest, ABusThatHangsHoldsNobody) {
    const auto reached = start();
    bus_.signal(SIGSTOP);
    ControlBusOptions hasty = options();
    hasty.startLimit = milliseconds(100);
    // Both would wait for a minute and a half.
    Expected<std::unique_ptr<ControlBus>> control = ControlBus::start(hasty);
    ASSERT_TRUE(control) << control.error().message();
    EXPECT_THAT((*control)->problem(), HasSubstr("has not answered yet"));
    reached->publish(snapshot());
    control->reset();
    bus_.signal(SIGCONT);
    EXPECT_TRUE(askMirror(kSession));
}

TEST_F(ControlBusTest, WithoutABusNothingIsDoneAndNothingIsWrong) {
    ControlBusOptions none = options();
    none.kind = config::BusKind::none;
    const Expected<std::unique_ptr<ControlBus>> control = ControlBus::start(none);
    ASSERT_TRUE(control);
    (*control)->publish(snapshot());
    EXPECT_EQ((*control)->problem(), "");
    const Expected<MirrorReport> report = askMirror(kSession);
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().message(), HasSubstr("no mirror is running on the session bus"));
}

TEST(RemoteCommandsTest, RefusesWhatThereIsNoRoomForAndKeepsTheRest) {
    RemoteCommands commands;
    for (std::size_t i = 0; i < RemoteCommands::kMaximumWaiting; ++i)
        EXPECT_TRUE(commands.push({.kind = Kind::choose, .outfit = i}));
    EXPECT_FALSE(commands.push({}));
    std::array<RemoteCommand, RemoteCommands::kMaximumWaiting> room{};
    ASSERT_EQ(commands.take(room), room.size());
    for (std::size_t i = 0; i < room.size(); ++i)
        EXPECT_EQ(room[i].outfit, i);
    EXPECT_EQ(commands.take(room), 0U);
    EXPECT_TRUE(commands.push({}));
    commands.clear();
    EXPECT_EQ(commands.take(room), 0U);
}

}  // namespace
}  // namespace cheval::daemon

#include "daemon/health.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/degrade_ladder.h"

namespace cheval::daemon {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

/// A mirror where all is well, on virtual time; the calendar says noon when the clock says zero.
class HealthTest : public testing::Test {
  protected:
    static constexpr WallTime kNoon{std::chrono::hours(12)};

    HealthTest() : board_(clock_, [this] { return wallNow_ + (clock_.now() - hal::TimePoint{}); }) {
        input_.mirror.camera = CameraState::streaming;
        input_.mirror.framesPerSecond = 30.0;
        input_.mirror.pictures = 1;
    }

    const PartHealth& part(std::string_view name) {
        turn();
        for (const PartHealth& row : board_.parts()) {
            if (row.part == name) return row;
        }
        ADD_FAILURE() << "there is no part " << name;
        return board_.parts().front();
    }
    void turn() {
        ++input_.mirror.turns;
        ++input_.mirror.pictures;
        board_.update(input_);
    }
    /// Time passes with the loop turning.
    void pass(hal::Duration duration) {
        for (hal::Duration done{}; done < duration; done += milliseconds(500)) {
            clock_.advance(milliseconds(500));
            turn();
        }
    }

    hal::VirtualClock clock_;
    WallTime wallNow_ = kNoon;
    HealthInput input_;
    HealthBoard board_;
};

TEST_F(HealthTest, ASensorThatCanShowNobodySaysWhyAndHowToMendIt) {
    const std::pair<fitting::ViewFault, std::string> cases[] = {
        {fitting::ViewFault::noReadings, "hardly a pixel"},
        {fitting::ViewFault::covered, "fills the sensor's view"},
        {fitting::ViewFault::upsideDown, "upside down"},
        {fitting::ViewFault::floorElsewhere, "does not lie where sensor.height_mm"}};
    for (const auto& [fault, words] : cases) {
        input_.mirror.viewFault = fault;
        EXPECT_EQ(part("sensor").state, HealthState::degraded);
        EXPECT_THAT(part("sensor").reason, HasSubstr(words));
        EXPECT_THAT(part("sensor").reason, HasSubstr("Mend: "));
    }
    input_.mirror.viewFault = fitting::ViewFault::none;
    EXPECT_EQ(part("sensor").state, HealthState::ok);
}

TEST_F(HealthTest, AllPartsAreListedInTheSameOrderAndWell) {
    turn();
    std::vector<std::string_view> names;
    for (const PartHealth& row : board_.parts()) {
        names.push_back(row.part);
        EXPECT_EQ(row.state, HealthState::ok) << row.part;
        EXPECT_EQ(row.reason, "") << row.part;
    }
    EXPECT_THAT(names, testing::ElementsAre("sensor", "display", "buttons", "wardrobe", "settings", "loop", "bus"));
    EXPECT_EQ(overall(board_.parts()), HealthState::ok);
}

struct Case {
    std::string name;
    std::string_view part;
    std::function<void(HealthInput&)> happens;
    HealthState state;
    std::string reason;  ///< Part of it.
    HealthState all;
};

class HealthCases : public HealthTest, public testing::WithParamInterface<Case> {};

TEST_P(HealthCases, AreTold) {
    turn();
    GetParam().happens(input_);
    const PartHealth& row = part(GetParam().part);
    EXPECT_EQ(row.state, GetParam().state);
    EXPECT_THAT(row.reason, HasSubstr(GetParam().reason));
    EXPECT_EQ(overall(board_.parts()), GetParam().all);
    for (const PartHealth& other : board_.parts()) {
        if (other.part != GetParam().part) {
            EXPECT_EQ(other.state, HealthState::ok) << other.part;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Table, HealthCases,
    testing::Values(
        Case{"SensorThatHasNotYetSentIsDegraded", "sensor",
             [](HealthInput& input) { input.mirror.camera = CameraState::waiting; }, HealthState::degraded,
             "waiting for its first frame", HealthState::degraded},
        Case{"LostSensorIsAtFaultWithItsReason", "sensor",
             [](HealthInput& input) {
                 input.mirror.camera = CameraState::lost;
                 input.mirror.fault.assign("the camera \"x\" is gone. Mend: check its cable");
             },
             HealthState::fault, "is gone. Mend: check its cable", HealthState::fault},
        Case{"SensorOpenedAgainIsAtFaultUntilItsFirstFrame", "sensor",
             [](HealthInput& input) {
                 input.mirror.camera = CameraState::waiting;
                 input.mirror.fault.assign("the camera \"x\" is gone");
             },
             HealthState::fault, "is gone", HealthState::fault},
        Case{"RecordingThatIsOverIsNoFault", "sensor",
             [](HealthInput& input) {
                 input.mirror.camera = CameraState::ended;
                 input.mirror.fault.assign("the recording \"x\" is over");
             },
             HealthState::degraded, "is over", HealthState::degraded},
        Case{"HeadlessIsAbsentByDesignAndAllIsWell", "display", [](HealthInput& input) { input.haveDisplay = false; },
             HealthState::absent, "headless", HealthState::ok},
        Case{"DisplayThatShowsNothingIsAtFaultEvenHeadless", "display",
             [](HealthInput& input) {
                 input.haveDisplay = false;
                 input.mirror.displayFault.assign("the display lends no buffer");
             },
             HealthState::fault, "lends no buffer", HealthState::fault},
        Case{"NoButtonsAreAbsentByDesignAndAllIsWell", "buttons", [](HealthInput& input) { input.haveButtons = false; },
             HealthState::absent, "none are configured", HealthState::ok},
        Case{"ButtonsThatCannotBeReadAreAtFault", "buttons",
             [](HealthInput& input) { input.mirror.buttonsFault.assign("the chip is gone"); }, HealthState::fault,
             "the chip is gone", HealthState::fault},
        Case{"RefusedGarmentsDegradeTheWardrobe", "wardrobe",
             [](HealthInput& input) {
                 input.refusals = {"a.glb: no cage", "b.glb: no skin"};
             },
             HealthState::degraded, "a.glb: no cage  |  b.glb: no skin", HealthState::degraded},
        Case{"NoMannequinIsAFault", "wardrobe", [](HealthInput& input) { input.haveBody = false; }, HealthState::fault,
             "nobody can be dressed", HealthState::fault},
        Case{"NothingToWearIsAFaultWithTheRefusals", "wardrobe",
             [](HealthInput& input) {
                 input.outfits = 0;
                 input.refusals = {"a.glb: no cage"};
             },
             HealthState::fault, "a.glb: no cage", HealthState::fault},
        Case{"RefusedSettingsAreDegraded", "settings",
             [](HealthInput& input) { input.settingsProblem = "cheval.toml:3: loop.fsp: unknown"; },
             HealthState::degraded, "loop.fsp", HealthState::degraded},
        Case{"PlainerPicturesAreDegraded", "loop",
             [](HealthInput& input) {
                 input.mirror.degradeLevel = 1;
                 input.mirror.degradeName = "half the pixels";
             },
             HealthState::degraded, "half the pixels", HealthState::degraded},
        Case{"NoBusIsAbsentByDesign", "bus", [](HealthInput& input) { input.busWanted = false; }, HealthState::absent,
             "none", HealthState::ok},
        Case{"BusOutOfReachIsDegraded", "bus", [](HealthInput& input) { input.busProblem = "no bus there"; },
             HealthState::degraded, "no bus there", HealthState::degraded}),
    [](const testing::TestParamInfo<Case>& row) { return row.param.name; });

TEST_F(HealthTest, SinceStaysWhileStateAndReasonDo) {
    turn();
    clock_.advance(seconds(10));
    input_.mirror.camera = CameraState::lost;
    input_.mirror.fault.assign("the camera is gone");
    EXPECT_EQ(part("sensor").since, hal::TimePoint(seconds(10)));
    pass(seconds(60));
    EXPECT_EQ(part("sensor").since, hal::TimePoint(seconds(10)));
    EXPECT_EQ(part("sensor").sinceWall, kNoon + seconds(10));

    input_.mirror.fault.assign("the camera does not open");
    EXPECT_EQ(part("sensor").since, hal::TimePoint(seconds(70))) << "another reason is another story";
    pass(seconds(5));
    input_.mirror.camera = CameraState::streaming;
    input_.mirror.fault.assign("");
    EXPECT_EQ(part("sensor").since, hal::TimePoint(seconds(75)));
    EXPECT_EQ(part("sensor").state, HealthState::ok);
    EXPECT_EQ(part("wardrobe").since, hal::TimePoint{}) << "what did not change stays as old as it is";
}

TEST_F(HealthTest, ACalendarThatIsSetRightDoesNotMoveWhatWasWrittenDown) {
    turn();
    wallNow_ += std::chrono::hours(24);
    pass(seconds(5));
    EXPECT_EQ(part("sensor").sinceWall, kNoon);
}

TEST_F(HealthTest, ALoopThatDoesNotTurnIsAtFaultAndOneThatDoesIsNot) {
    turn();
    clock_.advance(HealthBoard::kHangs - milliseconds(1));
    ++input_.mirror.pictures;
    EXPECT_EQ(overall(board_.update(input_)), HealthState::ok);
    clock_.advance(milliseconds(1));
    ++input_.mirror.pictures;
    EXPECT_EQ(overall(board_.update(input_)), HealthState::fault);
    EXPECT_EQ(part("loop").state, HealthState::ok) << "it turned again";
}

TEST_F(HealthTest, APictureThatStandsStillIsAFaultOfTheDisplayEvenHeadless) {
    input_.haveDisplay = false;
    turn();
    clock_.advance(HealthBoard::kHangs);
    ++input_.mirror.turns;
    EXPECT_EQ(overall(board_.update(input_)), HealthState::fault);
    EXPECT_EQ(board_.parts()[1].part, "display");
    EXPECT_EQ(board_.parts()[1].state, HealthState::fault);
    EXPECT_THAT(board_.parts()[1].reason, HasSubstr("stands still"));
    EXPECT_EQ(part("display").state, HealthState::absent) << "it moves again";
}

TEST_F(HealthTest, AMirrorThatIsLitAnewDoesNotHang) {
    input_.mirror.turns = 5000;
    input_.mirror.pictures = 5000;
    turn();
    clock_.advance(HealthBoard::kHangs);
    input_.mirror.turns = 0;
    input_.mirror.pictures = 0;
    EXPECT_EQ(part("loop").state, HealthState::ok);
}

TEST_F(HealthTest, TooFewPicturesCountOnlyWhenTheyLastAndEndWithRoomToSpare) {
    turn();
    input_.mirror.framesPerSecond = 20.0;
    pass(HealthBoard::kSlow - seconds(1));
    EXPECT_EQ(part("loop").state, HealthState::ok);
    pass(seconds(2));
    EXPECT_EQ(part("loop").state, HealthState::degraded);
    const hal::TimePoint since = part("loop").since;
    input_.mirror.framesPerSecond = 25.0;  // 83 %: better, but not yet well.
    pass(seconds(2));
    EXPECT_EQ(part("loop").state, HealthState::degraded);
    EXPECT_EQ(part("loop").since, since) << "the figure is no part of the reason";
    input_.mirror.framesPerSecond = 28.0;
    EXPECT_EQ(part("loop").state, HealthState::ok);
}

TEST_F(HealthTest, ASlowSensorIsToldOfTheSensorAloneWhenItLastsAndUntilItIsClearlyBetter) {
    turn();
    input_.mirror.sensorFramesPerSecond = input_.mirror.framesPerSecond = 5.0;
    pass(HealthBoard::kSlow - seconds(1));
    EXPECT_EQ(part("sensor").state, HealthState::ok);
    pass(seconds(2));
    EXPECT_EQ(part("sensor").state, HealthState::degraded);
    for (const char* words : {"fewer pictures a second than loop.fps", "Mend: ", "Why: "})
        EXPECT_THAT(part("sensor").reason, HasSubstr(words));
    pass(seconds(60));
    EXPECT_EQ(part("loop").state, HealthState::ok) << "it shows all that there is";
    const hal::TimePoint since = part("sensor").since;
    input_.mirror.sensorFramesPerSecond = 25.0;  // 83 %: better, but not yet well.
    pass(seconds(10));
    EXPECT_EQ(part("sensor").state, HealthState::degraded);
    EXPECT_EQ(part("sensor").since, since) << "the figure is no part of the reason";
    input_.mirror.sensorFramesPerSecond = 29.0;
    EXPECT_EQ(part("sensor").state, HealthState::ok);
    input_.mirror.sensorFramesPerSecond = 25.0;
    pass(seconds(60));
    EXPECT_EQ(part("sensor").state, HealthState::ok) << "a little slow is no reason";
}

TEST_F(HealthTest, ALoopThatShowsLessThanASlowSensorTakesIsSlowItself) {
    turn();
    input_.mirror.sensorFramesPerSecond = 15.0;
    input_.mirror.framesPerSecond = 8.0;
    pass(HealthBoard::kSlow + seconds(1));
    EXPECT_EQ(part("sensor").state, HealthState::degraded);
    EXPECT_EQ(part("loop").state, HealthState::degraded);
}

TEST_F(HealthTest, ASlowSensorIsNoNewsWhileItIsNotKnownOrLostOrARecording) {
    input_.mirror.framesPerSecond = 5.0;
    input_.mirror.sensorFramesPerSecond = 0.0;
    pass(seconds(30));
    EXPECT_EQ(part("sensor").state, HealthState::ok) << "not known yet";
    input_.mirror.sensorFramesPerSecond = 5.0;
    input_.sensorKeepsTime = false;
    pass(seconds(30));
    EXPECT_EQ(part("sensor").state, HealthState::ok) << "a recording may be of any rate";
    input_.sensorKeepsTime = true;
    input_.mirror.camera = CameraState::lost;
    pass(seconds(30));
    EXPECT_THAT(part("sensor").reason, HasSubstr("no frames"));
}

TEST_F(HealthTest, AViewThatShowsNobodyIsToldBeforeASlowSensor) {
    turn();
    input_.mirror.sensorFramesPerSecond = 5.0;
    input_.mirror.viewFault = fitting::ViewFault::covered;
    pass(seconds(30));
    EXPECT_THAT(part("sensor").reason, HasSubstr("fills the sensor's view"));
    input_.mirror.viewFault = fitting::ViewFault::none;
    EXPECT_THAT(part("sensor").reason, HasSubstr("fewer pictures a second"));
}

TEST_F(HealthTest, WithoutASensorFourPicturesASecondAreRight) {
    input_.mirror.camera = CameraState::waiting;
    input_.mirror.framesPerSecond = 4.0;
    pass(seconds(30));
    EXPECT_EQ(part("loop").state, HealthState::ok);
}

TEST(HealthNames, AbsentByDesignAndAtFaultLookDifferent) {
    EXPECT_EQ(name(HealthState::ok), "ok");
    EXPECT_EQ(name(HealthState::absent), "absent by design");
    EXPECT_EQ(name(HealthState::degraded), "degraded");
    EXPECT_EQ(name(HealthState::fault), "at fault");
}

}  // namespace
}  // namespace cheval::daemon

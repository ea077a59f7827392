#include "daemon/status_line.h"

#include <chrono>

#include <gtest/gtest.h>

namespace cheval::daemon {
namespace {

MirrorStatus wearing() {
    MirrorStatus status;
    status.state = SessionState::wearing;
    status.outfit.assign("T-shirt");
    status.framesPerSecond = 29.94;
    status.loopTime = std::chrono::microseconds(8125);
    status.renderTime = std::chrono::milliseconds(12);
    return status;
}

TEST(StatusLine, SaysWhatIsWornAndHowFast) {
    EXPECT_EQ(statusLine(wearing()), "wearing: T-shirt  29.9 fps  loop 8.1 ms  render 12.0 ms  all details");
}

TEST(StatusLine, SaysThatTheMannequinIsShownAndThatThePictureIsPlainer) {
    MirrorStatus status = wearing();
    status.avatarView = true;
    status.degradeLevel = 2;
    status.degradeName = "half size";
    EXPECT_EQ(statusLine(status),
              "wearing: T-shirt (mannequin)  29.9 fps  loop 8.1 ms  render 12.0 ms  plainer: half size");
}

TEST(StatusLine, SaysWhyThereAreNoFramesAndNothingElse) {
    MirrorStatus status = wearing();
    status.fault.assign("the recording is over");
    EXPECT_EQ(statusLine(status), "no frames: the recording is over");
}

TEST(StatusLine, NamesNoOutfitWhereNothingIsWorn) {
    MirrorStatus status = wearing();
    status.state = SessionState::idle;
    EXPECT_EQ(statusLine(status).find("idle  29.9 fps"), 0U) << statusLine(status);
}

}  // namespace
}  // namespace cheval::daemon

#include "fitting/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "fitting/tracking/body_tracker.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/floor_watch.h"
#include "fitting/tracking/gestures.h"
#include "fitting/tracking/hand_reader.h"
#include "fitting/tracking/people.h"
#include "fitting/tracking/placement.h"
#include "fitting/tracking/view_watch.h"

namespace cheval::fitting {

using namespace tracking;  // NOLINT(google-build-using-namespace): the room's own inner namespace.

struct Tracker::State {
    explicit State(const TrackerOptions& options)
        : floor(options.mount),
          placement(options.mount),
          people(Zone{.nearMetres = options.zoneNearMetres,
                      .farMetres = options.zoneFarMetres,
                      .halfWidthMetres = options.zoneHalfWidthMetres}),
          gestures(options.gestures),
          map(static_cast<std::size_t>(kFrameWidth) * kFrameHeight) {}

    void reset() {
        view.reset();
        floor.reset();
        placement.reset();
        people.reset();
        body.reset();
        handReader.reset();
        gestures.reset();
        clear();
    }
    /// Results of a frame in which nobody is seen.
    void clear() {
        users = Users{};
        skeleton = Skeleton{};
        hands = Hands{};
        std::fill(map.begin(), map.end(), std::uint8_t{0});
        users.map = {map.data(), kFrameWidth, kFrameHeight, kFrameWidth};
    }
    /// The cells' labels at the picture's size, for those pixels that lie on the cell's surface.
    void drawMap(const hal::DepthFrame& frame);

    ViewWatch view;
    FloorWatch floor;
    PlacementFilter placement;
    People people;
    BodyTracker body;
    HandReader handReader;
    GestureReader gestures;
    Cloud cloud;
    std::vector<std::uint8_t> map;
    Users users;
    Skeleton skeleton;
    Hands hands;
};

void Tracker::State::drawMap(const hal::DepthFrame& frame) {
    const std::span<const std::uint8_t> labels = people.labels();
    for (int row = 0; row < kFrameHeight; ++row) {
        const std::uint16_t* depth = frame.depth.row(row);
        std::uint8_t* out = map.data() + static_cast<std::ptrdiff_t>(row) * kFrameWidth;
        for (int column = 0; column < kFrameWidth; ++column) {
            const std::size_t cell = cellIndex(column / 2, row / 2);
            out[column] = 0;
            if (labels[cell] == 0 || depth[column] == 0) continue;
            const float away = static_cast<float>(depth[column]) * 1e-3F - cloud.depth[cell];
            if (std::abs(away) < 2.0F * depthTolerance(cloud.depth[cell])) out[column] = labels[cell];
        }
    }
}

Tracker::Tracker(const TrackerOptions& options) : state_(std::make_unique<State>(options)) {
    state_->clear();
}
Tracker::~Tracker() = default;

void Tracker::track(const hal::DepthFrame& frame) {
    State& state = *state_;
    if (frame.restart) state.reset();
    CloudJob points{.depth = frame.depth,
                    .intrinsics = frame.intrinsics,
                    .placement = state.placement.placement(),
                    .cloud = &state.cloud};
    if (!points.isValid()) {
        state.view.update(nullptr, frame.captureTime);
        state.people.seeNothing(frame.captureTime);
        state.clear();
        state.users.activeId = state.people.users().activeId;
        return;
    }
    points.run();
    state.view.update(&state.cloud, frame.captureTime);
    state.floor.update(state.cloud, frame.captureTime);
    if (state.placement.update(state.cloud)) {
        // Places of before are in another frame of reference now.
        state.people.reset();
        state.body.reset();
        points.placement = state.placement.placement();
        points.run();
    }
    state.people.update(state.cloud, frame.captureTime, state.placement.floorKnown());
    state.users = state.people.users();
    state.drawMap(frame);
    state.users.map = {state.map.data(), kFrameWidth, kFrameHeight, kFrameWidth};
    const User* active = state.users.active();
    if (active == nullptr) {
        state.skeleton = Skeleton{};
        return;
    }
    state.body.update(state.cloud, state.people.labels(), *active, state.placement.floorKnown(), frame.captureTime,
                      state.skeleton);
}

void Tracker::readHands(const hal::DepthFrame& frame) {
    State& state = *state_;
    state.hands = Hands{};
    state.handReader.update(frame, state.users, state.skeleton, state.placement.placement(), state.body.stature(),
                            state.hands);
    state.gestures.update(frame, state.skeleton, state.body.stature(), state.hands);
}

void Tracker::reset() {
    state_->reset();
}
const Users& Tracker::users() const {
    return state_->users;
}
const Skeleton& Tracker::skeleton() const {
    return state_->skeleton;
}
const Hands& Tracker::hands() const {
    return state_->hands;
}
ViewFault Tracker::viewFault() const {
    // A view that shows nothing says nothing of the floor.
    const ViewFault fault = state_->view.fault();
    return fault == ViewFault::none && state_->floor.elsewhere() ? ViewFault::floorElsewhere : fault;
}
const SensorPlacement& Tracker::placement() const {
    return state_->placement.placement();
}

}  // namespace cheval::fitting

// Sees the shopper: from a depth frame to users, joints and hands. The border where the sensor frame of reference
// becomes the mirror frame (D1, D2, D3).
#pragma once

#include <memory>

#include "fitting/hands.h"
#include "fitting/skeleton.h"
#include "fitting/tracking/gesture_options.h"
#include "fitting/users.h"
#include "hal/frame.h"

namespace cheval::fitting {

struct TrackerOptions {
    hal::Mount mount;             ///< As the technician wrote it down; refined from the floor that is seen.
    float zoneNearMetres = 0.5F;  ///< The zone in which a person is dressed: distance from the glass …
    float zoneFarMetres = 4.5F;
    float zoneHalfWidthMetres = 1.5F;  ///< … and to either side of the display's centre.
    GestureOptions gestures;
};

/// Tracking with state across frames. Thread-bound. After construction no call takes heap memory.
class Tracker {
  public:
    explicit Tracker(const TrackerOptions& options);
    ~Tracker();
    Tracker(const Tracker&) = delete;
    Tracker& operator=(const Tracker&) = delete;

    /// Finds users and the active user's joints. Forgets everything first when frame.restart is set. A frame of another
    /// size than 640×480, or an empty one, finds nobody.
    void track(const hal::DepthFrame& frame);
    /// Reads the active user's hands and gestures; after track() of the same frame.
    void readHands(const hal::DepthFrame& frame);
    /// Forgets people, background and gestures.
    void reset();

    /// Results of the last calls; the references stay valid for the tracker's life, their contents until the next call.
    [[nodiscard]] const Users& users() const;
    [[nodiscard]] const Skeleton& skeleton() const;
    [[nodiscard]] const Hands& hands() const;
    /// What keeps people from being seen, or from being seen where they are, when it has lasted.
    [[nodiscard]] ViewFault viewFault() const;
    /// Where the sensor is, as known now.
    [[nodiscard]] const SensorPlacement& placement() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace cheval::fitting

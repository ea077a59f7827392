// One hand before the sensor, without a body: for trying a sensor, and the reading of hands, at close range.
#pragma once

#include <vector>

#include "fitting/hands.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/components.h"
#include "fitting/tracking/hand_openness.h"
#include "fitting/tracking/silhouette.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Reads the nearest hand of a picture by the same measures as a shopper's (D3). The scale that those take from the
/// distance between head and neck comes from the palm's own size here. So near, fingers can be counted: a hand is open
/// with all five stretched, closed with none, and else unknown. Thread-bound; takes no memory after construction.
class LoneHandReader {
  public:
    LoneHandReader();

    struct Reading {
        HandState state = HandState::unknown;
        float confidence = 0.0F;  ///< Of the state, 0…1.
        int fingers = 0;          ///< Stretched ones.
        bool found = false;       ///< Something of a hand's size was there.
    };
    /// A frame of another size than 640×480, or without anything near, holds no hand.
    Reading read(const hal::DepthFrame& frame);

  private:
    /// The widest circle inside the outline, on one side of a line through the surface's middle.
    struct Palm {
        Eigen::Vector3f point = Eigen::Vector3f::Zero();
        float radius = 0.0F;
    };
    bool findSurface(const hal::DepthFrame& frame);
    [[nodiscard]] Palm findPalm(const Eigen::Vector2f& middle, const Eigen::Vector2f& axis) const;
    [[nodiscard]] Eigen::Vector3f towardsArm(const Palm& palm) const;
    Reading readAt(const hal::DepthFrame& frame, const Palm& palm);

    Cloud cloud_;
    std::vector<std::uint8_t> mask_, labels_;
    std::vector<std::uint32_t> scratch_;
    std::vector<Component> components_;
    Silhouette silhouette_;
    HandOpennessContext context_;
};

}  // namespace cheval::fitting::tracking

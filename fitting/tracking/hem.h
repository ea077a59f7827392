// Skirts and long coats: whether one cloth hangs before both legs, and down to where.
#pragma once

#include "fitting/tracking/articulated_body.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/silhouette.h"

namespace cheval::fitting::tracking {

/// Watches the space between a person's legs: two legs beside each other leave a gap or a valley there, cloth does not.
/// Thread-bound.
class HemFinder {
  public:
    void reset() { *this = HemFinder{}; }
    /// Looks at a frame in which the body has been fitted. Somebody in profile tells nothing.
    void look(const Cloud& cloud, const Silhouette& silhouette, const ArticulatedPose& body);

    [[nodiscard]] bool covered() const { return covered_ > 0.5F; }
    /// Where the cloth ends, as a share of the way from the hips (0) to the ankles (1). While covered().
    [[nodiscard]] float hem() const { return hem_; }

  private:
    float covered_ = 0.0F;
    float hem_ = 0.0F;
};

}  // namespace cheval::fitting::tracking

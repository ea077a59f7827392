// Measures the shopper and shapes the mannequin to them (D10, D11, D12).
#pragma once

#include <memory>

#include "fitting/body.h"
#include "fitting/body/body.h"
#include "fitting/skeleton.h"
#include "fitting/users.h"
#include "hal/frame.h"

namespace cheval::fitting {

struct BodyEstimatorOptions {
    int averagedFrames = 30;  ///< D12: frames averaged before the shape counts as converged.
};

/// Measurement with state across frames. Thread-bound. After construction no call takes heap memory.
class BodyEstimator {
  public:
    BodyEstimator(const Body& body, const BodyEstimatorOptions& options);
    ~BodyEstimator();
    BodyEstimator(const BodyEstimator&) = delete;
    BodyEstimator& operator=(const BodyEstimator&) = delete;

    /// Adds one frame's evidence. Starts anew when the active user changes or frame.restart is set. The shape's
    /// revision rises only when garments need to be fitted again: on the first estimate, when converged, and on changes
    /// over one per cent.
    void update(const hal::DepthFrame& frame, const Users& users, const Skeleton& skeleton,
                const SensorPlacement& placement);
    void reset();

    [[nodiscard]] const Measurements& measurements() const;
    [[nodiscard]] const BodyShape& shape() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace cheval::fitting

// Fits the body's parameters to what the sensor sees of the trunk over a session: robust least squares in the rest-pose
// frame, with what bodies are like as the prior.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include <Eigen/Core>

#include "fitting/body/body.h"
#include "fitting/skeleton.h"
#include "hal/frame.h"

namespace cheval::fitting {

/// One shopper in one frame; borrows everything. The shopper's pixels in `map` have the value `label`.
struct TrunkView {
    const hal::DepthFrame* frame = nullptr;
    hal::ImageView<const std::uint8_t> map;
    std::uint8_t label = 0;
    const Skeleton* skeleton = nullptr;
    const SensorPlacement* placement = nullptr;
    bool stands = false;  ///< On straight legs on the floor, so that heights above it mean something.
};

/// A parameter (change against the mannequin, metres) as measured in another way.
struct ParameterReading {
    ShapeParameter parameter = ShapeParameter::stature;
    float value = 0.0F;
    float uncertainty = 0.0F;  ///< Standard, metres.
};

/// Each frame's evidence is a set of linear equations in the parameters and the thickness of the clothes, from which
/// where and how the trunk stands in that frame has been eliminated. Equations of frames in which the trunk is seen
/// from the same side say the same thing again, with the same clothes and the same faults of the model: the n-th time
/// counts about 1 / n, and what is old fades. Thread-bound; after construction it takes no memory.
class ShapeFit {
  public:
    /// A body without shapes cannot be fitted: `add` then says so.
    explicit ShapeFit(const Body& body);
    ~ShapeFit();
    ShapeFit(const ShapeFit&) = delete;
    ShapeFit& operator=(const ShapeFit&) = delete;

    void reset();
    /// Adds one frame. False where it told nothing: no trunk in view, or hidden behind arms.
    bool add(const TrunkView& view);
    /// Brings the estimate up to date with all frames and with these readings.
    void solve(std::span<const ParameterReading> readings);

    struct Estimate {
        ShapeParameters parameters = ShapeParameters::Zero();
        ShapeParameters uncertainty = ShapeParameters::Zero();  ///< Standard, metres.
        float clothes = 0.0F;                                   ///< Thickness of what is worn, metres …
        float clothesUncertainty = 0.0F;                        ///< … and its standard uncertainty.
    };
    [[nodiscard]] const Estimate& estimate() const;
    /// How well the model met the last frame: root mean squares of the distances to outline and surface, metres.
    struct Misfit {
        float outline = 0.0F, surface = 0.0F;
        int outlinePoints = 0, surfacePoints = 0;
    };
    [[nodiscard]] const Misfit& misfit() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace cheval::fitting

// Moves the dressed body with the shopper: joints to bones, four-bone linear blend skinning (D4, D5).
#pragma once

#include <memory>

#include "fitting/body/body.h"
#include "fitting/layering/outfit_fitter.h"
#include "fitting/mesh.h"
#include "fitting/skeleton.h"

namespace cheval::fitting {

struct AnimatorOptions {
    float minimumConfidence = 0.5F;  ///< D5: a bone below it keeps its last rotation.
    std::size_t maximumVertices = 200'000;
    std::size_t maximumIndices = 600'000;
};

/// Poses body and outfit. Thread-bound. After reserve() no call takes heap memory.
class Animator {
  public:
    Animator(const Body& body, const AnimatorOptions& options);
    ~Animator();
    Animator(const Animator&) = delete;
    Animator& operator=(const Animator&) = delete;

    /// Gives `mesh` (one of the triple buffer) the capacity that any pose will need.
    void reserve(PosedMesh& mesh) const;
    /// Writes `posed`: the shaped body, then each layer, in the mirror frame. Bones lie on the tracked joints, so that
    /// a garment lies on the person in the picture; joints without confidence hold their last rotation.
    void pose(const ShapedBody& body, const FittedOutfit& outfit, const Skeleton& skeleton, PosedMesh& posed);
    void reset();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace cheval::fitting

// The trunk's surface as rings of samples that follow the body's parameters: what the shape is fitted by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "fitting/body/body.h"

namespace cheval::fitting {

/// Level rings from the crotch to the neck, columns at equal angles round the trunk (column 0 at +Z, then towards +X).
/// Where an arm or the other leg begins there is no sample. Immutable after construction.
class TrunkRings {
  public:
    static constexpr std::size_t kLevels = 24;
    static constexpr std::size_t kColumns = 36;
    static constexpr std::size_t kSamples = kLevels * kColumns;

    explicit TrunkRings(const Body& body);

    [[nodiscard]] static constexpr std::size_t sample(std::size_t level, std::size_t column) {
        return level * kColumns + column % kColumns;
    }
    [[nodiscard]] bool valid(std::size_t sample) const { return valid_[sample] != 0; }
    /// 3 × 19: how the sample moves with the parameters.
    [[nodiscard]] auto basis(std::size_t sample) const {
        return basis_.middleRows<3>(static_cast<Eigen::Index>(3 * sample));
    }
    /// Places of all samples of a shape, rest pose, metres. `points` has room for kSamples.
    void place(const ShapeParameters& parameters, std::vector<Eigen::Vector3f>& points) const;
    /// Unit normal of a placed sample, from its neighbours on the rings.
    [[nodiscard]] Eigen::Vector3f normal(const std::vector<Eigen::Vector3f>& points, std::size_t sample) const;

  private:
    using Basis = Eigen::Matrix<float, Eigen::Dynamic, static_cast<int>(kShapeParameterCount), Eigen::RowMajor>;
    Basis basis_;  ///< 3 · samples × 19.
    std::vector<Eigen::Vector3f> rest_;
    std::vector<std::uint8_t> valid_;
};

}  // namespace cheval::fitting

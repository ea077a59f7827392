// Reads lengths off one shopper's depth silhouette (D10, D12). Mirror frame, metres.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "hal/frame.h"

namespace cheval::fitting {

/// One shopper in one frame. Borrows everything; takes no memory. Every answer is nothing where the silhouette leaves
/// the picture or something else is in the way. Work is bounded by the picture's width plus height a call.
class Silhouette {
  public:
    /// `map` has the depth picture's size; the shopper's pixels have the value `label`.
    Silhouette(const hal::DepthFrame& frame, hal::ImageView<const std::uint8_t> map, std::uint8_t label,
               const Skeleton& skeleton, const SensorPlacement& placement);

    /// Height of the crown above the floor, hair included: the highest pixel above the head's centre.
    [[nodiscard]] std::optional<float> crownHeight() const;
    /// Breadth of the trunk or head at the height of `centre`, a point on its axis: between the places where the
    /// outline ends to either side. Nothing where an arm joins the outline.
    [[nodiscard]] std::optional<float> breadthAt(const Eigen::Vector3f& centre) const;
    /// Height of the crotch above the floor: where the gap between the legs ends. Nothing where they touch at the
    /// knees.
    [[nodiscard]] std::optional<float> crotchHeight() const;
    /// Whether at least one foot is seen, so that heights above the floor mean something.
    [[nodiscard]] bool standsInPicture() const;

  private:
    struct Pixel {
        int u = 0, v = 0;
    };
    [[nodiscard]] std::optional<Pixel> pixelOf(const Eigen::Vector3f& point) const;
    [[nodiscard]] bool inside(int u, int v) const;
    [[nodiscard]] bool onArm(int u, int v, float depth) const;
    [[nodiscard]] std::optional<int> outlineEnd(Pixel from, int step, float depth) const;

    const hal::DepthFrame& frame_;
    hal::ImageView<const std::uint8_t> map_;
    std::uint8_t label_;
    const Skeleton& skeleton_;
    const SensorPlacement& placement_;
};

}  // namespace cheval::fitting

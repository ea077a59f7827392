// Lengths and girths of the body model, by the definitions of ISO 8559-1 and of config/anthropometry: landmarks are
// vertices of the mannequin and move with it, girths are tape lengths (convex hulls) of plane cuts without the arms.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fitting/body/body.h"

namespace cheval::fitting {

/// The first fourteen of ShapeParameter can be measured on a body.
inline constexpr std::size_t kMeasuredParameterCount = 14;
using MeasuredParameters = Eigen::Matrix<float, static_cast<int>(kMeasuredParameterCount), 1>;

/// Measures any shape of one body. Thread-bound; after construction it takes no memory.
class BodyMeasures {
  public:
    explicit BodyMeasures(const Body& body);

    /// Metres, in the order of ShapeParameter, of the body whose mesh vertices and joints these are (rest pose, floor
    /// at y = 0):
    ///   stature: floor to the crown; chest girth: level, at the bust points; waist girth: level, at the natural waist
    ///   between the lowest rib and the iliac crest; hip girth: level, at the greatest protrusion of the seat, thighs
    ///   included; neck girth: the smallest of the cuts across the neck's axis; shoulder breadth: between the shoulder
    ///   joints; arm length: shoulder joint, elbow, wrist; inside leg: floor to crotch; head height: chin to crown;
    ///   depths: of the chest's, waist's and hips' cuts; thigh girth: level, just below the crotch; waist rise: above
    ///   the place 0.46 of the way from the crotch to the neck's joint.
    [[nodiscard]] MeasuredParameters measure(std::span<const Eigen::Vector3f> positions,
                                             std::span<const Eigen::Vector3f, kJointCount> joints) const;

    /// Heights above the floor of the chest's, waist's and hips' cuts, metres.
    struct Levels {
        float chest = 0.0F, waist = 0.0F, hips = 0.0F;
    };
    [[nodiscard]] Levels levels(std::span<const Eigen::Vector3f> positions) const;

  private:
    struct Cut {
        float girth = 0.0F;  ///< Of the convex hull.
        float depth = 0.0F;  ///< Extent along z.
    };
    [[nodiscard]] Cut cut(std::span<const Eigen::Vector3f> positions, std::span<const std::uint32_t> triangles,
                          const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

    const Body& body_;
    std::vector<std::uint32_t> trunk_;      ///< Triangles without the arms.
    std::vector<std::uint32_t> neck_;       ///< Triangles of the neck.
    std::vector<std::uint32_t> leftThigh_;  ///< Triangles of one thigh.
    std::uint32_t crown_ = 0, chin_ = 0, crotch_ = 0, bust_ = 0, seat_ = 0, aboveWaist_ = 0, belowWaist_ = 0;
    float waistShare_ = 0.5F;  ///< Of the way from below to above.
    float wristShare_ = 0.5F;  ///< Where the wrist is between elbow and palm.
    mutable std::vector<Eigen::Vector2f> points_;
    mutable std::vector<Eigen::Vector2f> hull_;
};

/// Length of the tape round a set of points: the perimeter of their convex hull. Sorts `points`; `hull` is scratch and
/// takes no memory when its capacity is twice their number.
float tapeLength(std::vector<Eigen::Vector2f>& points, std::vector<Eigen::Vector2f>& hull);

}  // namespace cheval::fitting

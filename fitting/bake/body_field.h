// The mannequin as an implicit surface: lofted trunk, limbs and head that flow into each other. Everything else that is
// made (cage, mesh, garments) is laid onto this surface or at a distance from it.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "fitting/bake/spline.h"
#include "fitting/skeleton.h"

namespace cheval::fitting::bake {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;

/// A tube with cross-sections that change along a straight axis.
class Loft {
  public:
    /// One cross-section: where on the axis, the centre's offset and the half-widths, all in metres.
    struct Section {
        double along;
        double centre1, centre2;  ///< Along the first and the second cross direction.
        double plus1, minus1;     ///< Half-widths along the first direction.
        double plus2, minus2;     ///< Half-widths along the second.
    };
    struct Shape {
        Vec3 origin, axis, first, second;         ///< Orthonormal.
        double exponent = 2.0;                    ///< Of the superellipse: 2 is an ellipse, more is boxier.
        double roundStart = 0.0, roundEnd = 0.0;  ///< Lengths over which the ends close to a dome; 0: cut flat.
        std::vector<Section> sections;
    };
    explicit Loft(Shape shape);
    /// About the signed distance in metres: exact in sign, close near the surface. Negative inside.
    [[nodiscard]] double distance(const Vec3& point) const;
    [[nodiscard]] const Shape& shape() const { return shape_; }
    /// The middle of the cross-section at `along`.
    [[nodiscard]] Vec3 centre(double along) const;

  private:
    Shape shape_;
    double start_ = 0.0, end_ = 0.0;
    std::array<Spline, 6> splines_;
};

/// The reference mannequin: 1.75 m, A-pose, the frame of assets. Left half only is described; x is taken positive.
class BodyField {
  public:
    BodyField();
    /// About the signed distance of a point with x ≥ 0 to the whole body.
    [[nodiscard]] double whole(const Vec3& point) const;
    [[nodiscard]] double trunk(const Vec3& point) const;  ///< Without limbs.
    [[nodiscard]] double arm(const Vec3& point) const;    ///< Left arm and hand without the thumb.
    [[nodiscard]] double leg(const Vec3& point) const;    ///< Left leg and foot.
    /// Of a point on either side.
    [[nodiscard]] double mirrored(const Vec3& point) const;

    [[nodiscard]] const Loft& armLoft() const { return arm_; }
    [[nodiscard]] const Loft& legLoft() const { return leg_; }
    [[nodiscard]] const Loft& footLoft() const { return foot_; }
    [[nodiscard]] const Loft& trunkLoft() const { return trunk_; }
    [[nodiscard]] Vec3 thumbRoot() const;
    [[nodiscard]] Vec3 thumbTip() const;
    /// Joint centres on both sides, bit for bit mirrored.
    [[nodiscard]] const std::array<Vec3, kJointCount>& joints() const { return joints_; }

  private:
    Loft trunk_;
    Loft arm_;
    Loft leg_;
    Loft foot_;
    std::array<Vec3, kJointCount> joints_{};
};

using Field = std::function<double(const Vec3&)>;

/// Central differences, not normalised.
Vec3 gradient(const Field& field, const Vec3& point);
/// Walks along the gradient to where field = `level`; with `onMidPlane` x stays exactly 0.
Vec3 project(const Field& field, Vec3 point, double level, bool onMidPlane);
/// From `origin` (inside) along the unit `direction` to the first place where field ≥ 0, at most `reach` metres away.
Vec3 castOut(const Field& field, const Vec3& origin, const Vec3& direction, double reach);

/// Where along the arm's axis elbow and wrist lie, metres from the shoulder; knee and ankle from the hip.
inline constexpr double kElbowAlong = 0.290;
inline constexpr double kWristAlong = 0.540;
inline constexpr double kKneeAlong = 0.415;
inline constexpr double kAnkleAlong = 0.820;

}  // namespace cheval::fitting::bake

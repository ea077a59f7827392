// The body that is fitted to the depth: a trunk, a head and four limbs of two bones, with the person's own sizes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "fitting/skeleton.h"

namespace cheval::fitting::tracking {

/// What differs from person to person, metres.
enum class BodyLength : std::uint8_t {
    headDrop,             ///< From the crown down to the neck's base.
    trunk,                ///< From the neck's base to the middle of the hips.
    shoulderHalfBreadth,  ///< Between the shoulder joints, half of it.
    hipHalfBreadth,       ///< Between the hip joints, half of it.
    upperArm,
    forearm,  ///< Elbow to the centre of the palm.
    thigh,
    shank,           ///< Knee to ankle.
    trunkDepth,      ///< From the trunk's front to its middle plane.
    trunkHalfWidth,  ///< From the trunk's middle line to its side.
    hipSetback       ///< How far behind the trunk's middle plane the hip joints lie: a belly, or a hollow back.
};
inline constexpr std::size_t kBodyLengthCount = 11;
constexpr std::size_t index(BodyLength which) {
    return static_cast<std::size_t>(which);
}
using BodyLengths = std::array<float, kBodyLengthCount>;

/// What is usual for a stature (metres, hair and shoes included, as the sensor sees it). Heads differ little between
/// adults, so what lies below is a share of the rest. Segment lengths: Drillis and Contini (Winter, Biomechanics and
/// Motor Control of Human Movement, 4th ed., figure 4.1), with joint centres in place of landmarks.
BodyLengths usualLengths(float stature);
/// How far people of one stature differ from the usual, one standard deviation, metres; of a stature that is only
/// guessed, further.
BodyLengths lengthSpread(float stature, bool statureKnown);

/// Both bones of a limb as unit vectors, mirror frame: from the trunk to elbow or knee, and on to palm or ankle.
struct LimbDirections {
    Eigen::Vector3f upper{0, -1, 0}, lower{0, -1, 0};
};

/// How the legs of somebody who sits with that trunk usually lie; columns of `axes`: left, up, forward.
LimbDirections seatedLeg(const Eigen::Matrix3f& axes);

/// Where everything is. Mirror frame, metres.
struct ArticulatedPose {
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();    ///< Of the trunk: halfway from the neck's base to the hips.
    Eigen::Matrix3f axes = Eigen::Matrix3f::Identity();  ///< Columns: the person's left, up, forward; orthonormal.
    Eigen::Vector3f headDirection = Eigen::Vector3f::UnitY();  ///< Unit; from the neck's base to the head's centre.
    std::array<LimbDirections, kSideCount> arms, legs;
    BodyLengths size{};

    [[nodiscard]] float length(BodyLength which) const { return size[index(which)]; }
    [[nodiscard]] Eigen::Vector3f left() const { return axes.col(0); }
    [[nodiscard]] Eigen::Vector3f up() const { return axes.col(1); }
    [[nodiscard]] Eigen::Vector3f forward() const { return axes.col(2); }
    [[nodiscard]] Eigen::Vector3f neck() const { return middle + 0.5F * length(BodyLength::trunk) * up(); }
    [[nodiscard]] Eigen::Vector3f hipMiddle() const { return middle - 0.5F * length(BodyLength::trunk) * up(); }
    [[nodiscard]] Eigen::Vector3f head() const;
    [[nodiscard]] Eigen::Vector3f shoulder(Side side) const;
    [[nodiscard]] Eigen::Vector3f hip(Side side) const;
    [[nodiscard]] Eigen::Vector3f elbow(Side side) const {
        return shoulder(side) + length(BodyLength::upperArm) * arms[fitting::index(side)].upper;
    }
    [[nodiscard]] Eigen::Vector3f hand(Side side) const {
        return elbow(side) + length(BodyLength::forearm) * arms[fitting::index(side)].lower;
    }
    [[nodiscard]] Eigen::Vector3f knee(Side side) const {
        return hip(side) + length(BodyLength::thigh) * legs[fitting::index(side)].upper;
    }
    [[nodiscard]] Eigen::Vector3f foot(Side side) const {
        return knee(side) + length(BodyLength::shank) * legs[fitting::index(side)].lower;
    }
    /// The same outline of somebody who faces the other way.
    [[nodiscard]] ArticulatedPose turnedRound() const;
    /// Whether each foot stands on the other's side.
    [[nodiscard]] bool legsCrossed() const { return (foot(Side::left) - foot(Side::right)).dot(left()) < 0.0F; }
    /// Each leg in the other's place.
    [[nodiscard]] ArticulatedPose withLegsExchanged() const;
};

/// The sign of a side along the person's left: 1 for the left, −1 for the right.
constexpr float outwards(Side side) {
    return side == Side::left ? 1.0F : -1.0F;
}

/// The shoulder joints lie this much lower than the neck's base, in shares of the trunk's length.
inline constexpr float kShoulderDrop = 0.18F;
/// From the crown down to the centre of the head, in shares of headDrop.
inline constexpr float kHeadCentre = 0.46F;

/// Parts of the body's surface.
enum class BodyPart : std::uint8_t {
    head,
    neck,
    trunk,
    leftUpperArm,
    rightUpperArm,
    leftThigh,
    rightThigh,
    leftForearm,
    rightForearm,
    leftShank,
    rightShank,
    leftFoot,
    rightFoot
};
inline constexpr std::size_t kBodyPartCount = 13;

/// A posed body's surface: round cones about bones, and a rounded slab for the trunk.
class BodySurface {
  public:
    explicit BodySurface(const ArticulatedPose& pose);

    /// The place on the body that a point belongs to.
    struct Place {
        BodyPart part = BodyPart::trunk;
        float distance = 0.0F;  ///< Metres from the point to the part's surface; negative inside.
        Eigen::Vector3f point = Eigen::Vector3f::Zero();  ///< On the bone, or on the trunk's flat middle.
        float along = 0.0F;   ///< Share of the bone, 0…1; trunk: height over its length, −½ … ½.
        float across = 0.0F;  ///< Trunk: sideways, −1…1 of the slab's half width.
        float radius = 0.0F;  ///< Of the surface about that place.
    };
    /// On the part whose surface is nearest, whether the point lies inside or outside of it.
    [[nodiscard]] Place nearest(const Eigen::Vector3f& point) const;
    /// Metres from a point to the whole body; negative inside.
    [[nodiscard]] float outside(const Eigen::Vector3f& point) const;

  private:
    static constexpr std::size_t kLanes = 16;
    static_assert(kBodyPartCount <= kLanes);
    /// What each part says of a point.
    struct Distances {
        alignas(64) std::array<float, kLanes> metres, share;
        float height = 0.0F, across = 0.0F;  ///< On the trunk's slab, metres.
        Eigen::Vector3f onSlab;
    };
    [[nodiscard]] Distances distances(const Eigen::Vector3f& point) const;
    void setBone(BodyPart part, const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius, float endRadius);

    /// One entry a part, so that compilers look at several at once; the trunk's and the empty ones lie far away.
    struct alignas(64) Bones {
        std::array<float, kLanes> x, y, z, alongX, alongY, alongZ, perLength, radius, taper;
    };
    Bones bones_;
    Eigen::Vector3f middle_, left_, up_;  ///< Of the slab, which the hips' setback tilts against the trunk.
    float halfTrunk_, slab_, trunkRadius_;
};

}  // namespace cheval::fitting::tracking

// The wheelchair of who sits in one: built about the pelvis, with which it rolls.
#include <array>
#include <cmath>
#include <numbers>

#include "hal/sim/figure.h"
#include "hal/sim/part.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;

constexpr float kTau = 2.0F * std::numbers::pi_v<float>;
constexpr float kWheelRadius = 0.29F;  ///< Metres, as all lengths here that no body gives.
constexpr float kTyreRadius = 0.016F;
constexpr float kCasterRadius = 0.08F;

struct ChairMaker {
    Mesh& mesh;
    Hold hold;
    float lift;  ///< From heights above the floor to those of the rest pose, in which the pelvis is that of a stand.

    [[nodiscard]] Vector3f at(float x, float height, float ahead) const { return {x, height + lift, ahead}; }

    /// A closed ring of tube about an axle along x. Its section turns against its way round, so that its outside is
    /// outside.
    void addWheel(const Vector3f& axle, float radius, float tyre) const {
        constexpr std::size_t kAround = 28;
        std::array<Ring, kAround + 1> rings;
        for (std::size_t i = 0; i <= kAround; ++i) {
            const float angle = kTau * static_cast<float>(i) / static_cast<float>(kAround);
            const Vector3f out(0.0F, std::cos(angle), std::sin(angle));
            const Vector3f onward(0.0F, -std::sin(angle), std::cos(angle));
            rings[i] = {.centre = axle + radius * out,
                        .across = out,
                        .ahead = onward.cross(out),
                        .halfWidth = tyre,
                        .front = tyre,
                        .back = tyre,
                        .hold = hold,
                        .colour = {0.16F, 0.16F, 0.17F}};
        }
        addLoft(mesh, rings, 8, Material::darkCloth, Cap::open, Cap::open);
    }
    /// A slab between two ends along `along`, with half sizes across it.
    void addSlab(const Vector3f& from, const Vector3f& to, const Vector3f& across, float halfWidth, float halfDepth,
                 Material material, const Vector3f& colour) const {
        const Vector3f along = (to - from).normalized();
        std::array<Ring, 2> rings;
        for (std::size_t i = 0; i < 2; ++i) {
            rings[i] = {.centre = i == 0 ? from : to,
                        .across = across,
                        .ahead = along.cross(across),
                        .halfWidth = halfWidth,
                        .front = halfDepth,
                        .back = halfDepth,
                        .hold = hold,
                        .colour = colour,
                        .squareness = 6.0F};
        }
        addLoft(mesh, rings, 16, material, Cap::flat, Cap::flat);
    }
};

}  // namespace

void addWheelchair(const Shopper& shopper, const Rig& rig, Mesh& mesh) {
    const float h = shopper.stature;
    const auto pelvis = static_cast<std::uint16_t>(bone(Bone::pelvis));
    const ChairMaker chair{.mesh = mesh,
                           .hold = {.first = pelvis, .second = pelvis, .share = 0.0F},
                           .lift = rig.at(Bone::pelvis).y() - kSeatedHip * h};
    const Vector3f cloth(0.15F, 0.16F, 0.18F);
    const Vector3f steel(0.55F, 0.55F, 0.57F);
    const float halfSeat = (0.105F + 0.02F * std::max(0.0F, shopper.build)) * h;
    const float seat = (kSeatedHip - 0.068F) * h;
    const float backrest = -0.085F * h;
    chair.addSlab(chair.at(0.0F, seat, backrest), chair.at(0.0F, seat, 0.19F * h), Vector3f::UnitX(), halfSeat, 0.02F,
                  Material::darkCloth, cloth);
    chair.addSlab(chair.at(0.0F, seat, backrest), chair.at(0.0F, seat + 0.24F * h, backrest - 0.02F * h),
                  Vector3f::UnitX(), halfSeat, 0.02F, Material::darkCloth, cloth);
    const float heel = kSeatedAnkleHeight * h - 0.055F * h;
    for (const float side : {-1.0F, 1.0F}) {
        const float x = side * (halfSeat + 0.035F);
        chair.addWheel(chair.at(x, kWheelRadius + kTyreRadius, -0.02F * h), kWheelRadius, kTyreRadius);
        chair.addWheel(chair.at(0.8F * x, kCasterRadius + kTyreRadius, 0.17F * h), kCasterRadius, kTyreRadius);
        chair.addSlab(chair.at(0.92F * x, seat + 0.11F * h, backrest), chair.at(0.92F * x, seat + 0.11F * h, 0.10F * h),
                      Vector3f::UnitX(), 0.022F, 0.014F, Material::cloth, cloth);
        // From the seat's corner down to the foot plate, and the handle that others push.
        chair.addSlab(chair.at(0.8F * side * halfSeat, seat, 0.19F * h),
                      chair.at(side * 0.06F * h, heel, (kSeatedAnkleAhead + 0.02F) * h), Vector3f::UnitX(), 0.012F,
                      0.012F, Material::glossy, steel);
        chair.addSlab(chair.at(side * 0.06F * h, heel - 0.012F, (kSeatedAnkleAhead - 0.02F) * h),
                      chair.at(side * 0.06F * h, heel - 0.012F, (kSeatedAnkleAhead + 0.10F) * h), Vector3f::UnitX(),
                      0.04F * h, 0.008F, Material::glossy, steel);
        chair.addSlab(chair.at(side * halfSeat, seat + 0.235F * h, backrest - 0.02F * h),
                      chair.at(side * halfSeat, seat + 0.235F * h, backrest - 0.09F * h), Vector3f::UnitX(), 0.015F,
                      0.015F, Material::darkCloth, cloth);
    }
}

}  // namespace cheval::hal::sim

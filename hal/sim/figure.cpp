#include "hal/sim/figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include "hal/sim/bare_body.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::Side;

constexpr std::array<Side, 2> kSides = {Side::left, Side::right};

constexpr std::array<Station, 23> kArm = {
    {{-0.44F, 0.0150F, 0.001F}, {-0.34F, 0.0195F, 0.002F}, {-0.24F, 0.0225F, 0.003F}, {-0.14F, 0.0250F, 0.004F},
     {-0.05F, 0.0270F, 0.004F}, {0.04F, 0.0285F, 0.005F},  {0.14F, 0.0298F, 0.006F},  {0.26F, 0.0298F, 0.006F},
     {0.40F, 0.0290F, 0.006F},  {0.55F, 0.0278F, 0.006F},  {0.70F, 0.0262F, 0.005F},  {0.82F, 0.0245F, 0.004F},
     {0.92F, 0.0235F, 0.004F},  {1.00F, 0.0232F, 0.003F},  {1.08F, 0.0236F, 0.003F},  {1.20F, 0.0243F, 0.004F},
     {1.34F, 0.0236F, 0.004F},  {1.50F, 0.0215F, 0.003F},  {1.66F, 0.0190F, 0.003F},  {1.80F, 0.0170F, 0.002F},
     {1.92F, 0.0160F, 0.002F},  {2.00F, 0.0157F, 0.002F},  {2.05F, 0.0155F, 0.002F}}};

void addArm(const Shopper& shopper, const Rig& rig, Side side, Mesh& mesh) {
    const Limb limb{.begin = rig.at(side, SideBone::upperArm),
                    .middle = rig.at(side, SideBone::forearm),
                    .end = rig.at(side, SideBone::hand),
                    .root = bone(Bone::chest),
                    .upper = bone(side, SideBone::upperArm),
                    .lower = bone(side, SideBone::forearm),
                    .tip = bone(side, SideBone::forearmTwist),
                    .joint = 0.2F,
                    .rise = 0.36F};
    const Vector3f along = (limb.end - limb.begin).normalized();
    const Vector3f ahead = Vector3f::UnitZ().cross(along);
    const float h = shopper.stature;
    const float muscle = 0.92F + 0.16F * shopper.masculine;
    std::array<Ring, kArm.size() + 2> rings;
    const auto ring = [&](const Station& station, float ease, const Vector3f& colour) {
        const float radius =
            h * muscle * (station.radius + station.byBuild * shopper.build) * shopper.shares.armGirth + ease;
        Hold hold = limb.hold(station.along);
        if (station.along > 1.78F) {
            hold = heldBy(bone(side, SideBone::forearmTwist), bone(side, SideBone::hand),
                          smoothStep(1.74F, 2.0F, station.along));
        } else if (station.along > 1.4F) {
            hold = heldBy(limb.lower, limb.tip, smoothStep(1.2F, 1.74F, station.along));
        }
        // The upper end lies in the shoulder and shares its slope.
        return Ring{.centre = limb.at(station.along),
                    .across = Vector3f::UnitZ(),
                    .ahead = ahead,
                    .halfWidth = radius * (station.along > 1.7F ? 1.2F : 1.0F),
                    .front = radius * (station.along > 1.7F ? 0.9F : 1.0F),
                    .back = radius * (station.along > 1.7F ? 0.9F : 1.0F),
                    .hold = hold,
                    .colour = colour};
    };
    const bool longSleeves = shopper.sleeves == Sleeves::longSleeves;
    const float sleeveEnd = longSleeves ? 1.86F : 0.56F;
    std::size_t count = 0;
    for (const Station& station : kArm) {
        if (station.along < sleeveEnd - 0.2F) continue;
        rings[count++] = ring(station, 0.0F, shopper.skin);
    }
    addLoft(mesh, std::span(rings).first(count), 20, Material::skin, Cap::open, Cap::open);

    count = 0;
    for (const Station& station : kArm) {
        if (station.along > sleeveEnd - 0.03F) break;
        const float loose = longSleeves ? 1.0F : 1.0F + 0.5F * smoothStep(0.1F, 0.5F, station.along);
        rings[count++] = ring(station, loose * shopper.clothEase, shopper.shirt);
    }
    const auto edge = [&](float ease, float shade) {
        Station last{sleeveEnd, longSleeves ? 0.0172F : 0.0277F, longSleeves ? 0.002F : 0.006F};
        rings[count] = ring(last, ease * shopper.clothEase, shopper.shirt);
        rings[count++].shade = shade;
    };
    edge(longSleeves ? 0.9F : 1.6F, 0.95F);
    edge(0.2F, 0.4F);
    addLoft(mesh, std::span(rings).first(count), 24, shopper.darkShirt ? Material::darkCloth : Material::cloth,
            Cap::flat, Cap::open);
}

void addLeg(const Shopper& shopper, const Rig& rig, Side side, Mesh& mesh) {
    const Limb limb = legOf(rig, side);
    const float h = shopper.stature;
    const auto bare = legRings(shopper, rig, side, 0.5F * shopper.clothEase + shopper.trouserEase);
    std::array<Ring, kLegRingCount + 3> rings;
    std::copy(bare.begin(), bare.end(), rings.begin());
    std::size_t count = bare.size();
    rings[count] = rings[count - 1];  // The turned-in hem.
    rings[count].halfWidth *= 0.8F;
    rings[count].front *= 0.8F;
    rings[count].back *= 0.8F;
    rings[count++].shade = 0.35F;
    addLoft(mesh, std::span(rings).first(count), kLegSegments,
            shopper.darkTrousers ? Material::darkCloth : Material::cloth, Cap::open, Cap::open);

    // Sock.
    count = 0;
    for (const float along : {1.8F, 2.0F, 2.1F}) {
        rings[count++] = {.centre = limb.at(along),
                          .halfWidth = 0.022F * h,
                          .front = 0.023F * h,
                          .back = 0.024F * h,
                          .hold = heldBy(limb.lower, limb.tip, along < 1.9F ? 0.0F : 1.0F),
                          .colour = {0.80F, 0.80F, 0.80F},
                          .shade = 0.7F};
    }
    addLoft(mesh, std::span(rings).first(count), 16, Material::cloth, Cap::open, Cap::open);
}

/// A cross-section of the shoe: distance ahead of the ankle, height and half width, shares of the stature.
struct ShoeSection {
    float ahead, height, halfWidth;
};
constexpr std::array<ShoeSection, 10> kShoe = {{{-0.0330F, 0.030F, 0.0090F},
                                                {-0.0310F, 0.043F, 0.0165F},
                                                {-0.0220F, 0.053F, 0.0205F},
                                                {-0.0020F, 0.057F, 0.0215F},
                                                {0.0180F, 0.052F, 0.0225F},
                                                {0.0400F, 0.042F, 0.0250F},
                                                {0.0620F, 0.034F, 0.0275F},
                                                {0.0860F, 0.029F, 0.0260F},
                                                {0.1010F, 0.024F, 0.0190F},
                                                {0.1080F, 0.016F, 0.0090F}}};

void addShoe(const Shopper& shopper, const Rig& rig, Side side, Mesh& mesh) {
    const float h = shopper.stature;
    const Vector3f ankle = rig.at(side, SideBone::foot);
    const float outward = side == Side::left ? 1.0F : -1.0F;
    constexpr int kSegments = 20;
    constexpr float kSole = 0.011F;
    const auto build = [&](float grow, float top, const Vector3f& colour, bool sole) {
        std::array<Ring, kShoe.size()> rings;
        for (std::size_t i = 0; i < kShoe.size(); ++i) {
            const ShoeSection& section = kShoe[i];
            const float height = h * (sole ? top : section.height) + shopper.lift;
            const float x = outward * h * 0.006F * smoothStep(0.0F, 0.09F, section.ahead);
            rings[i] = {.centre = {ankle.x() + x, 0.5F * height, ankle.z() + h * section.ahead * (sole ? 1.03F : 1.0F)},
                        .across = Vector3f::UnitX(),
                        .ahead = Vector3f::UnitY(),
                        .halfWidth = h * section.halfWidth * grow,
                        .front = 0.5F * height,
                        .back = 0.5F * height,
                        .hold = heldBy(bone(side, SideBone::foot)),
                        .colour = colour,
                        .squareness = sole ? 4.0F : 2.4F};
        }
        addLoft(mesh, rings, kSegments, Material::shoe, Cap::flat, Cap::flat);
    };
    build(1.0F, 0.0F, shopper.shoes, false);
    build(1.07F, kSole, shopper.sole, true);
}

/// Where the thighs leave the seat, as softenShoulder.
void softenHips(const Shopper& shopper, Mesh& mesh) {
    const float h = shopper.stature;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vector3f& p = mesh.positions[i];
        if (std::abs(p.x()) > 0.2F * h) continue;
        const float near = 0.8F * smoothStep(0.085F * h, 0.030F * h,
                                             std::abs(p.y() - (0.495F + shopper.shares.leg) * h - shopper.lift));
        if (near <= 0.0F) continue;
        const Vector3f outward = Vector3f(0.6F * p.x(), 0.0F, p.z()).normalized();
        mesh.normals[i] = ((1.0F - near) * mesh.normals[i] + near * outward).normalized();
    }
}

/// Sleeve and shirt cross at the shoulder; light must not show that they are two surfaces.
void softenShoulder(const Shopper& shopper, const Rig& rig, Side side, Mesh& mesh) {
    const float h = shopper.stature;
    const Vector3f joint = rig.at(side, SideBone::upperArm);
    const Vector3f centre(0.74F * joint.x(), joint.y() - 0.012F * h, joint.z());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vector3f& p = mesh.positions[i];
        const float near = 0.8F * smoothStep(0.075F * h, 0.030F * h, (p - joint).norm());
        if (near <= 0.0F) continue;
        mesh.normals[i] = ((1.0F - near) * mesh.normals[i] + near * (p - centre).normalized()).normalized();
    }
}

}  // namespace

void buildFigure(const Shopper& shopper, const Rig& rig, Mesh& mesh) {
    mesh.clear();
    addTrunk(shopper, rig, mesh);
    addHead(shopper, rig, mesh);
    for (const Side side : kSides) {
        addArm(shopper, rig, side, mesh);
        addHand(shopper, rig, side, mesh);
        addLeg(shopper, rig, side, mesh);
        addShoe(shopper, rig, side, mesh);
    }
    if (shopper.wheelchair) addWheelchair(shopper, rig, mesh);
    mesh.finish();
    for (const Side side : kSides)
        softenShoulder(shopper, rig, side, mesh);
    softenHips(shopper, mesh);
}

}  // namespace cheval::hal::sim

#include "hal/sim/figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::Side;

constexpr std::array<Side, 2> kSides = {Side::left, Side::right};

float smooth(float from, float to, float value) {
    const float u = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
    return u * u * (3.0F - 2.0F * u);
}

Hold held(std::size_t first) {
    return {.first = static_cast<std::uint16_t>(first), .second = static_cast<std::uint16_t>(first), .share = 0.0F};
}
Hold held(std::size_t first, std::size_t second, float share) {
    return {.first = static_cast<std::uint16_t>(first), .second = static_cast<std::uint16_t>(second), .share = share};
}

/// A level of the torso: heights as a share of the way from crotch (0) to neck base (1), half sizes as shares of the
/// stature for an average build, and what build adds.
struct Level {
    float height, width, front, back;
    float widthByBuild, frontByBuild;
};
constexpr std::array<Level, 19> kTorso = {{
    {-0.045F, 0.058F, 0.028F, 0.036F, 0.008F, 0.004F}, {0.00F, 0.090F, 0.044F, 0.055F, 0.013F, 0.008F},
    {0.08F, 0.1000F, 0.056F, 0.068F, 0.018F, 0.015F},  {0.15F, 0.1005F, 0.062F, 0.069F, 0.021F, 0.026F},
    {0.22F, 0.095F, 0.061F, 0.063F, 0.024F, 0.034F},   {0.30F, 0.088F, 0.058F, 0.054F, 0.026F, 0.040F},
    {0.38F, 0.0815F, 0.055F, 0.048F, 0.027F, 0.041F},  {0.46F, 0.0815F, 0.056F, 0.049F, 0.026F, 0.036F},
    {0.54F, 0.086F, 0.060F, 0.054F, 0.023F, 0.027F},   {0.62F, 0.0925F, 0.065F, 0.060F, 0.019F, 0.018F},
    {0.69F, 0.0970F, 0.067F, 0.063F, 0.016F, 0.013F},  {0.75F, 0.0985F, 0.063F, 0.063F, 0.013F, 0.010F},
    {0.81F, 0.0985F, 0.056F, 0.060F, 0.011F, 0.007F},  {0.865F, 0.1000F, 0.049F, 0.056F, 0.010F, 0.005F},
    {0.905F, 0.0980F, 0.043F, 0.050F, 0.009F, 0.004F}, {0.94F, 0.0885F, 0.037F, 0.045F, 0.008F, 0.003F},
    {0.97F, 0.0690F, 0.033F, 0.040F, 0.006F, 0.003F},  {1.00F, 0.0465F, 0.032F, 0.037F, 0.005F, 0.003F},
    {1.02F, 0.0365F, 0.031F, 0.034F, 0.004F, 0.003F},
}};
constexpr int kTorsoSegments = 40;
constexpr float kBeltHeight = 0.34F;  ///< Where trousers end below the shirt.
constexpr float kHemHeight = 0.06F;   ///< The shirt's hem.

struct TorsoMaker {
    const Shopper& shopper;
    const Rig& rig;
    float crotch, neckBase;

    TorsoMaker(const Shopper& theShopper, const Rig& theRig)
        : shopper(theShopper), rig(theRig), crotch(0.475F * theShopper.stature), neckBase(theRig.at(Bone::neck).y()) {}

    [[nodiscard]] Ring at(const Level& level, float ease, const Vector3f& colour) const {
        const float h = shopper.stature;
        const float build = shopper.build;
        const float upper = smooth(0.35F, 0.8F, level.height);
        // Shoulders grow and hips shrink with masculinity; an average woman's bust and seat stand out more.
        const float sex = shopper.masculine - 0.5F;
        float width = level.width * (1.0F + sex * (0.17F * upper - 0.06F)) + level.widthByBuild * build;
        // Hips are never narrower than the thighs below them.
        const float thighs =
            rig.at(Side::left, SideBone::thigh).x() / h + 0.0505F * (1.0F - 0.06F * sex) + 0.013F * build;
        const bool overThighs = level.height > 0.02F && level.height < 0.25F;
        if (overThighs) width = std::max(width, thighs);
        const float bust = std::exp(-std::pow((level.height - 0.67F) / 0.09F, 2.0F));
        const float child = shopper.stature < 1.45F ? 0.0F : 1.0F;
        float front = level.front + level.frontByBuild * std::max(build, 0.35F * build) - 0.012F * child * sex * bust;
        if (overThighs) front = std::max(front, 0.0575F + 0.013F * build);
        const float back = level.back + 0.4F * level.frontByBuild * build -
                           0.008F * sex * std::exp(-std::pow((level.height - 0.1F) / 0.12F, 2.0F));
        const float y = crotch + level.height * (neckBase - crotch);
        return {.centre = {0.0F, y, -0.004F * h * upper},
                .halfWidth = width * h + ease,
                .front = front * h + ease,
                .back = back * h + ease,
                .hold = hold(level.height),
                .colour = colour,
                .squareness = 2.25F};
    }
    [[nodiscard]] static Hold hold(float height) {
        if (height > 0.9F) return held(bone(Bone::chest), bone(Bone::neck), 0.7F * smooth(0.93F, 1.02F, height));
        return held(bone(Bone::pelvis), bone(Bone::chest), smooth(0.12F, 0.68F, height));
    }
};

/// Moves the lower edge of what hangs over the hips with the thighs.
void followThighs(Mesh& mesh, std::size_t first, std::size_t rings, int segments, std::span<const float> shares) {
    for (std::size_t i = 0; i < rings; ++i) {
        if (shares[i] <= 0.0F) continue;
        for (int j = 0; j < segments; ++j) {
            const std::size_t v = first + i * static_cast<std::size_t>(segments) + static_cast<std::size_t>(j);
            const float x = mesh.positions[v].x();
            const Side side = x > 0.0F ? Side::left : Side::right;
            const float reach = std::min(1.0F, std::abs(x) / 0.06F);
            mesh.holds[v] = held(bone(Bone::pelvis), bone(side, SideBone::thigh), shares[i] * reach);
        }
    }
}

float neckRadius(const Shopper& shopper) {
    return shopper.stature * (0.0300F + 0.0030F * shopper.masculine + 0.0035F * shopper.build);
}

void addTorso(const Shopper& shopper, const Rig& rig, Mesh& mesh) {
    const TorsoMaker maker(shopper, rig);
    std::array<Ring, kTorso.size() + 5> rings;
    std::array<float, kTorso.size() + 5> shares{};
    // Seat of the trousers.
    std::size_t count = 0;
    for (const Level& level : kTorso) {
        if (level.height > kBeltHeight + 0.05F) break;
        shares[count] = 0.55F * (1.0F - smooth(-0.02F, 0.16F, level.height));
        rings[count] = maker.at(level, 0.6F * shopper.clothEase, shopper.trousers);
        rings[count].shade = 0.88F + 0.12F * smooth(0.0F, 0.2F, level.height);
        ++count;
    }
    const Material trousers = shopper.darkTrousers ? Material::darkCloth : Material::cloth;
    std::size_t first = addLoft(mesh, std::span(rings).first(count), kTorsoSegments, trousers, Cap::flat, Cap::open);
    followThighs(mesh, first, count, kTorsoSegments, shares);

    // Shirt: from a hem that stands off the hips a little, up to the collar.
    const Material shirt = shopper.darkShirt ? Material::darkCloth : Material::cloth;
    count = 0;
    const auto add = [&](const Level& level, float ease, float shade) {
        shares[count] = 0.30F * (1.0F - smooth(0.03F, 0.16F, level.height));
        rings[count] = maker.at(level, ease, shopper.shirt);
        rings[count].shade = shade;
        ++count;
    };
    const Level& hip = kTorso[2];
    const Level hem{kHemHeight, hip.width, hip.front, hip.back, hip.widthByBuild, hip.frontByBuild};
    add(hem, 0.4F * shopper.clothEase, 0.45F);  // The turned-in edge.
    add(hem, 1.9F * shopper.clothEase, 0.9F);
    for (const Level& level : kTorso) {
        if (level.height <= kHemHeight + 0.02F || level.height > 0.98F) continue;
        const float loose = 1.0F + 0.9F * (1.0F - smooth(0.1F, 0.6F, level.height));
        add(level, loose * shopper.clothEase, 1.0F);
    }
    // A round collar: lower in front, its edge turned in.
    const auto collar = [&](float width, float lift, float shade) {
        Ring ring = rings[count - 1];
        const float neck = neckRadius(shopper);
        ring.centre = rig.at(Bone::neck) + shopper.stature * Vector3f(0.0F, lift, 0.004F);
        ring.ahead = Vector3f(0.0F, -0.42F, 1.0F).normalized();
        ring.halfWidth = ring.front = ring.back = neck * width;
        ring.hold = TorsoMaker::hold(1.0F);
        ring.squareness = 2.0F;
        ring.shade = shade;
        rings[count++] = ring;
    };
    collar(1.30F, 0.006F, 1.0F);
    collar(1.22F, 0.009F, 0.90F);
    collar(1.06F, 0.004F, 0.5F);
    first = addLoft(mesh, std::span(rings).first(count), kTorsoSegments, shirt, Cap::open, Cap::open);
    followThighs(mesh, first, 3, kTorsoSegments, shares);

    // Neck and the skin that the collar leaves bare.
    count = 0;
    const float neck = neckRadius(shopper);
    const Vector3f base = rig.at(Bone::neck);
    const Vector3f top = rig.at(Bone::head) + Vector3f(0.0F, 0.03F * shopper.stature, 0.0F);
    constexpr std::array<float, 7> kNeckHeights = {-0.28F, -0.1F, 0.1F, 0.3F, 0.5F, 0.75F, 1.0F};
    constexpr std::array<float, 7> kNeckFlare = {1.45F, 1.22F, 1.08F, 1.01F, 1.0F, 1.0F, 1.0F};
    for (std::size_t i = 0; i < kNeckHeights.size(); ++i) {
        const float along = kNeckHeights[i];
        rings[count++] = {.centre = base + along * (top - base),
                          .halfWidth = neck * kNeckFlare[i],
                          .front = 0.95F * neck * (1.0F + 0.5F * (kNeckFlare[i] - 1.0F)),
                          .back = 1.02F * neck * (1.0F + 0.4F * (kNeckFlare[i] - 1.0F)),
                          .hold = along < 0.4F ? held(bone(Bone::chest), bone(Bone::neck), smooth(-0.3F, 0.4F, along))
                                               : held(bone(Bone::neck), bone(Bone::head), smooth(0.4F, 1.0F, along)),
                          .colour = shopper.skin,
                          // The chin keeps light from the throat.
                          .shade = 1.0F - 0.38F * smooth(0.2F, 0.8F, along)};
    }
    addLoft(mesh, std::span(rings).first(count), 28, Material::skin, Cap::open, Cap::open);
}

struct Station {
    float along;   ///< 0 at the limb's first joint, 1 at the second, 2 at the third.
    float radius;  ///< Share of the stature.
    float byBuild;
};

/// A limb of two bones through three joints.
struct Limb {
    Vector3f begin, middle, end;
    std::size_t root, upper, lower, tip;  ///< Bones: what it grows from, its two, what it ends in.
    float joint;                          ///< Half length of the bend, as a share of a bone.
    float rise;                           ///< How steeply its root climbs towards the middle of the body.

    [[nodiscard]] Vector3f at(float along) const {
        if (along < 0.0F) {
            const float length = (middle - begin).norm();
            return begin - along * length * Vector3f(begin.x() > 0.0F ? -0.93F : 0.93F, rise, 0.0F);
        }
        return along < 1.0F ? Vector3f(begin + along * (middle - begin))
                            : Vector3f(middle + (along - 1.0F) * (end - middle));
    }
    [[nodiscard]] Hold hold(float along) const {
        if (along < 0.5F) return held(root, upper, smooth(-0.16F, 0.14F, along));
        if (along < 1.5F) return held(upper, lower, smooth(1.0F - joint, 1.0F + joint, along));
        return held(lower, tip, smooth(1.6F, 2.0F, along));
    }
};

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
        const float radius = h * muscle * (station.radius + station.byBuild * shopper.build) + ease;
        Hold hold = limb.hold(station.along);
        if (station.along > 1.78F) {
            hold = held(bone(side, SideBone::forearmTwist), bone(side, SideBone::hand),
                        smooth(1.74F, 2.0F, station.along));
        } else if (station.along > 1.4F) {
            hold = held(limb.lower, limb.tip, smooth(1.2F, 1.74F, station.along));
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
        const float loose = longSleeves ? 1.0F : 1.0F + 0.5F * smooth(0.1F, 0.5F, station.along);
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

constexpr std::array<Station, 18> kLeg = {{{-0.14F, 0.034F, 0.006F},
                                           {-0.06F, 0.0445F, 0.010F},
                                           {0.04F, 0.0505F, 0.012F},
                                           {0.16F, 0.0520F, 0.013F},
                                           {0.30F, 0.0500F, 0.013F},
                                           {0.45F, 0.0465F, 0.011F},
                                           {0.60F, 0.0425F, 0.009F},
                                           {0.75F, 0.0385F, 0.007F},
                                           {0.88F, 0.0355F, 0.005F},
                                           {1.00F, 0.0345F, 0.004F},
                                           {1.10F, 0.0340F, 0.004F},
                                           {1.22F, 0.0345F, 0.005F},
                                           {1.38F, 0.0345F, 0.005F},
                                           {1.55F, 0.0315F, 0.004F},
                                           {1.70F, 0.0290F, 0.003F},
                                           {1.82F, 0.0278F, 0.002F},
                                           {1.90F, 0.0272F, 0.002F},
                                           {1.94F, 0.0270F, 0.002F}}};

/// Thighs bow forward and calves back.
float calfSet(float along) {
    return 0.006F * std::exp(-std::pow((along - 0.4F) / 0.3F, 2.0F)) -
           0.010F * std::exp(-std::pow((along - 1.35F) / 0.25F, 2.0F));
}

void addLeg(const Shopper& shopper, const Rig& rig, Side side, Mesh& mesh) {
    const Limb limb{.begin = rig.at(side, SideBone::thigh),
                    .middle = rig.at(side, SideBone::shin),
                    .end = rig.at(side, SideBone::foot),
                    .root = bone(Bone::pelvis),
                    .upper = bone(side, SideBone::thigh),
                    .lower = bone(side, SideBone::shin),
                    .tip = bone(side, SideBone::foot),
                    .joint = 0.16F,
                    .rise = 0.93F};
    const float h = shopper.stature;
    const float ease = 0.5F * shopper.clothEase;
    std::array<Ring, kLeg.size() + 3> rings;
    std::size_t count = 0;
    for (const Station& station : kLeg) {
        const float radius =
            h * (station.radius * (1.0F - 0.06F * (shopper.masculine - 0.5F)) + station.byBuild * shopper.build) +
            ease * (1.0F + 0.6F * smooth(1.0F, 2.0F, station.along));
        Hold hold = limb.hold(station.along);
        if (station.along >= 1.5F) hold = held(limb.lower, limb.tip, 0.35F * smooth(1.7F, 2.0F, station.along));
        const float inner = 0.88F + 0.12F * smooth(0.0F, 0.5F, station.along);
        rings[count++] = {.centre = limb.at(station.along) + Vector3f(0.0F, 0.0F, calfSet(station.along) * h),
                          .halfWidth = radius,
                          .front = radius,
                          .back = radius * 1.04F,
                          .hold = hold,
                          .colour = shopper.trousers,
                          .shade = inner};
    }
    rings[count] = rings[count - 1];  // The turned-in hem.
    rings[count].halfWidth *= 0.8F;
    rings[count].front *= 0.8F;
    rings[count].back *= 0.8F;
    rings[count++].shade = 0.35F;
    addLoft(mesh, std::span(rings).first(count), 24, shopper.darkTrousers ? Material::darkCloth : Material::cloth,
            Cap::open, Cap::open);

    // Sock.
    count = 0;
    for (const float along : {1.8F, 2.0F, 2.1F}) {
        rings[count++] = {.centre = limb.at(along),
                          .halfWidth = 0.022F * h,
                          .front = 0.023F * h,
                          .back = 0.024F * h,
                          .hold = held(limb.lower, limb.tip, along < 1.9F ? 0.0F : 1.0F),
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
            const float height = h * (sole ? top : section.height);
            const float x = outward * h * 0.006F * smooth(0.0F, 0.09F, section.ahead);
            rings[i] = {.centre = {ankle.x() + x, 0.5F * height, ankle.z() + h * section.ahead * (sole ? 1.03F : 1.0F)},
                        .across = Vector3f::UnitX(),
                        .ahead = Vector3f::UnitY(),
                        .halfWidth = h * section.halfWidth * grow,
                        .front = 0.5F * height,
                        .back = 0.5F * height,
                        .hold = held(bone(side, SideBone::foot)),
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
        const float near = 0.8F * smooth(0.085F * h, 0.030F * h, std::abs(p.y() - 0.495F * h));
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
        const float near = 0.8F * smooth(0.075F * h, 0.030F * h, (p - joint).norm());
        if (near <= 0.0F) continue;
        mesh.normals[i] = ((1.0F - near) * mesh.normals[i] + near * (p - centre).normalized()).normalized();
    }
}

}  // namespace

void buildFigure(const Shopper& shopper, const Rig& rig, Mesh& mesh) {
    mesh.clear();
    addTorso(shopper, rig, mesh);
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

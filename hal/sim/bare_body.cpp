#include "hal/sim/bare_body.h"

#include <algorithm>
#include <cmath>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::Side;

constexpr std::array<Station, kLegRingCount> kLeg = {{{-0.14F, 0.034F, 0.006F},
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

/// What `factors` make of a height on the trunk: those of hips, waist, chest and shoulders with smooth ways between
/// them, and nothing where the neck begins.
float between(const std::array<float, 4>& factors, float height) {
    constexpr std::array<float, 4> kHeights = {0.12F, kWaistHeight, kBustHeight, 0.86F};
    float factor = factors[0];
    for (std::size_t i = 1; i < kHeights.size(); ++i)
        factor += (factors[i] - factors[i - 1]) * smoothStep(kHeights[i - 1], kHeights[i], height);
    return factor + (1.0F - factor) * smoothStep(0.92F, 1.01F, height);
}

float bump(float height, float centre, float width) {
    return std::exp(-std::pow((height - centre) / width, 2.0F));
}

}  // namespace

const std::array<Level, kTrunkLevelCount> kTrunkLevels = {{
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

float smoothStep(float from, float to, float value) {
    const float u = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
    return u * u * (3.0F - 2.0F * u);
}

Hold heldBy(std::size_t first) {
    return {.first = static_cast<std::uint16_t>(first), .second = static_cast<std::uint16_t>(first), .share = 0.0F};
}
Hold heldBy(std::size_t first, std::size_t second, float share) {
    return {.first = static_cast<std::uint16_t>(first), .second = static_cast<std::uint16_t>(second), .share = share};
}

Trunk::Trunk(const Shopper& theShopper, const Rig& theRig)
    : shopper(theShopper),
      rig(theRig),
      crotch((0.475F + theShopper.shares.leg) * theShopper.stature + theShopper.lift),
      neckBase(theRig.at(Bone::neck).y()) {}

Ring Trunk::at(const Level& level, float ease, const Vector3f& colour) const {
    const float h = shopper.stature;
    const float build = shopper.build;
    const BodyShares& shares = shopper.shares;
    const float upper = smoothStep(0.35F, 0.8F, level.height);
    // Shoulders grow and hips shrink with masculinity; an average woman's bust and seat stand out more.
    const float sex = shopper.masculine - 0.5F;
    float width = level.width * (1.0F + sex * (0.17F * upper - 0.06F)) + level.widthByBuild * build;
    width *=
        between({shares.hipBreadth, shares.waistBreadth, shares.chestBreadth, shares.shoulderBreadth}, level.height);
    // Hips are never narrower than the thighs below them.
    const float thighs = rig.at(Side::left, SideBone::thigh).x() / h +
                         0.0505F * (1.0F - 0.06F * sex) * shares.legGirth + 0.013F * build * shares.legGirth;
    const bool overThighs = level.height > 0.02F && level.height < 0.25F;
    if (overThighs) width = std::max(width, thighs);
    const float bust = bump(level.height, kBustHeight, 0.09F);
    const float child = shopper.stature < 1.45F ? 0.0F : 1.0F;
    const float depth = between({shares.hipDepth, shares.waistDepth, shares.chestDepth, 1.0F}, level.height);
    float front = level.front + level.frontByBuild * std::max(build, 0.35F * build) - 0.012F * child * sex * bust;
    front = (front + shares.belly * bump(level.height, 0.36F, 0.15F) + shares.bust * bust) * depth;
    if (overThighs) front = std::max(front, (0.0575F + 0.013F * build) * shares.legGirth);
    const float seat = bump(level.height, 0.1F, 0.12F);
    float back = (level.back + 0.4F * level.frontByBuild * build - 0.008F * sex * seat + shares.seat * seat) * depth;
    // A thick neck has a nape that reaches down the back.
    back += smoothStep(0.86F, 0.97F, level.height) * neckRadius(shopper) / h * (1.0F - 1.0F / shares.neckGirth);
    const float y = crotch + level.height * (neckBase - crotch);
    return {.centre = {0.0F, y, -0.004F * h * upper},
            .halfWidth = width * h + ease,
            .front = front * h + ease,
            .back = back * h + ease,
            .hold = hold(level.height),
            .colour = colour,
            .squareness = shares.squareness};
}

Hold Trunk::hold(float height) {
    if (height > 0.9F) return heldBy(bone(Bone::chest), bone(Bone::neck), 0.7F * smoothStep(0.93F, 1.02F, height));
    return heldBy(bone(Bone::pelvis), bone(Bone::chest), smoothStep(0.12F, 0.68F, height));
}

Ring Trunk::section(float height, const Vector3f& colour) const {
    std::size_t above = 1;
    while (above + 1 < kTrunkLevels.size() && kTrunkLevels[above].height < height)
        ++above;
    const Level& low = kTrunkLevels[above - 1];
    const Level& high = kTrunkLevels[above];
    const float share = std::clamp((height - low.height) / (high.height - low.height), 0.0F, 1.0F);
    const Ring upper = at(high, 0.0F, colour);
    Ring ring = at(low, 0.0F, colour);
    ring.centre += share * (upper.centre - ring.centre);
    ring.halfWidth += share * (upper.halfWidth - ring.halfWidth);
    ring.front += share * (upper.front - ring.front);
    ring.back += share * (upper.back - ring.back);
    ring.hold = hold(height);
    return ring;
}

float neckRadius(const Shopper& shopper) {
    return shopper.stature * (0.0300F + 0.0030F * shopper.masculine + 0.0035F * shopper.build) *
           shopper.shares.neckGirth;
}

std::array<Ring, kNeckRingCount> neckRings(const Shopper& shopper, const Rig& rig) {
    std::array<Ring, kNeckRingCount> rings;
    const float radius = neckRadius(shopper);
    const Vector3f base = rig.at(Bone::neck);
    const Vector3f top = rig.at(Bone::head) + Vector3f(0.0F, 0.03F * shopper.stature, 0.0F);
    constexpr std::array<float, kNeckRingCount> kHeights = {-0.28F, -0.1F, 0.1F, 0.3F, 0.5F, 0.75F, 1.0F};
    constexpr std::array<float, kNeckRingCount> kFlare = {1.45F, 1.22F, 1.08F, 1.01F, 1.0F, 1.0F, 1.0F};
    for (std::size_t i = 0; i < kHeights.size(); ++i) {
        const float along = kHeights[i];
        // A thick neck is no wider where it ends below the shirt.
        const float own = smoothStep(-0.1F, 0.3F, along);
        const float neck = radius * (1.0F + (1.0F / shopper.shares.neckGirth - 1.0F) * (1.0F - own));
        rings[i] = {.centre = base + along * (top - base),
                    .halfWidth = neck * kFlare[i],
                    .front = 0.95F * neck * (1.0F + 0.5F * (kFlare[i] - 1.0F)),
                    .back = 1.02F * neck * (1.0F + 0.4F * (kFlare[i] - 1.0F)),
                    .hold = along < 0.4F ? heldBy(bone(Bone::chest), bone(Bone::neck), smoothStep(-0.3F, 0.4F, along))
                                         : heldBy(bone(Bone::neck), bone(Bone::head), smoothStep(0.4F, 1.0F, along)),
                    .colour = shopper.skin,
                    // The chin keeps light from the throat.
                    .shade = 1.0F - 0.38F * smoothStep(0.2F, 0.8F, along)};
    }
    return rings;
}

Vector3f Limb::at(float along) const {
    if (along < 0.0F) {
        const float length = (middle - begin).norm();
        return begin - along * length * Vector3f(begin.x() > 0.0F ? -0.93F : 0.93F, rise, 0.0F);
    }
    return along < 1.0F ? Vector3f(begin + along * (middle - begin))
                        : Vector3f(middle + (along - 1.0F) * (end - middle));
}

Hold Limb::hold(float along) const {
    if (along < 0.5F) return heldBy(root, upper, smoothStep(-0.16F, 0.14F, along));
    if (along < 1.5F) return heldBy(upper, lower, smoothStep(1.0F - joint, 1.0F + joint, along));
    return heldBy(lower, tip, smoothStep(1.6F, 2.0F, along));
}

Limb legOf(const Rig& rig, Side side) {
    return {.begin = rig.at(side, SideBone::thigh),
            .middle = rig.at(side, SideBone::shin),
            .end = rig.at(side, SideBone::foot),
            .root = bone(Bone::pelvis),
            .upper = bone(side, SideBone::thigh),
            .lower = bone(side, SideBone::shin),
            .tip = bone(side, SideBone::foot),
            .joint = 0.16F,
            .rise = 0.93F};
}

std::array<Ring, kLegRingCount> legRings(const Shopper& shopper, const Rig& rig, Side side, float ease) {
    const Limb limb = legOf(rig, side);
    const float h = shopper.stature;
    std::array<Ring, kLegRingCount> rings;
    for (std::size_t i = 0; i < kLegRingCount; ++i) {
        const Station& station = kLeg[i];
        const float radius =
            h * (station.radius * (1.0F - 0.06F * (shopper.masculine - 0.5F)) + station.byBuild * shopper.build) *
                shopper.shares.legGirth +
            ease * (1.0F + 0.6F * smoothStep(1.0F, 2.0F, station.along));
        Hold hold = limb.hold(station.along);
        if (station.along >= 1.5F) hold = heldBy(limb.lower, limb.tip, 0.35F * smoothStep(1.7F, 2.0F, station.along));
        const float inner = 0.88F + 0.12F * smoothStep(0.0F, 0.5F, station.along);
        rings[i] = {.centre = limb.at(station.along) + Vector3f(0.0F, 0.0F, calfSet(station.along) * h),
                    .halfWidth = radius,
                    .front = radius,
                    .back = radius * 1.04F,
                    .hold = hold,
                    .colour = shopper.trousers,
                    .shade = inner};
    }
    return rings;
}

}  // namespace cheval::hal::sim

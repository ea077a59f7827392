// People whose girths are known: spread as those of a population, with shapes of their own.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "hal/sim/hash.h"
#include "hal/sim/shopper.h"
#include "hal/sim/tape.h"

namespace cheval::hal::sim {

namespace {

using fitting::Dimension;

/// Mean and standard deviation, metres.
struct Spread {
    float mean, deviation;
};
/// Grown-ups of one sex, about as surveys of the last decades have them (NHANES, SizeGERMANY).
struct Population {
    Spread stature, chest, waist, hips;
    float masculine;
};
constexpr Population kWomen{{1.63F, 0.065F}, {0.94F, 0.100F}, {0.78F, 0.110F}, {1.02F, 0.090F}, 0.14F};
constexpr Population kMen{{1.76F, 0.070F}, {1.02F, 0.090F}, {0.90F, 0.110F}, {1.01F, 0.075F}, 0.88F};

/// About normal, mean 0, deviation 1, never beyond 2.8 (Box and Muller, cut).
float normal(Draw& draw) {
    const float radius = std::sqrt(-2.0F * std::log(1.0F - 0.9999F * draw.between(0.0F, 1.0F)));
    const float angle = 2.0F * std::numbers::pi_v<float> * draw.between(0.0F, 1.0F);
    return std::clamp(radius * std::cos(angle), -2.8F, 2.8F);
}

/// Who is heavy is so all over: girths go together by `fat`, a little with stature, and each for itself. They reach
/// farther up than down, as those of a population do.
float girth(Draw& draw, const Spread& spread, float fat, float tall, float own) {
    const float along = std::sqrt(1.0F - own * own - 0.15F * 0.15F);
    const float even = along * fat + 0.15F * tall + own * normal(draw);
    constexpr float kSkew = 0.15F;
    const float skewed = (even + kSkew * (even * even - 1.0F)) / std::sqrt(1.0F + 2.0F * kSkew * kSkew);
    return spread.mean + spread.deviation * std::max(skewed, -2.0F);
}

/// Makes chest, waist and hips those lengths, keeping how broad each is for its depth.
void fitGirths(Shopper& shopper, const std::array<float, 3>& girths) {
    constexpr std::array<Dimension, 3> kGirths = {Dimension::chestGirth, Dimension::waistGirth, Dimension::hipGirth};
    const std::array<std::array<float*, 2>, 3> factors = {{{&shopper.shares.chestBreadth, &shopper.shares.chestDepth},
                                                           {&shopper.shares.waistBreadth, &shopper.shares.waistDepth},
                                                           {&shopper.shares.hipBreadth, &shopper.shares.hipDepth}}};
    constexpr int kRounds = 5;
    for (int round = 0; round < kRounds; ++round) {
        const TrueMeasurements measured = measureBare(shopper);
        for (std::size_t i = 0; i < girths.size(); ++i) {
            const float more = girths[i] / measured[static_cast<std::size_t>(kGirths[i])];
            // Thighs are part of the hips: they grow with them.
            if (kGirths[i] == Dimension::hipGirth) shopper.shares.legGirth *= 1.0F + 0.7F * (more - 1.0F);
            for (float* factor : factors[i])
                *factor *= more;
        }
    }
}

void shapeAdult(Draw& draw, Shopper& shopper) {
    const bool woman = draw.choice(2) == 0;
    const Population& people = woman ? kWomen : kMen;
    const float tall = normal(draw);
    shopper.stature = std::max(1.47F, people.stature.mean + people.stature.deviation * tall);
    // From a BMI of about 18 to about 36.
    const float fat = std::clamp(normal(draw), -1.9F, 2.6F);
    const std::array<float, 3> girths = {girth(draw, people.chest, fat, tall, 0.40F),
                                         girth(draw, people.waist, fat, tall, 0.35F),
                                         girth(draw, people.hips, fat, tall, 0.40F)};
    shopper.headHeight = shopper.stature * draw.between(0.124F, 0.135F);
    shopper.masculine = people.masculine + 0.05F * normal(draw);
    shopper.build = std::clamp(0.38F * fat, -0.8F, 1.0F);
    BodyShares& shares = shopper.shares;
    shares.squareness = std::clamp(2.2F + 0.14F * normal(draw), 1.9F, 2.6F);
    shares.bust = woman ? std::max(-0.004F, 0.006F + 0.007F * (0.5F * fat + normal(draw))) : 0.003F * normal(draw);
    shares.belly = std::max(0.0F, (woman ? 0.005F : 0.008F) * (fat + normal(draw)));
    shares.seat = (woman ? 0.006F : 0.005F) + 0.003F * normal(draw);
    const auto broader = [&](float deviation, float& breadth, float& depth) {
        const float ratio = deviation * normal(draw);
        breadth = 1.0F + ratio;
        depth = 1.0F - ratio;
    };
    broader(0.045F, shares.chestBreadth, shares.chestDepth);
    broader(0.055F, shares.waistBreadth, shares.waistDepth);
    broader(0.045F, shares.hipBreadth, shares.hipDepth);
    shares.shoulderBreadth = 1.0F + 0.035F * normal(draw) + 0.01F * fat;
    shares.neckGirth = (woman ? 1.04F : 1.05F) + 0.03F * normal(draw) + 0.02F * fat;
    shares.armGirth = 1.0F + 0.06F * normal(draw);
    shares.legGirth = 1.0F + 0.03F * normal(draw);
    shares.armLength = 0.98F + 0.03F * normal(draw);
    // Crotches at about 0.47 of a woman's stature and 0.475 of a man's.
    shares.leg = (woman ? 0.010F : 0.016F) + std::clamp(0.009F * normal(draw), -0.02F, 0.02F);
    shares.neckLength = 0.004F * normal(draw);
    shares.stoop = std::clamp(0.02F + 0.035F * normal(draw), -0.04F, 0.12F);
    fitGirths(shopper, girths);
    // Shoulders follow the chest, or clothes would hang from a hanger.
    shares.shoulderBreadth *= 1.0F + 0.25F * (shares.chestBreadth - 1.0F);
}

void shapeChild(Draw& draw, Shopper& shopper) {
    shopper.stature = draw.between(1.05F, 1.42F);
    shopper.headHeight = shopper.stature * draw.between(0.152F, 0.170F);
    shopper.masculine = 0.45F;
    shopper.build = draw.between(-0.8F, 0.2F);
    shopper.shares.leg = draw.between(-0.02F, 0.0F);
}

void dress(Draw& draw, Clothing clothing, Shopper& shopper) {
    const auto soles = [&](float least, float most) { shopper.lift = draw.between(least, most); };
    shopper.clothEase = draw.between(0.006F, 0.014F);
    shopper.drape.phase = draw.between(0.0F, 6.28F);
    switch (clothing) {
        case Clothing::bare:
            shopper = bareOf(shopper);
            break;
        case Clothing::tight:
            shopper.clothEase = draw.between(0.0F, 0.004F);
            soles(0.0F, 0.015F);
            break;
        case Clothing::ordinary:
            soles(0.010F, 0.030F);
            break;
        case Clothing::loose:
            shopper.clothEase = draw.between(0.006F, 0.014F);
            // A jumper narrows towards its hem, a shirt falls straight, an open coat widens.
            shopper.drape.ease = draw.between(0.008F, 0.020F);
            shopper.drape.flare = draw.between(-0.07F, 0.06F);
            shopper.drape.hem = draw.between(-0.10F, 0.06F);
            shopper.drape.folds = draw.between(0.006F, 0.014F);
            shopper.sleeves = draw.choice(3) == 0 ? Sleeves::shortSleeves : Sleeves::longSleeves;
            shopper.trouserEase = draw.between(0.003F, 0.009F);
            soles(0.015F, 0.035F);
            break;
        case Clothing::wide:
            shopper.clothEase = draw.between(0.018F, 0.030F);
            shopper.drape.ease = draw.between(0.060F, 0.120F);
            shopper.drape.flare = draw.between(0.08F, 0.20F);
            shopper.drape.hem = -0.17F * shopper.stature;
            shopper.drape.folds = draw.between(0.015F, 0.035F);
            shopper.sleeves = Sleeves::longSleeves;
            shopper.trouserEase = draw.between(0.005F, 0.014F);
            soles(0.015F, 0.035F);
            break;
    }
}

}  // namespace

Shopper makeMeasuredShopper(std::uint32_t seed, std::uint32_t visit, Clothing clothing, bool everybody) {
    Draw draw(scramble(scramble(seed, 0x7a9eU), visit));
    // Colours, hair and ways of the people of the other scripts.
    Shopper shopper = makeShopper(draw.choice(1U << 20U), draw.choice(6));
    if (everybody && draw.choice(8) == 0) {
        shapeChild(draw, shopper);
    } else {
        shapeAdult(draw, shopper);
        shopper.wheelchair = everybody && draw.choice(16) == 0;
    }
    constexpr std::array<HairStyle, 5> kStyles = {HairStyle::none, HairStyle::cropped, HairStyle::parted,
                                                  HairStyle::bob, HairStyle::ponytail};
    const bool longHair = shopper.masculine < 0.5F;
    // Bald, cropped or parted; hardly any woman is bald.
    shopper.hairStyle = kStyles[longHair ? 1 + draw.choice(4) : draw.choice(3)];
    shopper.hairRise = draw.choice(2) == 0 ? 0.0F : draw.between(0.0F, 0.016F);
    dress(draw, clothing, shopper);
    return shopper;
}

Shopper bareOf(const Shopper& shopper) {
    Shopper bare = shopper;
    bare.clothEase = 0.0F;
    bare.trouserEase = 0.0F;
    bare.drape = {};
    bare.hairStyle = HairStyle::none;
    bare.hairRise = 0.0F;
    bare.lift = 0.0F;
    bare.sleeves = Sleeves::shortSleeves;
    bare.shirt = bare.trousers = bare.shoes = bare.sole = bare.skin;
    bare.darkShirt = bare.darkTrousers = false;
    bare.wheelchair = false;
    return bare;
}

}  // namespace cheval::hal::sim

#include "hal/sim/shopper.h"

#include <array>
#include <cstddef>

#include "hal/sim/hash.h"

namespace cheval::hal::sim {

namespace {

using Colour = std::array<float, 3>;

struct Kind {
    float shortest, tallest;
    float build;
    float masculine;
    float headShare;  ///< Of the stature; children have large heads.
    std::array<HairStyle, 2> hair;
};

constexpr std::array<Kind, 6> kKinds = {{
    {1.60F, 1.70F, -0.15F, 0.15F, 0.131F, {HairStyle::ponytail, HairStyle::bob}},
    {1.74F, 1.82F, 0.05F, 0.90F, 0.128F, {HairStyle::parted, HairStyle::cropped}},
    {1.22F, 1.38F, -0.55F, 0.45F, 0.158F, {HairStyle::bob, HairStyle::parted}},
    {1.70F, 1.80F, 0.90F, 0.95F, 0.131F, {HairStyle::cropped, HairStyle::parted}},
    {1.68F, 1.76F, -0.75F, 0.10F, 0.128F, {HairStyle::bob, HairStyle::ponytail}},
    {1.86F, 1.95F, -0.25F, 0.85F, 0.124F, {HairStyle::parted, HairStyle::cropped}},
}};
constexpr std::array<Colour, 6> kSkin = {{{0.93F, 0.76F, 0.67F},
                                          {0.86F, 0.67F, 0.54F},
                                          {0.74F, 0.54F, 0.41F},
                                          {0.58F, 0.40F, 0.29F},
                                          {0.44F, 0.30F, 0.22F},
                                          {0.90F, 0.71F, 0.60F}}};
constexpr std::array<Colour, 5> kHair = {{{0.16F, 0.12F, 0.11F},
                                          {0.30F, 0.20F, 0.14F},
                                          {0.45F, 0.31F, 0.19F},
                                          {0.66F, 0.52F, 0.33F},
                                          {0.58F, 0.57F, 0.56F}}};
constexpr std::array<Colour, 6> kShirts = {{{0.78F, 0.80F, 0.82F},
                                            {0.55F, 0.66F, 0.75F},
                                            {0.76F, 0.60F, 0.55F},
                                            {0.60F, 0.68F, 0.58F},
                                            {0.84F, 0.78F, 0.66F},
                                            {0.27F, 0.29F, 0.34F}}};
constexpr std::array<Colour, 5> kTrousers = {{{0.26F, 0.33F, 0.45F},
                                              {0.36F, 0.37F, 0.40F},
                                              {0.66F, 0.58F, 0.46F},
                                              {0.40F, 0.42F, 0.33F},
                                              {0.20F, 0.21F, 0.24F}}};
constexpr std::array<Colour, 3> kShoes = {{{0.88F, 0.87F, 0.85F}, {0.45F, 0.31F, 0.22F}, {0.22F, 0.22F, 0.24F}}};

template <std::size_t N>
Eigen::Vector3f pick(Draw& draw, const std::array<Colour, N>& colours) {
    const Colour& colour = colours[draw.choice(static_cast<std::uint32_t>(N))];
    return {colour[0], colour[1], colour[2]};
}

bool isDark(const Eigen::Vector3f& colour) {
    return colour.maxCoeff() < 0.36F;
}

}  // namespace

Shopper makeShopper(std::uint32_t seed, std::uint32_t visit) {
    Draw draw(scramble(seed, visit));
    const Kind& kind = kKinds[(seed + visit) % kKinds.size()];
    Shopper shopper;
    shopper.stature = draw.between(kind.shortest, kind.tallest);
    shopper.headHeight = shopper.stature * kind.headShare * draw.between(0.985F, 1.015F);
    shopper.build = kind.build + draw.between(-0.1F, 0.1F);
    shopper.masculine = kind.masculine;
    shopper.clothEase = draw.between(0.006F, 0.014F);
    shopper.hairStyle = kind.hair[draw.choice(2)];
    shopper.sleeves = draw.choice(3) == 0 ? Sleeves::longSleeves : Sleeves::shortSleeves;
    shopper.skin = pick(draw, kSkin);
    // Light hair does not grow on dark skin.
    shopper.hair = pick(draw, kHair);
    if (shopper.skin.x() < 0.7F) shopper.hair = {kHair[0][0], kHair[0][1], kHair[0][2]};
    shopper.shirt = pick(draw, kShirts);
    shopper.trousers = pick(draw, kTrousers);
    shopper.shoes = pick(draw, kShoes);
    shopper.sole = isDark(shopper.shoes) ? Eigen::Vector3f(0.15F, 0.15F, 0.16F) : Eigen::Vector3f(0.93F, 0.92F, 0.90F);
    shopper.darkTrousers = isDark(shopper.trousers);
    shopper.darkShirt = isDark(shopper.shirt);
    shopper.entryDepth = draw.between(3.1F, 3.5F);
    shopper.exitSide = draw.choice(2) == 0 ? -1.0F : 1.0F;
    return shopper;
}

Shopper makeMannequin(std::uint32_t key) {
    Draw draw(key);
    // Slim grown-ups: the second and the fifth of the six kinds.
    // Slim grown-ups: the second and the fifth of the six kinds.
    Shopper mannequin = makeShopper(0, 6 * draw.choice(1000) + (draw.choice(2) == 0 ? 4 : 1));
    mannequin.hairStyle = HairStyle::none;
    mannequin.skin = {0.86F, 0.84F, 0.80F};
    mannequin.hair = mannequin.skin;
    return mannequin;
}

}  // namespace cheval::hal::sim

// Who comes: proportions and clothes of one visitor, drawn from the world's seed and the number of the visit.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "hal/sim/clothing.h"

namespace cheval::hal::sim {

/// What a surface is to the sensor.
enum class Material : std::uint8_t { room, skin, cloth, darkCloth, hair, shoe, glossy };

enum class HairStyle : std::uint8_t { cropped, parted, bob, ponytail, none };
enum class Sleeves : std::uint8_t { shortSleeves, longSleeves };

/// How a body departs from what its stature, build and sex would give it; as it stands here it departs in nothing.
/// Factors are of that expectation, shares of the stature. Breadths and depths pass smoothly from one level to the
/// next.
struct BodyShares {
    float shoulderBreadth = 1.0F, chestBreadth = 1.0F, waistBreadth = 1.0F, hipBreadth = 1.0F;
    float chestDepth = 1.0F, waistDepth = 1.0F, hipDepth = 1.0F;
    float bust = 0.0F, belly = 0.0F, seat = 0.0F;  ///< Shares by which they stand out.
    float squareness = 2.25F;                      ///< Of the trunk's sections, as Ring::squareness.
    float neckGirth = 1.0F, armGirth = 1.0F, legGirth = 1.0F;
    float armLength = 1.0F;
    float leg = 0.0F;         ///< Share by which legs are longer and the trunk shorter.
    float neckLength = 0.0F;  ///< Share.
    float stoop = 0.0F;       ///< Radians by which the chest leans forward and the head back.
};

/// Cloth that rests on shoulders and chest and falls from there.
struct Drape {
    float ease = 0.0F;   ///< Metres from skin to cloth at the chest; 0: there is none, cloth follows the body.
    float hem = 0.0F;    ///< Metres above the crotch; negative: below.
    float flare = 0.0F;  ///< Metres by which each half widens on a metre's fall.
    float folds = 0.0F;  ///< Metres that folds stand out at the hem, at most.
    float phase = 0.0F;  ///< Radians, where the folds are.
};

/// Colours are sRGB, 0…1. Lengths are metres, heights above the floor in shoes.
struct Shopper {
    float stature = 1.72F;  ///< Floor to crown, without hair.
    float headHeight = 0.22F;
    float build = 0.0F;       ///< −1 slim … 1 heavy.
    float masculine = 0.5F;   ///< Shoulders against hips.
    float clothEase = 0.01F;  ///< Distance of cloth from skin.
    HairStyle hairStyle = HairStyle::cropped;
    Sleeves sleeves = Sleeves::shortSleeves;
    Eigen::Vector3f skin, hair, shirt, trousers, shoes, sole;
    bool darkTrousers = false;
    bool darkShirt = false;
    bool wheelchair = false;
    float entryDepth = 3.3F;  ///< Metres from the glass where the shopper comes into the room.
    float exitSide = -1.0F;   ///< Sign of the mirror frame's x at which they leave.
    // What only makeMeasuredShopper departs from.
    BodyShares shares;
    Drape drape;
    float trouserEase = 0.0F;  ///< Added to what clothEase gives trousers.
    float hairRise = 0.0F;     ///< Hair above the crown, added to what its style has.
    float lift = 0.0F;         ///< Soles that lift the wearer: the crown is at stature + lift. Else they count in it.
};

/// Six kinds of people take turns (child to tall adult, slim to heavy), each drawn anew.
Shopper makeShopper(std::uint32_t seed, std::uint32_t visit);
/// Adults whose girths are spread and go together as a population's do, each with a shape of their own; `everybody`:
/// children and wheelchair users are among them.
Shopper makeMeasuredShopper(std::uint32_t seed, std::uint32_t visit, Clothing clothing, bool everybody);
/// The same body without clothes, shoes and hair.
Shopper bareOf(const Shopper& shopper);
/// A shop mannequin: an adult of one pale colour without hair, dressed.
Shopper makeMannequin(std::uint32_t key);

}  // namespace cheval::hal::sim

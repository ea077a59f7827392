// Who comes: proportions and clothes of one visitor, drawn from the world's seed and the number of the visit.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace cheval::hal::sim {

/// What a surface is to the sensor.
enum class Material : std::uint8_t { room, skin, cloth, darkCloth, hair, shoe, glossy };

enum class HairStyle : std::uint8_t { cropped, parted, bob, ponytail, none };
enum class Sleeves : std::uint8_t { shortSleeves, longSleeves };

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
};

/// Six kinds of people take turns (child to tall adult, slim to heavy), each drawn anew.
Shopper makeShopper(std::uint32_t seed, std::uint32_t visit);
/// A shop mannequin: an adult of one pale colour without hair, dressed.
Shopper makeMannequin(std::uint32_t key);

}  // namespace cheval::hal::sim

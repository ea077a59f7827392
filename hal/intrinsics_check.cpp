#include "hal/intrinsics_check.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace cheval::hal {
namespace {

constexpr float kRadiansPerDegree = std::numbers::pi_v<float> / 180.0F;

/// The focal length, in pixels, that sees this angle over so many pixels.
float focalLength(int pixels, float degrees) {
    return static_cast<float>(pixels) / (2.0F * std::tan(0.5F * degrees * kRadiansPerDegree));
}

std::string whole(float value) {
    return std::to_string(std::lround(value));
}

/// One axis: its number of pixels, focal length and principal point, each with its key.
struct Axis {
    const char* sizeKey;
    int size;
    const char* focalKey;
    float focal;
    const char* centreKey;
    float centre;
    const char* direction;
};

Error refusal(const char* key, std::string cause, std::string mend, std::string why) {
    return {.code = ErrorCode::invalidInput,
            .cause = std::move(cause),
            .mend = std::move(mend),
            .why = std::move(why),
            .key = key};
}

Expected<void> check(const Axis& axis) {
    const std::string pixels = std::to_string(axis.size) + " pixels";
    if (axis.size < 1)
        return refusal(axis.sizeKey, "the picture has " + pixels, "give its size", "there is nothing to see in it");
    const float shortest = focalLength(axis.size, kWidestViewDeg);
    const float longest = focalLength(axis.size, kNarrowestViewDeg);
    const std::string range = "a focal length of " + whole(std::ceil(shortest)) + " to " + whole(std::floor(longest)) +
                              " pixels, for a picture of this size";
    // Not a number is in no range.
    if (!(axis.focal > 0.0F) || !std::isfinite(axis.focal))
        return refusal(axis.focalKey, "the focal length is no positive number", "give " + range, "a lens has one");
    if (axis.focal < shortest || axis.focal > longest) {
        const float seen = 2.0F * std::atan(0.5F * static_cast<float>(axis.size) / axis.focal) / kRadiansPerDegree;
        return refusal(axis.focalKey,
                       "a focal length of " + whole(axis.focal) + " would see " + whole(seen) + " degrees " +
                           axis.direction + " a picture of " + pixels,
                       "give " + range,
                       "depth sensors see " + whole(kNarrowestViewDeg) + " to " + whole(kWidestViewDeg) +
                           " degrees; is it the calibration of another resolution, or one in millimetres?");
    }
    if (!(axis.centre >= 0.0F && axis.centre <= static_cast<float>(axis.size - 1))) {
        return refusal(axis.centreKey, "the centre lies outside the picture",
                       "give a centre from 0 to " + std::to_string(axis.size - 1) + ", near the middle",
                       "a sensor looks to where its lens points; is it the calibration of another resolution?");
    }
    return {};
}

}  // namespace

Expected<void> checkIntrinsics(const Intrinsics& intrinsics) {
    Expected<void> across = check({"width", intrinsics.width, "fx", intrinsics.fx, "cx", intrinsics.cx, "across"});
    if (!across) return across;
    return check({"height", intrinsics.height, "fy", intrinsics.fy, "cy", intrinsics.cy, "up"});
}

}  // namespace cheval::hal

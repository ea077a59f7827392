// What a depth sensor delivers. Sensor frame of reference (OpenNI2): millimetres, x to the right of an unmirrored
// picture, y up, z away from the sensor; left-handed. Pixel of a point: u = cx + fx·x/z, v = cy − fy·y/z.
#pragma once

#include <cstdint>

#include "hal/clock.h"
#include "hal/image.h"

namespace cheval::hal {

/// Pinhole camera, lens distortion already removed by the device. Pixel centres lie at whole numbers.
struct Intrinsics {
    int width = 640;
    int height = 480;
    float fx = 570.3F;
    float fy = 570.3F;
    float cx = 319.5F;
    float cy = 239.5F;
};

/// How a technician hung the sensor. A starting value: tracking refines it from the floor that it sees.
struct Mount {
    float heightMm = 1250.0F;  ///< Optical centre above the floor.
    float tiltDeg = 0.0F;      ///< Positive looks up.
    float rollDeg = 0.0F;      ///< Positive turns the picture's content anticlockwise (as `../data/shoppers` does).
    bool known = false;        ///< False: nothing was written down.
};

/// One depth picture, lent by the camera until its next call. Depth is registered to no other picture; colour, where
/// there is any, is registered to depth (pixel for pixel, same size).
struct DepthFrame {
    std::uint64_t sequence = 0;  ///< Counts what the device captured; a step of more than one is a loss.
    std::uint64_t sourceIndex =
        0;  ///< Replay: position in the recording, from 0; a repeated still keeps it. Else = sequence.
    TimePoint captureTime{};   ///< Middle of the exposure.
    bool restart = false;      ///< Does not follow the frame before in time (reopened, or a still): forget all state.
    bool lastOfStill = false;  ///< The last repetition of a still; true for every frame of a continuous recording.
    Intrinsics intrinsics;
    ImageView<const std::uint16_t> depth;  ///< Millimetres along z; 0 = no reading.
    ImageView<const Rgb8> colour;          ///< Empty where the sensor has none.
};

}  // namespace cheval::hal

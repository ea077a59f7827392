// How a structured-light depth sensor (PrimeSense, Kinect v1) spoils a perfect depth picture: disparity noise and
// quantisation (Khoshelham & Elberink, Sensors 12(2), 2012), the projector's shadow, and readings that fail at edges,
// at grazing angles, in hair and on dark cloth.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/frame.h"
#include "hal/image.h"
#include "hal/sim/canvas.h"
#include "hal/sim/room.h"
#include "hal/sim/shopper.h"

namespace cheval::hal::sim {

inline constexpr float kBaselineMm = 75.0F;       ///< The projector sits this far to the right of the camera.
inline constexpr float kDisparityStep = 0.125F;   ///< Pixels.
inline constexpr float kDisparityNoise = 0.062F;  ///< Standard deviation in pixels; half its variance never changes.
inline constexpr float kNearestMm = 400.0F;
inline constexpr float kFarthestMm = 6000.0F;

/// Turns exact depth into readings. Thread-bound; takes memory when made, never when used. The result is a function of
/// the scene, the key and the frame alone.
class SensorModel {
  public:
    /// `noiseScale` times the noise and the chances of failure of the sensor in the literature.
    SensorModel(const Intrinsics& intrinsics, const Room& room, std::uint32_t key, float noiseScale = 1.0F);

    /// Readings of frame `frame` into `readings`. The scene is `depth` (millimetres, exact) and `material`; it differs
    /// from the empty room only within `changed`.
    void sense(const Image<float>& depth, const Image<Material>& material, const PixelBox& changed, std::uint64_t frame,
               ImageView<std::uint16_t> readings);

  private:
    /// Works out a row's disparities and chances of failure from column `from` up to `to`; elsewhere `disparity` must
    /// hold the room's.
    void prepareRow(const Image<float>& depth, const Image<Material>& material, int y, int from, int to,
                    float* disparity, std::uint16_t* failure);
    void senseRow(int y, std::uint32_t frameKey, const float* disparity, const std::uint16_t* failure,
                  std::uint16_t* readings);

    Intrinsics intrinsics_;
    std::uint32_t key_;
    float noiseScale_;
    float focalBaseline_;                     ///< Disparity times depth.
    std::vector<float> fixedNoise_;           ///< Disparity, a pixel.
    std::vector<float> roomDisparity_;        ///< 0: never a reading.
    std::vector<std::uint16_t> roomFailure_;  ///< Chance of no reading, of 65 535.
    std::vector<float> rowDisparity_;
    std::vector<std::uint16_t> rowFailure_;
    std::vector<float> projector_;  ///< One row as the projector sees it: the nearest disparity in each column.
    std::vector<float> noise_;
};

}  // namespace cheval::hal::sim

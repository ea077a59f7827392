// Where the simulated sensor hangs and what it sees: mirror frame to picture.
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "hal/frame.h"

namespace cheval::hal::sim {

/// A pinhole view of the mirror frame. Immutable.
class View {
  public:
    View(const Intrinsics& intrinsics, const Mount& mount) : intrinsics_(intrinsics) {
        const float tilt = mount.tiltDeg * std::numbers::pi_v<float> / 180.0F;
        const float roll = mount.rollDeg * std::numbers::pi_v<float> / 180.0F;
        Eigen::Matrix3f nod;
        nod << 1.0F, 0.0F, 0.0F, 0.0F, std::cos(tilt), std::sin(tilt), 0.0F, -std::sin(tilt), std::cos(tilt);
        Eigen::Matrix3f lean;
        lean << std::cos(roll), -std::sin(roll), 0.0F, std::sin(roll), std::cos(roll), 0.0F, 0.0F, 0.0F, 1.0F;
        // Mirror x runs against sensor x.
        const Eigen::Matrix3f flip = Eigen::Vector3f(-1.0F, 1.0F, 1.0F).asDiagonal();
        toMirror_ = flip * nod * lean;
        place_ = {0.0F, mount.heightMm * 1e-3F, 0.0F};
    }

    [[nodiscard]] const Intrinsics& intrinsics() const { return intrinsics_; }
    /// The sensor's place, metres of the mirror frame.
    [[nodiscard]] const Eigen::Vector3f& place() const { return place_; }
    /// Metres in axes of the sensor; z is what a depth sensor reports.
    [[nodiscard]] Eigen::Vector3f toSensor(const Eigen::Vector3f& mirror) const {
        return toMirror_.transpose() * (mirror - place_);
    }
    [[nodiscard]] Eigen::Vector3f toMirror(const Eigen::Vector3f& sensor) const { return toMirror_ * sensor + place_; }
    /// Pixel of a point in axes of the sensor.
    [[nodiscard]] Eigen::Vector2f project(const Eigen::Vector3f& sensor) const {
        return {intrinsics_.cx + intrinsics_.fx * sensor.x() / sensor.z(),
                intrinsics_.cy - intrinsics_.fy * sensor.y() / sensor.z()};
    }
    /// Direction of a pixel's ray in the mirror frame, one metre deep along the optical axis.
    [[nodiscard]] Eigen::Vector3f ray(float u, float v) const {
        return toMirror_ *
               Eigen::Vector3f((u - intrinsics_.cx) / intrinsics_.fx, (intrinsics_.cy - v) / intrinsics_.fy, 1.0F);
    }

  private:
    Intrinsics intrinsics_;
    Eigen::Matrix3f toMirror_;
    Eigen::Vector3f place_;
};

}  // namespace cheval::hal::sim

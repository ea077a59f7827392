#include "render/mirror_mapping.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace cheval::render {
namespace {

/// A shopper may sway by this part of the crop's width before the picture moves: a mirror that never rests is seasick.
constexpr float kDeadBand = 0.08F;
constexpr double kFollowSeconds = 0.35;
/// A longer gap than this is another scene, not a walk.
constexpr double kGapSeconds = 1.0;

}  // namespace

Turn uprightTurn(bool rotated, const fitting::SensorPlacement& placement) {
    // The mirror frame's up as the sensor sees it: x right, y up in the unmirrored picture.
    const Eigen::Vector3f up = placement.rotation.transpose() * Eigen::Vector3f::UnitY();
    if (rotated) return up.x() >= 0.0F ? Turn::left : Turn::right;
    return up.y() >= 0.0F ? Turn::none : Turn::half;
}

Eigen::Vector2i MirrorMapping::sensorPixel(int x, int y) const {
    switch (turn) {
        case Turn::none:
            return {pictureWidth - 1 - x, y};
        case Turn::half:
            return {x, pictureHeight - 1 - y};
        case Turn::left:
            return {pictureWidth - 1 - y, pictureHeight - 1 - x};
        case Turn::right:
            break;
    }
    return {y, x};
}

Eigen::Matrix3f MirrorMapping::displayFromSensor() const {
    const auto width = static_cast<float>(pictureWidth);
    const auto height = static_cast<float>(pictureHeight);
    Eigen::Matrix3f mirrored = Eigen::Matrix3f::Zero();
    mirrored(2, 2) = 1.0F;
    switch (turn) {
        case Turn::none:
            mirrored.topRows<2>() << -1, 0, width - 0.5F, 0, 1, 0.5F;
            break;
        case Turn::half:
            mirrored.topRows<2>() << 1, 0, 0.5F, 0, -1, height - 0.5F;
            break;
        case Turn::left:
            mirrored.topRows<2>() << 0, -1, height - 0.5F, -1, 0, width - 0.5F;
            break;
        case Turn::right:
            mirrored.topRows<2>() << 0, 1, 0.5F, 1, 0, 0.5F;
            break;
    }
    Eigen::Matrix3f crop;
    crop << scale, 0, -cropLeft * scale, 0, scale, -cropTop * scale, 0, 0, 1;
    return crop * mirrored;
}

Projection mirrorProjection(const MirrorMapping& mapping, const hal::Intrinsics& intrinsics,
                            const fitting::SensorPlacement& placement) {
    Eigen::Matrix3f pinhole;
    pinhole << intrinsics.fx, 0, intrinsics.cx, 0, -intrinsics.fy, intrinsics.cy, 0, 0, 1;
    Projection sensorFromMirror;  // In metres: the scale cancels out in X and Y, and z is wanted in metres.
    sensorFromMirror.leftCols<3>() = placement.rotation.transpose();
    sensorFromMirror.col(3) = -(placement.rotation.transpose() * placement.translation);
    return mapping.displayFromSensor() * pinhole * sensorFromMirror;
}

MirrorMapping CropFollower::follow(int pictureWidth, int pictureHeight, int displayWidth, int displayHeight, Turn turn,
                                   const hal::Intrinsics& intrinsics, const fitting::SensorPlacement& placement,
                                   const fitting::Skeleton& skeleton) {
    MirrorMapping mapping{.turn = turn, .pictureWidth = pictureWidth, .pictureHeight = pictureHeight};
    const auto width = static_cast<float>(mapping.mirroredWidth());
    const auto height = static_cast<float>(mapping.mirroredHeight());
    mapping.scale = std::max(static_cast<float>(displayWidth) / width, static_cast<float>(displayHeight) / height);
    const float cropWidth = static_cast<float>(displayWidth) / mapping.scale;
    const float cropHeight = static_cast<float>(displayHeight) / mapping.scale;
    mapping.cropTop = (height - cropHeight) / 2.0F;

    if (skeleton.present()) {
        const Eigen::Vector3f torso = skeleton[fitting::Joint::torso].position;
        const Projection projection = mirrorProjection(mapping, intrinsics, placement);
        // With cropLeft still 0, X is the mirrored picture's x in display pixels.
        if (torso.allFinite() && (projection * torso.homogeneous()).z() > kNear) {
            const float person = projectPoint(projection, torso).x() / (mapping.scale * width);
            const double gap = hal::seconds(skeleton.captureTime - lastTime_);
            if (!followed_ || gap < 0.0 || gap > kGapSeconds) {
                centre_ = person;
            } else {
                const float band = kDeadBand * cropWidth / width;
                const float away = person - centre_;
                const float excess = away - std::clamp(away, -band, band);
                centre_ += excess * static_cast<float>(1.0 - std::exp(-gap / kFollowSeconds));
            }
            followed_ = true;
            lastTime_ = skeleton.captureTime;
        }
    }
    const float half = cropWidth / (2.0F * width);
    centre_ = std::clamp(centre_, std::min(half, 0.5F), std::max(1.0F - half, 0.5F));
    mapping.cropLeft = centre_ * width - cropWidth / 2.0F;
    return mapping;
}

}  // namespace cheval::render

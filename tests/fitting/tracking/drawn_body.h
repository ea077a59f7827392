// A body drawn as a sensor would see it: what the fit is tested against.
#pragma once

#include <cmath>
#include <vector>

#include "fitting/tracking/articulated_body.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/placement.h"
#include "fitting/tracking/silhouette.h"

namespace cheval::fitting::tracking::test {

inline constexpr float kStature = 1.72F;

/// In the A-pose, 2.4 m from a level sensor 1.2 m above the floor.
inline ArticulatedPose aPose() {
    ArticulatedPose pose;
    pose.size = usualLengths(kStature);
    pose.axes << -1, 0, 0, 0, 1, 0, 0, 0, -1;
    const float legs = pose.length(BodyLength::thigh) + pose.length(BodyLength::shank);
    pose.middle = {0.0F, 0.075F + 0.985F * legs + 0.5F * pose.length(BodyLength::trunk), 2.4F};
    pose.headDirection = Eigen::Vector3f(0.0F, 1.0F, -0.27F).normalized();
    for (const Side side : {Side::left, Side::right}) {
        const float out = -outwards(side);  // The left is at −x.
        pose.arms[fitting::index(side)] = {Eigen::Vector3f(0.7F * out, -0.7F, 0.0F).normalized(),
                                           Eigen::Vector3f(0.7F * out, -0.7F, -0.08F).normalized()};
        pose.legs[fitting::index(side)] = {Eigen::Vector3f(0.08F * out, -1.0F, -0.03F).normalized(),
                                           Eigen::Vector3f(0.06F * out, -1.0F, 0.20F).normalized()};
    }
    return pose;
}

/// What a sensor sees of a body in an empty room: a cloud, its outline and every `stride`-th point in both directions.
struct DrawnBody {
    explicit DrawnBody(const ArticulatedPose& pose, int stride = 5) {
        cloud.intrinsics = hal::Intrinsics{640, 480, 570.0F, 570.0F, 319.5F, 239.5F};
        cloud.placement = placementFrom({.height = 1.2F});
        const BodySurface surface(pose);
        std::vector<std::uint8_t> labels(kCloudCells);
        const Eigen::Vector3f eye = cloud.placement.translation;
        for (std::size_t i = 0; i < kCloudCells; ++i) {
            const Eigen::Vector3f along =
                cloud.placement.rotation * unproject(cloud.intrinsics, 2.0F * static_cast<float>(cellColumn(i)) + 0.5F,
                                                     2.0F * static_cast<float>(cellRow(i)) + 0.5F, 1.0F);
            // Sphere tracing: no step is longer than the way to the nearest surface.
            float depth = 1.2F;
            float distance = 1.0F;
            const float length = along.norm();
            for (int step = 0; step < 64 && depth < 3.4F && distance > 5e-4F; ++step) {
                distance = surface.outside(eye + depth * along);
                depth += distance / length;
            }
            if (distance > 5e-4F) continue;
            const Eigen::Vector3f point = eye + depth * along;
            cloud.depth[i] = depth;
            cloud.x[i] = point.x();
            cloud.y[i] = point.y();
            cloud.z[i] = point.z();
            labels[i] = 1;
            if (cellColumn(i) % stride == 0 && cellRow(i) % stride == 0) points.push_back(point);
        }
        SilhouetteJob outline{.cloud = &cloud, .labels = labels, .label = 1, .silhouette = &silhouette};
        outline.run();
    }

    Cloud cloud;
    Silhouette silhouette;
    std::vector<Eigen::Vector3f> points;
};

}  // namespace cheval::fitting::tracking::test

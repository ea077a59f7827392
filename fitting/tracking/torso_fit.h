// Head, trunk and which way they face: the part of the body that a silhouette and its depth tell most surely.
#pragma once

#include <array>

#include <Eigen/Core>

#include "fitting/skeleton.h"
#include "fitting/tracking/cloud.h"
#include "fitting/tracking/silhouette.h"

namespace cheval::fitting::tracking {

/// The trunk in one frame. Mirror frame, metres. `left` points to the person's left, `up` from hips to neck, `forward`
/// out of the chest; orthonormal (right-handed: left × up = forward).
struct TorsoPose {
    Eigen::Vector3f head = Eigen::Vector3f::Zero();
    Eigen::Vector3f neck = Eigen::Vector3f::Zero();
    std::array<Eigen::Vector3f, kSideCount> shoulders{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
    std::array<Eigen::Vector3f, kSideCount> hips{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
    Eigen::Vector3f left{-1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};
    /// The front surface: z = surface[0] + surface[1]·x + surface[2]·y.
    Eigen::Vector3f surface = Eigen::Vector3f::Zero();
    float halfDepth = 0.0F;  ///< What TorsoFitJob::halfDepth would put the trunk straight under the head; statures.
    float crown = 0.0F;      ///< Height of the highest point of the head, as seen.
    float stature = 1.7F;    ///< What the proportions were taken of.
    bool found = false;
    bool headSeen = false;

    /// The same trunk if it is turned about its own axis by `angle` radians more, to the person's right where positive,
    /// and its surface is a side.
    [[nodiscard]] TorsoPose turned(float angle) const;
};

/// Finds head and trunk. Invalid without cloud and silhouette.
struct TorsoFitJob {
    const Cloud* cloud = nullptr;
    const Silhouette* silhouette = nullptr;
    const TorsoPose* previous = nullptr;  ///< Of the frame before, or null.
    float stature = 0.0F;                 ///< As known so far; 0: not known, take what is seen.
    bool floorKnown = true;
    float halfDepth = 0.066F;  ///< From the trunk's front to its joints, in shares of the stature.

    TorsoPose pose;       ///< Out.
    float middle = 0.0F;  ///< Out: the trunk's middle line, x = middle + slope · (y − crown).
    float slope = 0.0F;   ///< Out.

    [[nodiscard]] bool isValid() const { return cloud != nullptr && cloud->isValid() && silhouette != nullptr; }
    void run();

  private:
    bool findHead(float centre);
    void fitTrunk();
    void placeJoints();
};

}  // namespace cheval::fitting::tracking

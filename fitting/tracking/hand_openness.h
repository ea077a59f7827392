// How open one hand is: its region, outline and surface, measured and weighed together (D3).
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "fitting/tracking/binary_image.h"
#include "fitting/tracking/hand_shape.h"
#include "hal/frame.h"

namespace cheval::fitting::tracking {

/// Scratch of HandOpennessJob, made once.
struct HandOpennessContext {
    HandMask mask{}, scratch{};
    HandShapeContext shape;
};

/// Cuts a hand out (HandRegionJob), measures outline (HandShapeJob) and surface (HandReliefJob), and gives one figure
/// by logistic regression over six of their measures in shares of the distance from head to neck. Trained on 4500
/// simulated hands, never on recorded ones. Invalid without context, or where a region cannot be cut out.
struct HandOpennessJob {
    hal::ImageView<const std::uint16_t> depth;
    hal::ImageView<const std::uint8_t> userMap;  ///< May be empty: then every pixel counts.
    std::uint8_t label = 0;                      ///< The hand's owner in the map.
    hal::Intrinsics intrinsics;
    Eigen::Vector3f palm = Eigen::Vector3f::Zero();   ///< Sensor frame, millimetres, about its centre.
    Eigen::Vector3f elbow = Eigen::Vector3f::Zero();  ///< Sensor frame, millimetres.
    float headToNeck = 0.0F;                          ///< Metres.
    bool close = true;                                ///< As HandRegionJob has it.
    float coarsest = 0.0F;                            ///< Fewer pixels to a cell of the region are not read.
    HandOpennessContext* context = nullptr;

    bool found = false;     ///< Out.
    float openness = 0.0F;  ///< Out: below 0 rather closed, above rather open, about ±1 when clear; ±1.5 at most.
    int fingers = 0;        ///< Out: stretched ones.

    [[nodiscard]] bool isValid() const;
    void run();
};

}  // namespace cheval::fitting::tracking

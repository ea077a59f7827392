// Who stands before the glass.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "hal/image.h"

namespace cheval::fitting {

inline constexpr std::size_t kMaximumUsers = 6;

/// One person in view. Mirror frame, metres.
struct User {
    std::uint32_t id = 0;  ///< Counts up, never used twice in a run; 0: none.
    Eigen::Vector3f centroid = Eigen::Vector3f::Zero();
    Eigen::Vector3f velocity = Eigen::Vector3f::Zero();  ///< Of the centroid, metres a second.
    Eigen::Vector3f lower = Eigen::Vector3f::Zero();     ///< Corner of the axis-aligned box of the person's points.
    Eigen::Vector3f upper = Eigen::Vector3f::Zero();
    int pixels = 0;
    std::uint8_t label = 0;  ///< The value of this person's pixels in the user map.
};

/// Why nobody can be seen, or not as they are or where they are, whoever stands there.
enum class ViewFault : std::uint8_t {
    none,
    noReadings,      ///< Hardly a pixel has a depth: sunlight, a dead projector, or nothing within reach.
    covered,         ///< Something close fills the view: a hand, a coat, a poster, a wall.
    upsideDown,      ///< The floor is where the ceiling should be.
    floorElsewhere,  ///< The floor is not where the written-down mount puts it: that, or the focal length, is wrong.
};

/// Everybody in one frame. The map belongs to the tracker and is valid until its next frame.
struct Users {
    std::array<User, kMaximumUsers> users{};
    std::size_t count = 0;
    std::uint32_t activeId = 0;  ///< The person being dressed: the nearest in the zone, then held; 0: nobody.
    hal::ImageView<const std::uint8_t> map;  ///< Size of the depth picture; 0 = scene, else User::label.

    [[nodiscard]] const User* active() const {
        for (std::size_t i = 0; i < count; ++i) {
            if (users[i].id == activeId && activeId != 0) return &users[i];
        }
        return nullptr;
    }
};

}  // namespace cheval::fitting

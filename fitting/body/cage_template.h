// The one cage that every body and garment cage corresponds to (A9). Made once by cheval-bake, frozen, and tested by
// hash.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fitting/mesh.h"
#include "hal/expected.h"

namespace cheval::fitting {

enum class BodyPart : std::uint8_t {
    head,
    neck,
    chest,
    waist,
    hips,
    leftUpperArm,
    leftForearm,
    leftHand,
    rightUpperArm,
    rightForearm,
    rightHand,
    leftThigh,
    leftShin,
    leftFoot,
    rightThigh,
    rightShin,
    rightFoot,
};
inline constexpr std::size_t kBodyPartCount = 17;
inline constexpr std::size_t kMaximumCageVertices = 1200;

/// Topology and correspondence of all cages; immutable. Vertex i of any cage is vertex i of every other.
struct CageTemplate {
    std::vector<Eigen::Vector2f> uv;  ///< Unique per vertex to 1e-4; what a cage in a file is matched by.
    std::vector<Triangle> triangles;  ///< Counter-clockwise from outside.
    std::vector<std::uint16_t> weld;  ///< Lowest vertex at the same place (UV seams); itself if alone. Sums are shared.
    std::vector<std::uint16_t> mirrored;  ///< The vertex on the other side of the body; itself on the centre line.
    std::vector<BodyPart> part;
    std::uint64_t hash = 0;  ///< FNV-1a over all of the above, as the assets carry it.

    [[nodiscard]] std::size_t vertexCount() const { return uv.size(); }
};

/// FNV-1a (64 bit, offset basis CBF29CE484222325, prime 100000001B3) over uv, triangles, weld, mirrored and part, in
/// that order: for each its count as 64 bits, then its values, all little-endian (floats by their bits, a part as one
/// byte). `hash` itself is left out.
std::uint64_t hashCageTemplate(const CageTemplate& cageTemplate);

}  // namespace cheval::fitting

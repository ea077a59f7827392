// Meshes lofted through elliptic cross-sections: what people and things of the simulated room are made of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "hal/sim/shopper.h"

namespace cheval::hal::sim {

/// Up to two bones and the share of the second.
struct Hold {
    std::uint16_t first = 0, second = 0;
    float share = 0.0F;
};

/// A vertex of cloth that moves to and fro with its wearer.
struct Fold {
    std::uint32_t vertex = 0;
    float reach = 0.0F;  ///< Metres that it moves at most …
    float angle = 0.0F;  ///< … radians about the body from its left; the way out is that of this angle, horizontal.
    float phase = 0.0F;  ///< Radians.
};

/// Vertices with everything that posing and shading need; triangles counter-clockwise from outside.
struct Mesh {
    std::vector<Eigen::Vector3f> positions;
    std::vector<Eigen::Vector3f> normals;  ///< By finish().
    std::vector<Eigen::Vector3f> albedo;   ///< Linear light, 0…1.
    std::vector<Hold> holds;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Material> materials;  ///< One a triangle.
    std::vector<Fold> folds;          ///< Of cloth that hangs free.

    void reserve(std::size_t vertices, std::size_t triangleCount);
    void clear();
    /// Vertex normals as area-weighted means of the faces.
    void finish();
};

/// A cross-section: an ellipse with two half depths, which a `squareness` over 2 swells towards a rectangle.
struct Ring {
    Eigen::Vector3f centre = Eigen::Vector3f::Zero();
    Eigen::Vector3f across = Eigen::Vector3f::UnitX();  ///< Unit vectors of the section's plane.
    Eigen::Vector3f ahead = Eigen::Vector3f::UnitZ();
    float halfWidth = 0.0F;
    float front = 0.0F;  ///< Half depth along `ahead` …
    float back = 0.0F;   ///< … and against it.
    Hold hold;
    Eigen::Vector3f colour = Eigen::Vector3f::Ones();  ///< sRGB.
    float squareness = 2.0F;
    float shade = 1.0F;  ///< Share of light that reaches this place past its surroundings.
};

/// The point of a ring's edge at `angle` radians from `across`, going round by `ahead`.
Eigen::Vector3f pointOf(const Ring& ring, float angle);

enum class Cap : std::uint8_t { open, flat };

/// sRGB 0…1 to linear light, by the same square that the renderer undoes with a root.
inline Eigen::Vector3f toLinear(const Eigen::Vector3f& colour) {
    return colour.cwiseProduct(colour);
}

/// Joins the rings by a skin of `segments` quads around, and returns the number of the first vertex; vertex (ring i,
/// segment j) is first + i·segments + j, segment 0 lying at `across` and going round by `ahead`.
std::size_t addLoft(Mesh& mesh, std::span<const Ring> rings, int segments, Material material, Cap start, Cap end);

/// An ellipsoid with its own axes.
struct Ellipsoid {
    Eigen::Vector3f centre, across, up, ahead;
    Eigen::Vector3f halfSize;  ///< Along the three axes.
    Hold hold;
    Eigen::Vector3f colour;
    float shade = 1.0F;
};
void addEllipsoid(Mesh& mesh, const Ellipsoid& ellipsoid, int segments, int rings, Material material);

}  // namespace cheval::hal::sim

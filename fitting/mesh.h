// Meshes: what is posed each frame and handed to the renderer as it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include "hal/clock.h"

namespace cheval::fitting {

/// Three vertex indices, counter-clockwise seen from outside.
struct Triangle {
    std::uint32_t a = 0, b = 0, c = 0;
    friend bool operator==(const Triangle&, const Triangle&) = default;
};

/// A vertex as the GPU takes it: interleaved, 32 bytes, written once by the last job of the chain.
struct PosedVertex {
    float x = 0, y = 0, z = 0;     ///< Mirror frame, metres.
    float nx = 0, ny = 0, nz = 0;  ///< Unit normal, outwards.
    float u = 0, v = 0;            ///< Texture, v downwards (glTF).
};
static_assert(sizeof(PosedVertex) == 32 && std::is_trivially_copyable_v<PosedVertex>);

/// What a part of a posed mesh is, so that a view can leave it out (mirror view draws no body).
enum class PartKind : std::uint8_t { body, garment };

/// A run of triangles with one material.
struct MeshPart {
    PartKind kind = PartKind::garment;
    std::uint32_t firstIndex = 0;  ///< Into PosedMesh::indices.
    std::uint32_t indexCount = 0;
    std::uint32_t material = 0;  ///< Into the wardrobe's material list, which the renderer was given at start-up.
    std::uint8_t layer = 0;      ///< 0 = body, 1 = innermost garment.
};

/// Everything that moves with the shopper in one frame. Capacity is reserved at start-up; topologyRevision rises when
/// indices or parts change, so that they are uploaded only then.
struct PosedMesh {
    std::vector<PosedVertex> vertices;
    std::vector<std::uint32_t> indices;
    std::vector<MeshPart> parts;
    std::uint64_t topologyRevision = 0;
    hal::TimePoint captureTime{};
};

/// Up to four bones a vertex (D4); weights sum to 1, unused ones are 0. Bones are numbered as Joint.
struct SkinningWeights {
    std::uint8_t joint[4] = {0, 0, 0, 0};
    float weight[4] = {1, 0, 0, 0};
};

/// A mesh in rest pose (A-pose), structure of arrays. All per-vertex vectors have the same length.
struct RestMesh {
    std::vector<Eigen::Vector3f> positions;  ///< Metres, +Y up, facing +Z, floor at y = 0.
    std::vector<Eigen::Vector3f> normals;
    std::vector<Eigen::Vector2f> uv;
    std::vector<Triangle> triangles;
    std::vector<SkinningWeights> weights;
};

}  // namespace cheval::fitting

// Looks at an untrusted .glb before any library does: that it is whole, and that nothing in it asks for more than it
// holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/expected.h"

namespace cheval::fitting {

/// What an asset may ask for.
struct GlbLimits {
    std::uint64_t fileBytes = 64ULL << 20;
    std::uint64_t jsonBytes = 1ULL << 20;  ///< A garment's is about 10 KB; parsing takes some hundred times as much.
    std::uint64_t vertices = 100'000;      ///< Elements of one accessor that is not an index.
    std::uint64_t indices = 600'000;
    std::size_t objects = 256;     ///< Nodes, meshes, accessors, … of each kind.
    std::size_t morphTargets = 0;  ///< Of one mesh; garments have none.
    std::size_t nesting = 32;      ///< Of JSON arrays and objects: parsers recurse.
};

/// Checks container, chunk lengths, JSON, one embedded buffer, every buffer view and accessor (bounds, strides, types,
/// counts), the references between them, and refuses what the mirror has no use for: external files, sparse accessors,
/// extensions that must be understood, several primitives a mesh. `file` is named in errors. Takes memory in proportion
/// to the JSON's size only. Errors: invalidInput with cause, mend, why and key.
Expected<void> checkGlb(std::span<const std::byte> bytes, const GlbLimits& limits, const std::string& file);

}  // namespace cheval::fitting

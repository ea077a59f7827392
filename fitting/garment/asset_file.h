// A .glb asset as loaders want it: meshes by node name, joints by name, one material. Format:
// fitting/garment/FORMAT.md.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "fitting/garment/glb_check.h"
#include "fitting/material.h"
#include "fitting/mesh.h"
#include "fitting/skeleton.h"
#include "hal/expected.h"

namespace cheval::fitting {

/// Whole limits of an asset: container and texture.
struct AssetLimits {
    GlbLimits glb;
    std::uint32_t triangles = 200'000;
    std::uint32_t texturePixels = 4096U * 4096U;
};

/// A mesh as a file has it, checked: numbers finite, indices in range, weights sound. Vectors of what is absent are
/// empty, all others have the same length.
struct AssetMesh {
    std::string node;
    RestMesh mesh;
    std::vector<std::vector<Eigen::Vector3f>> shapes;   ///< Displacements of the morph targets, in order.
    std::map<std::string, std::vector<float>> scalars;  ///< Attributes whose names begin with "_".
};

/// What an AssetMesh must have beyond POSITION.
struct MeshNeeds {
    bool normals = false;
    bool uv = false;
    bool weights = false;
    bool triangles = false;
};

/// A parsed file. Thread-bound.
class AssetFile {
  public:
    /// Checks and parses; `file` is named in errors.
    static Expected<AssetFile> parse(std::span<const std::byte> bytes, const std::string& file,
                                     const AssetLimits& limits);
    AssetFile(AssetFile&&) noexcept;
    AssetFile& operator=(AssetFile&&) noexcept;
    AssetFile(const AssetFile&) = delete;
    AssetFile& operator=(const AssetFile&) = delete;
    ~AssetFile();

    /// Names of the nodes that have a mesh, in the file's order.
    [[nodiscard]] std::vector<std::string> meshNodes() const;
    [[nodiscard]] bool hasNode(std::string_view node) const;
    /// Whether asset.extras.cheval has something at this path: members and numbers of entries, joined by "/", such as
    /// "sizes/chest_girth/0/over". text() and number() take such paths too.
    [[nodiscard]] bool has(const std::string& path) const;
    /// The members of the object at a path, and the length of the list there; none and 0 where there is no such thing.
    [[nodiscard]] std::vector<std::string> keys(const std::string& path) const;
    [[nodiscard]] std::size_t length(const std::string& path) const;
    /// Reads the mesh of that node. Refuses a node that is moved, turned or scaled: cages and meshes are in the
    /// reference body's place.
    [[nodiscard]] Expected<AssetMesh> mesh(const std::string& node, const MeshNeeds& needs) const;
    /// The material of that node's mesh, the default one when there is none.
    [[nodiscard]] Expected<Material> material(const std::string& node) const;
    /// Places of all 15 joint nodes, metres, rest pose.
    [[nodiscard]] Expected<std::array<Eigen::Vector3f, kJointCount>> jointPositions() const;
    /// asset.extras.cheval.
    [[nodiscard]] std::optional<std::string> text(const std::string& key) const;
    [[nodiscard]] std::optional<double> number(const std::string& key) const;
    /// Nothing unless it is a list of numbers alone.
    [[nodiscard]] std::optional<std::vector<double>> numbers(const std::string& key) const;
    /// Errors unless "format" is `format`; then the template hash.
    [[nodiscard]] Expected<std::uint64_t> templateHash(const std::string& format) const;

    /// An invalidInput error that names this file.
    [[nodiscard]] Error refuse(std::string key, std::string cause, std::string mend, std::string why) const;

  private:
    struct State;
    explicit AssetFile(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Reads a file whole, after looking at its size. Errors: notFound, invalidInput, resource; they name it.
Expected<std::vector<std::byte>> readAsset(const std::string& path, std::uint64_t limitBytes);

}  // namespace cheval::fitting

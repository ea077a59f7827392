// Writes .glb files for tests: sound ones, and, through their public parts, unsound ones.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fitting/body/body.h"
#include "fitting/garment/garment.h"

namespace cheval::test {

/// A .glb in the making: change `json` and `binary` at will before bytes().
struct GlbBuilder {
    nlohmann::json json;
    std::vector<std::uint8_t> binary;

    GlbBuilder();
    /// Adds a node with a mesh of what `mesh` has; JOINTS_0 numbers are those of Joint.
    void addMesh(const std::string& node, const fitting::RestMesh& mesh);
    /// Adds a float scalar attribute to the mesh of that node.
    void addScalar(const std::string& node, const std::string& attribute, const std::vector<float>& values);
    /// Adds joint nodes and a skin, and gives it to all nodes with weights.
    void addSkin(const std::array<Eigen::Vector3f, fitting::kJointCount>& joints);
    /// Adds a PNG as base colour texture of that node's mesh.
    void addTexture(const std::string& node, const std::vector<std::byte>& png);

    nlohmann::json& primitive(const std::string& node);
    /// The accessor behind an attribute (or "indices") of that node's mesh.
    nlohmann::json& accessor(const std::string& node, const std::string& attribute);
    /// Address in `binary` of an attribute's first byte.
    std::uint8_t* data(const std::string& node, const std::string& attribute);
    void removeNode(const std::string& node);

    [[nodiscard]] std::vector<std::byte> bytes() const;

  private:
    int addAccessor(const void* from, std::size_t elementBytes, std::size_t count, int componentType, const char* type);
};

/// As cheval-bake would write them.
GlbBuilder bodyGlb(const fitting::Body& body);
GlbBuilder garmentGlb(const fitting::Garment& garment, const fitting::Body& body);

}  // namespace cheval::test

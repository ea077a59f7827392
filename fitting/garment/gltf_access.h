// Reads accessors of a checked glTF model into plain vectors. Only for the .cpp files of this folder: it shows
// tinygltf.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <tiny_gltf.h>

namespace cheval::fitting {

/// `components` floats an element; nothing unless the accessor is FLOAT of that many components. The model has passed
/// checkGlb.
std::optional<std::vector<float>> readFloats(const tinygltf::Model& model, int accessor, int components);
/// Whole numbers of `components` an element; nothing unless it is UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT of that
/// many.
std::optional<std::vector<std::uint32_t>> readWholeNumbers(const tinygltf::Model& model, int accessor, int components);

/// Where each node is in the scene, with its parents' transforms; nothing when nodes go round in a circle, have two
/// parents or transforms of the wrong length or size.
std::optional<std::vector<Eigen::Affine3d>> globalTransforms(const tinygltf::Model& model);

}  // namespace cheval::fitting

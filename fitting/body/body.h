// The mannequin: the body that garments were made on, and the same body scaled to a shopper.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "fitting/body.h"
#include "fitting/body/cage_template.h"
#include "fitting/material.h"
#include "fitting/mesh.h"
#include "fitting/skeleton.h"
#include "hal/expected.h"

namespace cheval::fitting {

/// Immutable asset, made by cheval-bake. Rest pose (A-pose), metres, +Y up, facing +Z (glTF), floor at y = 0, so its
/// left side lies at +X. A shopper who faces the glass looks along −Z of the mirror frame: a joint orientation there is
/// half a turn about Y times the joint's own rotation.
///
/// A bone is numbered as the joint that it turns about and carries the flesh up to the next joint:
///   torso: the whole trunk with pelvis and shoulder girdle, from the mid-point of the hips to the neck (its joint lies
///   midway); neck: from the neck's base to the skull; head: the skull (its joint is the head's centre);
///   shoulder: the upper arm, to the elbow; elbow: the forearm, to the wrist; hand: the hand (its joint is the palm's
///   centre, so it turns rightly only as long as it turns with the forearm); hip: the thigh, to the knee; knee: the
///   shin, to the ankle; foot: the foot.
/// In rest pose every bone's orientation is the identity. The limbs' rest directions are those between joint centres.
struct Body {
    CageTemplate cageTemplate;
    std::vector<Eigen::Vector3f> outerCage;    ///< Template order; `Body_OuterCage`.
    std::vector<SkinningWeights> cageWeights;  ///< Template order.
    RestMesh mesh;
    std::array<Eigen::Vector3f, kJointCount> joints{};  ///< Rest-pose joint centres, order of Joint.
    Material material;
};

/// A body scaled to a shape. Reused between shapes without taking memory.
struct ShapedBody {
    std::vector<Eigen::Vector3f> outerCage;
    std::vector<Eigen::Vector3f> positions;  ///< As Body::mesh.
    std::vector<Eigen::Vector3f> normals;
    std::array<Eigen::Vector3f, kJointCount> joints{};
    std::uint32_t revision = 0;  ///< BodyShape::revision it was made from.
};

/// Loads and validates a body asset (format: fitting/garment/FORMAT.md). Refusals carry cause, mend, why and the file.
Expected<Body> loadBody(const std::string& path);
/// As loadBody, from memory; `file` is named in errors.
Expected<Body> parseBody(std::span<const std::byte> bytes, const std::string& file);

/// Makes `shaped` the mannequin of that shape (D12: x breadth, y height, z their mean).
void shapeBody(const Body& body, const BodyShape& shape, ShapedBody& shaped);

}  // namespace cheval::fitting

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

/// How the mannequin changes with its parameters, linearly: a point is its place on the mannequin plus the sum of
/// parameter times shape. Columns in the order of ShapeParameter; rows x, y, z of the first point, then of the second …
struct BodyShapes {
    Eigen::MatrixXf mesh;    ///< 3 · vertices of Body::mesh × 19.
    Eigen::MatrixXf cage;    ///< 3 · vertices of Body::outerCage × 19.
    Eigen::MatrixXf joints;  ///< 3 · 15 × 19.
    /// What bodies of grown-ups are like (config/anthropometry): mean and covariance of the parameters, metres.
    ShapeParameters mean = ShapeParameters::Zero();
    Eigen::MatrixXf covariance;  ///< 19 × 19, positive definite.
};

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
    std::vector<std::uint32_t> meshWeld;                ///< Of each vertex of `mesh` the lowest one at the same place.
    std::array<Eigen::Vector3f, kJointCount> joints{};  ///< Rest-pose joint centres, order of Joint.
    Material material;
    BodyShapes shapes;
};

/// A body scaled to a shape. Reused between shapes without taking memory.
struct ShapedBody {
    std::vector<Eigen::Vector3f> outerCage;
    std::vector<Eigen::Vector3f> positions;  ///< As Body::mesh.
    std::vector<Eigen::Vector3f> normals;
    std::array<Eigen::Vector3f, kJointCount> joints{};
    std::uint32_t revision = 0;  ///< BodyShape::revision it was made from.
};

/// Of each point the lowest-numbered one at exactly the same place: itself, but at the seams of a texture.
std::vector<std::uint32_t> weldPoints(std::span<const Eigen::Vector3f> points);

/// Loads and validates a body asset (format: fitting/garment/FORMAT.md). Refusals carry cause, mend, why and the file.
Expected<Body> loadBody(const std::string& path);
/// As loadBody, from memory; `file` is named in errors.
Expected<Body> parseBody(std::span<const std::byte> bytes, const std::string& file);

/// Makes `shaped` the mannequin of that shape. Takes memory only the first time.
void shapeBody(const Body& body, const BodyShape& shape, ShapedBody& shaped);

}  // namespace cheval::fitting

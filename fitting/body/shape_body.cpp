#include "fitting/body/body.h"

namespace cheval::fitting {

void shapeBody(const Body& body, const BodyShape& shape, ShapedBody& shaped) {
    // About the floor below the mannequin, so that feet stay on it.
    const Eigen::Vector3f& scale = shape.scale;
    const Eigen::Vector3f inverse = scale.cwiseInverse();
    shaped.outerCage.resize(body.outerCage.size());
    for (std::size_t i = 0; i < body.outerCage.size(); ++i) {
        shaped.outerCage[i] = body.outerCage[i].cwiseProduct(scale);
    }
    shaped.positions.resize(body.mesh.positions.size());
    for (std::size_t i = 0; i < body.mesh.positions.size(); ++i) {
        shaped.positions[i] = body.mesh.positions[i].cwiseProduct(scale);
    }
    shaped.normals.resize(body.mesh.normals.size());
    for (std::size_t i = 0; i < body.mesh.normals.size(); ++i) {
        shaped.normals[i] = body.mesh.normals[i].cwiseProduct(inverse).normalized();
    }
    for (std::size_t i = 0; i < kJointCount; ++i)
        shaped.joints[i] = body.joints[i].cwiseProduct(scale);
    shaped.revision = shape.revision;
}

}  // namespace cheval::fitting

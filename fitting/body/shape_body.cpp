#include <cmath>

#include "fitting/body/body.h"

namespace cheval::fitting {

namespace {

using Coordinates = Eigen::Map<Eigen::VectorXf>;

Coordinates coordinatesOf(Eigen::Vector3f* points, std::size_t count) {
    static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
    return {points->data(), static_cast<Eigen::Index>(3 * count)};
}

// Each point is rest · scale, moved towards rest + shapes · parameters by the fitted share: one matrix product.
void place(std::span<const Eigen::Vector3f> rest, const Eigen::MatrixXf& shapes, const BodyShape& shape,
           std::span<Eigen::Vector3f> points) {
    const Eigen::Vector3f scale = (1.0F - shape.fitted) * shape.scale + Eigen::Vector3f::Constant(shape.fitted);
    // About the floor below the mannequin, so that feet stay on it.
    for (std::size_t i = 0; i < rest.size(); ++i)
        points[i] = rest[i].cwiseProduct(scale);
    if (shape.fitted <= 0.0F || shapes.rows() != static_cast<Eigen::Index>(3 * rest.size())) return;
    const ShapeParameters weighted = shape.fitted * shape.parameters;
    coordinatesOf(points.data(), points.size()).noalias() += shapes * weighted;
}

// Area-weighted over the faces round each place, also across the seams of the texture.
void computeNormals(const Body& body, std::span<const Eigen::Vector3f> positions,
                    std::vector<Eigen::Vector3f>& normals) {
    const std::vector<std::uint32_t>& weld = body.meshWeld;
    for (Eigen::Vector3f& normal : normals)
        normal.setZero();
    for (const Triangle& t : body.mesh.triangles) {
        const Eigen::Vector3f face = (positions[t.b] - positions[t.a]).cross(positions[t.c] - positions[t.a]);
        normals[weld[t.a]] += face;
        normals[weld[t.b]] += face;
        normals[weld[t.c]] += face;
    }
    for (std::size_t i = 0; i < normals.size(); ++i) {
        if (weld[i] != i) {
            normals[i] = normals[weld[i]];  // Lower, and so done already.
            continue;
        }
        const float length = normals[i].norm();
        normals[i] = length > 1e-12F ? Eigen::Vector3f(normals[i] / length) : body.mesh.normals[i];
    }
}

}  // namespace

void shapeBody(const Body& body, const BodyShape& shape, ShapedBody& shaped) {
    shaped.outerCage.resize(body.outerCage.size());
    place(body.outerCage, body.shapes.cage, shape, shaped.outerCage);
    shaped.positions.resize(body.mesh.positions.size());
    place(body.mesh.positions, body.shapes.mesh, shape, shaped.positions);
    place(body.joints, body.shapes.joints, shape, shaped.joints);

    shaped.normals.resize(body.mesh.normals.size());
    if (shape.fitted <= 0.0F) {
        const Eigen::Vector3f inverse = shape.scale.cwiseInverse();
        for (std::size_t i = 0; i < body.mesh.normals.size(); ++i)
            shaped.normals[i] = body.mesh.normals[i].cwiseProduct(inverse).normalized();
    } else {
        computeNormals(body, shaped.positions, shaped.normals);
    }
    shaped.revision = shape.revision;
}

}  // namespace cheval::fitting

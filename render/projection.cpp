#include "render/projection.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace cheval::render {

Eigen::Vector2f projectPoint(const Projection& projection, const Eigen::Vector3f& mirrorMetres) {
    const Eigen::Vector3f homogeneous = projection * mirrorMetres.homogeneous();
    return homogeneous.head<2>() / homogeneous.z();
}

Eigen::Matrix4f clipMatrix(const Projection& projection, float left, float top, float width, float height) {
    Eigen::Matrix4f clip;
    clip.row(0) = (projection.row(0) - left * projection.row(2)) * (2.0F / width) - projection.row(2);
    clip.row(1) = (projection.row(1) - top * projection.row(2)) * (2.0F / height) - projection.row(2);
    clip.row(2) = projection.row(2) * ((kFar + kNear) / (kFar - kNear));
    clip(2, 3) -= 2.0F * kFar * kNear / (kFar - kNear);
    clip.row(3) = projection.row(2);
    return clip;
}

Eigen::Vector3f eyeOf(const Projection& projection) {
    const Eigen::Matrix3f linear = projection.leftCols<3>();
    return linear.inverse() * -projection.col(3);
}

bool flipsWinding(const Projection& projection) {
    // A triangle that faces the eye, counter-clockwise seen from there, tells by the side on which it comes out.
    const Eigen::Vector3f towardsEye = -projection.row(2).head<3>().transpose().normalized();
    const Eigen::Vector3f right = towardsEye.unitOrthogonal();
    const Eigen::Vector3f up = towardsEye.cross(right);
    const Eigen::Vector3f centre = eyeOf(projection) - towardsEye;
    const Eigen::Vector2f a = projectPoint(projection, centre);
    const Eigen::Vector2f b = projectPoint(projection, centre + right * 0.1F) - a;
    const Eigen::Vector2f c = projectPoint(projection, centre + up * 0.1F) - a;
    return b.x() * c.y() - b.y() * c.x() < 0.0F;
}

}  // namespace cheval::render

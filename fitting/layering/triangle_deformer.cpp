#include "fitting/layering/triangle_deformer.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace cheval::fitting {

namespace {

// Below this sine of the angle between two edges the triangle says nothing reliable about shear, and the inverse of its
// basis would magnify rounding; its rotation alone is taken then.
constexpr double kSliverSine = 0.05;
constexpr double kSmallestArea = 1e-12;  // m²

struct TriangleFrame {
    Eigen::Vector3d u, v, w;
    double sine = 0.0;
    double area = 0.0;
};

TriangleFrame frameOf(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    TriangleFrame frame;
    const Eigen::Vector3d u = (b - a).cast<double>();
    const Eigen::Vector3d v = (c - a).cast<double>();
    const Eigen::Vector3d cross = u.cross(v);
    const double lengths = u.norm() * v.norm();
    const double crossLength = cross.norm();
    frame.area = 0.5 * crossLength;
    if (lengths <= 0.0 || frame.area < kSmallestArea) return frame;
    frame.u = u.normalized();
    frame.v = v.normalized();
    frame.w = cross / crossLength;
    frame.sine = crossLength / lengths;
    return frame;
}

// LD: turns vectors of the garment's triangle into vectors of the triangle below.
Eigen::Matrix3d localDifference(const TriangleFrame& below, const TriangleFrame& inner) {
    Eigen::Matrix3d to;
    Eigen::Matrix3d from;
    if (std::min(below.sine, inner.sine) < kSliverSine) {
        to << below.u, below.w.cross(below.u), below.w;
        from << inner.u, inner.w.cross(inner.u), inner.w;
        return to * from.transpose();
    }
    to << below.u, below.v, below.w;
    from << inner.u, inner.v, inner.w;
    return to * from.inverse();
}

}  // namespace

bool TriangleDeformerJob::isValid() const {
    const std::size_t n = weld.size();
    if (covered.size() != n || below.size() != n || inner.size() != n || outer.size() != n) return false;
    if (sums.size() != n || newOuter.size() != n || vertexTransforms.size() != n) return false;
    for (const std::uint16_t target : weld) {
        if (target >= n || weld[target] != target) return false;
    }
    return std::all_of(triangles.begin(), triangles.end(),
                       [n](const Triangle& t) { return t.a < n && t.b < n && t.c < n; });
}

bool TriangleDeformerJob::run() const {
    if (!isValid()) return false;
    std::fill(sums.begin(), sums.end(), CageVertexSum{});

    for (const Triangle& triangle : triangles) {
        if (covered[triangle.a] == 0 || covered[triangle.b] == 0 || covered[triangle.c] == 0) continue;
        const TriangleFrame under = frameOf(below[triangle.a], below[triangle.b], below[triangle.c]);
        const TriangleFrame own = frameOf(inner[triangle.a], inner[triangle.b], inner[triangle.c]);
        if (under.area < kSmallestArea || own.area < kSmallestArea) continue;
        const Eigen::Matrix3d difference = localDifference(under, own);
        for (const std::uint32_t corner : {triangle.a, triangle.b, triangle.c}) {
            const Eigen::Vector3d offset = (outer[corner] - inner[corner]).cast<double>();
            CageVertexSum& sum = sums[weld[corner]];
            sum.transform += own.area * difference;
            sum.offset += own.area * (difference * offset);
            sum.area += own.area;
        }
    }

    for (std::size_t i = 0; i < weld.size(); ++i) {
        const CageVertexSum& sum = sums[weld[i]];
        if (covered[i] == 0) {
            newOuter[i] = below[i];
            vertexTransforms[i].setIdentity();
        } else if (sum.area > 0.0) {
            // Seam partners start from one place too, else a rounding step below would open the seam.
            newOuter[i] = (below[weld[i]].cast<double>() + sum.offset / sum.area).cast<float>();
            vertexTransforms[i] = (sum.transform / sum.area).cast<float>();
        } else {
            newOuter[i] = below[i] + (outer[i] - inner[i]);
            vertexTransforms[i].setIdentity();
        }
    }
    return true;
}

}  // namespace cheval::fitting

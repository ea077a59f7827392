#include "fitting/layering/smooth_normals.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include <Eigen/Geometry>

namespace cheval::fitting {

std::vector<std::uint32_t> weldByPosition(std::span<const Eigen::Vector3f> positions) {
    const auto key = [&](std::uint32_t i) {
        return std::tuple(positions[i].x(), positions[i].y(), positions[i].z(), i);
    };
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) { return key(i) < key(j); });
    std::vector<std::uint32_t> weld(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && positions[order[i]] == positions[order[i - 1]];
        weld[order[i]] = same ? weld[order[i - 1]] : order[i];
    }
    return weld;
}

void smoothNormals(std::span<const Eigen::Vector3f> positions, std::span<const Triangle> triangles,
                   std::span<const std::uint32_t> weld, std::span<Eigen::Vector3f> normals) {
    std::fill(normals.begin(), normals.end(), Eigen::Vector3f::Zero());
    for (const Triangle& t : triangles) {
        const Eigen::Vector3f doubleArea = (positions[t.b] - positions[t.a]).cross(positions[t.c] - positions[t.a]);
        normals[weld[t.a]] += doubleArea;
        normals[weld[t.b]] += doubleArea;
        normals[weld[t.c]] += doubleArea;
    }
    // A weld target is never above its vertex, so going down leaves every target's sum in place until it is read.
    for (std::size_t i = normals.size(); i-- > 0;) {
        const Eigen::Vector3f sum = normals[weld[i]];
        const float length = sum.norm();
        normals[i] = length > 0.0F ? Eigen::Vector3f(sum / length) : Eigen::Vector3f::Zero();
    }
}

Eigen::Vector3f turnAlong(const Eigen::Vector3f& normal, const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
    const float cosine = from.dot(to);
    if (cosine < -0.999F || from.squaredNorm() < 0.5F || to.squaredNorm() < 0.5F) return normal;
    // Rodrigues' formula with sin and cos taken from the cross and dot product.
    const Eigen::Vector3f axis = from.cross(to);
    return cosine * normal + axis.cross(normal) + axis * (axis.dot(normal) / (1.0F + cosine));
}

}  // namespace cheval::fitting

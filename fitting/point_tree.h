// Which of many points are nearest to one: a k-d tree, for load time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <nanoflann.hpp>

namespace cheval::fitting {

/// A k-d tree over points that outlive it. Takes memory when it is made; immutable after that.
class PointTree {
  public:
    explicit PointTree(std::span<const Eigen::Vector3f> points)
        : points_{points}, tree_(3, points_, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {}

    /// Fills `places` and `squaredDistances`, of one length, with the points nearest to `point`, nearest first; how
    /// many there are.
    std::size_t nearest(const Eigen::Vector3f& point, std::span<std::uint32_t> places,
                        std::span<float> squaredDistances) const {
        return tree_.knnSearch(point.data(), places.size(), places.data(), squaredDistances.data());
    }

  private:
    struct Points {
        std::span<const Eigen::Vector3f> points;

        // Names that nanoflann asks for.
        // NOLINTBEGIN(readability-identifier-naming)
        [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
        [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
            return points[i][static_cast<Eigen::Index>(axis)];
        }
        template <typename Box>
        bool kdtree_get_bbox(Box& /*box*/) const {
            return false;
        }
        // NOLINTEND(readability-identifier-naming)
    };

    Points points_;
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3> tree_;
};

}  // namespace cheval::fitting

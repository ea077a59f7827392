#include "fitting/tracking/hand_relief.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "fitting/tracking/hand_region.h"

namespace cheval::fitting::tracking {
namespace {

constexpr int kLeastPoints = 20;
constexpr float kShare = 0.95F;

/// Distances, for a quantile without sorting.
struct Distances {
    static constexpr int kBins = 128;
    static constexpr float kBin = 2.0F;  ///< Millimetres.
    std::array<int, kBins> bins{};
    int count = 0;

    void add(float millimetres) {
        ++bins[static_cast<std::size_t>(std::clamp(static_cast<int>(millimetres / kBin), 0, kBins - 1))];
        ++count;
    }
    [[nodiscard]] float quantile(float share) const {
        const float wanted = share * static_cast<float>(count);
        int below = 0;
        for (int bin = 0; bin < kBins; ++bin) {
            const int here = bins[static_cast<std::size_t>(bin)];
            if (here > 0 && static_cast<float>(below + here) >= wanted) {
                const float within = (wanted - static_cast<float>(below)) / static_cast<float>(here);
                return (static_cast<float>(bin) + within) * kBin;
            }
            below += here;
        }
        return static_cast<float>(kBins) * kBin;
    }
};

}  // namespace

void HandReliefJob::run() {
    relief = HandRelief{};
    const auto eachPoint = [&](auto&& visit) {
        for (int row = 0; row < kHandGrid; ++row) {
            for (int column = 0; column < kHandGrid; ++column) {
                if ((*mask)[handIndex(column, row)] == 0) continue;
                const float across = static_cast<float>(column - kHandMiddle) * pixelsPerCell;
                const float down = static_cast<float>(row - kHandMiddle) * pixelsPerCell;
                const int u = static_cast<int>(std::lround(centre.x() + across));
                const int v = static_cast<int>(std::lround(centre.y() + down));
                if (!depth.contains(u, v)) continue;
                const auto z = static_cast<float>(depth.at(u, v));
                if (z <= surface - HandRegionJob::kNearer || z >= surface + HandRegionJob::kFarther) continue;
                visit(unproject(intrinsics, static_cast<float>(u), static_cast<float>(v), z));
            }
        }
    };
    int count = 0;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
    Distances fromPalm;
    eachPoint([&](const Eigen::Vector3f& point) {
        const Eigen::Vector3f offset = point - palm;
        ++count;
        sum += offset;
        squares += offset * offset.transpose();
        fromPalm.add(offset.norm());
    });
    if (count < kLeastPoints) return;
    const auto number = static_cast<float>(count);
    const Eigen::Vector3f mean = sum / number;
    const Eigen::Matrix3f covariance = squares / number - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
    solver.computeDirect(covariance, Eigen::EigenvaluesOnly);
    Distances fromMean;
    eachPoint([&](const Eigen::Vector3f& point) { fromMean.add((point - palm - mean).norm()); });
    relief.breadth = std::sqrt(std::max(0.0F, solver.eigenvalues()[1]));
    relief.thickness = std::sqrt(std::max(0.0F, solver.eigenvalues()[0]));
    relief.spread = fromMean.quantile(kShare);
    relief.reach = fromPalm.quantile(kShare);
    relief.valid = true;
}

}  // namespace cheval::fitting::tracking

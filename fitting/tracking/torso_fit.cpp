#include "fitting/tracking/torso_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "fitting/tracking/articulated_body.h"

namespace cheval::fitting::tracking {
namespace {

/// Half the width of a head's and a trunk's narrowest cut that still counts, for a stature of 1.7 m. Forearms and hands
/// are thinner.
constexpr float kHeadReach = 0.052F;
constexpr float kTrunkReach = 0.068F;
constexpr float kUsualStature = 1.70F;
/// The sensor loses the outermost hair and pixels of a head.
constexpr float kCrownLost = 0.012F;
/// How far behind the centre of the head the trunk's joints lie in a person who stands upright.
constexpr float kTrunkBehindHead = 0.026F;
/// From the front of the face to the centre of the head, in shares of the stature.
constexpr float kHeadHalfDepth = 0.040F;

/// Centimetre histogram of x in ±4 m, for a median without sorting.
struct Histogram {
    static constexpr int kBins = 800;
    static constexpr int kZero = kBins / 2;  ///< The bin of x = 0.
    std::array<int, kBins> bins{};
    int count = 0;

    void add(float metres) {
        const int bin = static_cast<int>(std::lround(metres * 100.0F)) + kZero;
        if (bin < 0 || bin >= kBins) return;
        ++bins[static_cast<std::size_t>(bin)];
        ++count;
    }
    [[nodiscard]] float median() const {
        int below = 0;
        for (int bin = 0; bin < kBins; ++bin) {
            below += bins[static_cast<std::size_t>(bin)];
            if (2 * below >= count) return static_cast<float>(bin - kZero) * 0.01F;
        }
        return 0.0F;
    }
};

}  // namespace

void TorsoFitJob::run() {
    const Silhouette& s = *silhouette;
    pose = TorsoPose{};
    pose.stature = stature > 0.0F ? stature : kUsualStature;
    if (s.cells < 60) return;

    Histogram widths;
    const float reach = kTrunkReach * pose.stature / kUsualStature;
    for (int row = s.top; row <= s.bottom; ++row) {
        for (int column = s.left; column <= s.right; ++column) {
            const std::size_t i = cellIndex(column, row);
            if (s.inside[i] == 0 || cloud->depth[i] <= 0.0F) continue;
            if (s.reach[i] * cloud->cellSize(s.surface[i]) >= reach) widths.add(cloud->x[i]);
        }
    }
    if (widths.count < 20) return;
    if (!findHead(widths.median())) return;
    if (stature <= 0.0F && floorKnown) pose.stature = std::clamp(pose.crown, 0.9F, 2.2F);
    fitTrunk();
    placeJoints();
    pose.found = true;
}

bool TorsoFitJob::findHead(float centre) {
    const Silhouette& s = *silhouette;
    const float scale = pose.stature / kUsualStature;
    std::size_t best = kCloudCells;
    const auto search = [&](float about, float width, float lowest) {
        for (int row = s.top; row <= s.bottom; ++row) {
            for (int column = s.left; column <= s.right; ++column) {
                const std::size_t i = cellIndex(column, row);
                if (s.inside[i] == 0 || cloud->depth[i] <= 0.0F) continue;
                if (std::abs(cloud->x[i] - about) > width || cloud->y[i] < lowest) continue;
                if (s.limbReach[i] * cloud->cellSize(s.surface[i]) < kHeadReach * scale) continue;
                if (best == kCloudCells || cloud->y[i] > cloud->y[best]) best = i;
            }
        }
    };
    if (previous != nullptr && previous->found && previous->headSeen) {
        search(previous->head.x(), 0.22F, previous->head.y() - 0.25F);
    }
    if (best == kCloudCells) search(centre, 0.40F, -10.0F);
    if (best == kCloudCells) return false;

    // Up to the crown: hair returns little, so the walk may end early; a raised hand behind the head may prolong it.
    const int column = cellColumn(best);
    int row = cellRow(best);
    const float size = cloud->cellSize(s.surface[best]);
    const int most = static_cast<int>(0.10F * scale / size);
    int steps = 0;
    while (steps < most && row - 1 >= s.top && s.inside[cellIndex(column, row - 1)] != 0 &&
           std::abs(s.surface[cellIndex(column, row - 1)] - s.surface[best]) < 0.15F) {
        --row;
        ++steps;
    }
    const float walked = static_cast<float>(steps) * size;
    pose.crown = cloud->y[best] + std::max(walked, kHeadReach * scale) + kCrownLost * scale;

    const float headHeight = 0.135F * pose.stature;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
    for (int y = s.top; y <= s.bottom; ++y) {
        for (int x = s.left; x <= s.right; ++x) {
            const std::size_t i = cellIndex(x, y);
            if (s.inside[i] == 0 || cloud->depth[i] <= 0.0F) continue;
            if (std::abs(cloud->x[i] - cloud->x[best]) > 0.11F * scale) continue;
            if (cloud->y[i] < pose.crown - headHeight || cloud->y[i] > pose.crown) continue;
            if (std::abs(cloud->depth[i] - s.surface[best]) > 0.14F) continue;
            sum += cloud->point(i);
            ++count;
        }
    }
    if (count == 0) return false;
    const Eigen::Vector3f mean = sum / static_cast<float>(count);
    pose.head = {mean.x(), pose.crown - kHeadCentre * usualLengths(pose.stature)[index(BodyLength::headDrop)],
                 mean.z() + kHeadHalfDepth * pose.stature};
    pose.headSeen = true;
    return true;
}

void TorsoFitJob::fitTrunk() {
    const Silhouette& s = *silhouette;
    const float scale = pose.stature / kUsualStature;
    const float upper = pose.crown - 0.24F * pose.stature;
    const float lower = pose.crown - 0.53F * pose.stature;
    middle = pose.head.x();
    slope = 0.0F;
    pose.surface = {pose.head.z() - kHeadHalfDepth * pose.stature, 0.0F, 0.0F};

    // Twice: the first round finds the trunk, the second leaves out what does not lie on it.
    Histogram depths;
    const auto each = [&](auto&& visit) {
        for (int row = s.top; row <= s.bottom; ++row) {
            for (int column = s.left; column <= s.right; ++column) {
                const std::size_t i = cellIndex(column, row);
                if (s.inside[i] == 0 || cloud->depth[i] <= 0.0F) continue;
                if (cloud->y[i] > upper || cloud->y[i] < lower) continue;
                visit(i);
            }
        }
    };
    for (int round = 0; round < 2; ++round) {
        // sum of weights for x = middle + slope·h, with the slope held near 0 by a prior.
        float n = 0.0F, h1 = 0.0F, h2 = 0.0F, x1 = 0.0F, hx = 0.0F;
        each([&](std::size_t i) {
            const float h = cloud->y[i] - pose.crown;
            if (std::abs(cloud->x[i] - (middle + slope * h)) > (round == 0 ? 0.30F : 0.16F) * scale) return;
            const float reach = s.reach[i] * cloud->cellSize(s.surface[i]);
            if (reach < kTrunkReach * scale) return;
            n += 1.0F;
            h1 += h;
            h2 += h * h;
            x1 += cloud->x[i];
            hx += h * cloud->x[i];
        });
        if (n < 20.0F) break;
        const float meanH = h1 / n;
        const float variance = h2 / n - meanH * meanH + 0.004F;
        slope = std::clamp((hx / n - meanH * x1 / n) / variance, -0.6F, 0.6F);
        middle = x1 / n - slope * meanH;
    }
    const auto lateral = [&](std::size_t i) {
        return std::abs(cloud->x[i] - (middle + slope * (cloud->y[i] - pose.crown)));
    };
    each([&](std::size_t i) {
        if (lateral(i) < 0.085F * pose.stature) depths.add(cloud->z[i] - 3.0F);
    });
    if (depths.count < 20) return;
    pose.surface = {depths.median() + 3.0F, 0.0F, 0.0F};
    float tolerance = 0.16F;
    for (int round = 0; round < 3; ++round, tolerance = round == 1 ? 0.10F : 0.07F) {
        Eigen::Matrix3f normal = Eigen::Matrix3f::Zero();
        Eigen::Vector3f right = Eigen::Vector3f::Zero();
        const float meanY = 0.5F * (upper + lower);
        const float meanX = middle + slope * (meanY - pose.crown);
        const float base = pose.surface[0] + pose.surface[1] * meanX + pose.surface[2] * meanY;
        each([&](std::size_t i) {
            if (lateral(i) > 0.085F * pose.stature) return;
            const Eigen::Vector3f basis(1.0F, cloud->x[i] - meanX, cloud->y[i] - meanY);
            const float off = cloud->z[i] - (base + pose.surface[1] * basis[1] + pose.surface[2] * basis[2]);
            if (std::abs(off) > tolerance) return;
            normal += basis * basis.transpose();
            right += basis * cloud->z[i];
        });
        if (normal(0, 0) < 20.0F) break;
        // Weak priors: without evidence the trunk faces the glass and stands upright.
        normal(1, 1) += normal(0, 0) * 0.0008F;
        normal(2, 2) += normal(0, 0) * 0.004F;
        const Eigen::Vector3f plane = normal.ldlt().solve(right);
        if (!plane.allFinite()) break;
        pose.surface = {plane[0] - plane[1] * meanX - plane[2] * meanY, plane[1], plane[2]};
    }
}

TorsoPose TorsoPose::turned(float angle) const {
    // Trunks are broader than they are deep: the joints lie deeper under a side than under the front. Statures.
    constexpr float kDeeper = 0.03F;
    const Eigen::Vector3f middle = 0.25F * (shoulders[0] + shoulders[1] + hips[0] + hips[1]);
    const Eigen::Matrix3f turn = Eigen::AngleAxisf(-angle, up).toRotationMatrix();
    const Eigen::Vector3f back(0.0F, 0.0F, kDeeper * stature * std::abs(std::sin(angle)));
    TorsoPose pose = *this;
    for (std::size_t side = 0; side < kSideCount; ++side) {
        pose.shoulders[side] = middle + turn * (shoulders[side] - middle) + back;
        pose.hips[side] = middle + turn * (hips[side] - middle) + back;
    }
    pose.neck += back;
    pose.left = turn * left;
    pose.forward = turn * forward;
    pose.surface = {surface[0] + surface[1] * middle.x(), 0.0F, surface[2]};
    return pose;
}

void TorsoFitJob::placeJoints() {
    const float across = std::clamp(pose.surface[1], -1.7F, 1.7F);
    const float lean = std::clamp(0.5F * pose.surface[2], -0.35F, 0.35F);
    pose.left = Eigen::Vector3f(-1.0F, 0.0F, -across).normalized();
    pose.up = Eigen::Vector3f(slope, 1.0F, lean).normalized();
    pose.left = (pose.left - pose.up * pose.up.dot(pose.left)).normalized();
    pose.forward = pose.left.cross(pose.up);

    // A point of the spine, `drop` metres below the crown.
    const auto spine = [&](float drop, float headWeight) -> Eigen::Vector3f {
        const float y = pose.crown - drop * pose.up.y();
        const float line = middle + slope * (y - pose.crown);
        const float x = line + headWeight * (pose.head.x() - line);
        const float skin = pose.surface[0] + pose.surface[1] * line + pose.surface[2] * y;
        return Eigen::Vector3f(x, y, skin) - pose.forward * (halfDepth * pose.stature);
    };
    const float chest = pose.crown - 0.30F * pose.stature;
    const float front =
        pose.surface[0] + pose.surface[1] * (middle + slope * (chest - pose.crown)) + pose.surface[2] * chest;
    pose.halfDepth = (pose.head.z() - front) / pose.stature + kTrunkBehindHead;
    const BodyLengths size = usualLengths(pose.stature);
    const float neck = size[index(BodyLength::headDrop)];
    const float trunk = size[index(BodyLength::trunk)];
    pose.neck = spine(neck, 0.5F);
    const Eigen::Vector3f shoulder = spine(neck + kShoulderDrop * trunk, 0.3F);
    const Eigen::Vector3f hip = spine(neck + trunk, 0.0F);
    for (const Side side : {Side::left, Side::right}) {
        const Eigen::Vector3f aside = outwards(side) * pose.left;
        pose.shoulders[index(side)] = shoulder + size[index(BodyLength::shoulderHalfBreadth)] * aside;
        pose.hips[index(side)] = hip + size[index(BodyLength::hipHalfBreadth)] * aside;
    }
}

}  // namespace cheval::fitting::tracking

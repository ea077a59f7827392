#include "fitting/bake/skinning.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "fitting/bake/body_topology.h"
#include "fitting/bake/spline.h"

namespace cheval::fitting::bake {
namespace {

using Row = std::array<double, kJointCount>;

Joint mirrorOf(Joint joint) {
    switch (joint) {
        case Joint::leftShoulder:
            return Joint::rightShoulder;
        case Joint::leftElbow:
            return Joint::rightElbow;
        case Joint::leftHand:
            return Joint::rightHand;
        case Joint::rightShoulder:
            return Joint::leftShoulder;
        case Joint::rightElbow:
            return Joint::leftElbow;
        case Joint::rightHand:
            return Joint::leftHand;
        case Joint::leftHip:
            return Joint::rightHip;
        case Joint::leftKnee:
            return Joint::rightKnee;
        case Joint::leftFoot:
            return Joint::rightFoot;
        case Joint::rightHip:
            return Joint::leftHip;
        case Joint::rightKnee:
            return Joint::leftKnee;
        case Joint::rightFoot:
            return Joint::leftFoot;
        default:
            return joint;
    }
}

/// Adds a chain of three bones: from `first` to `second` round `border1`, to `third` round `border2`.
void addChain(Row& row, double along, std::array<Joint, 3> bones, std::array<double, 2> borders,
              std::array<double, 2> halfWidths, double share) {
    const double past1 = smoothStep(borders[0] - halfWidths[0], borders[0] + halfWidths[0], along);
    const double past2 = smoothStep(borders[1] - halfWidths[1], borders[1] + halfWidths[1], along);
    row[index(bones[0])] += share * (1.0 - past1);
    row[index(bones[1])] += share * past1 * (1.0 - past2);
    row[index(bones[2])] += share * past1 * past2;
}

/// Bones by place alone, for a vertex of the left half; limbs begin sharply.
Row firstWeights(Chart chart, double ring, const Vec3& place, const BodyField& field) {
    Row row{};
    const auto& joints = field.joints();
    if (chart == Chart::leftArm || chart == Chart::leftThumb) {
        const Loft::Shape& arm = field.armLoft().shape();
        const double limb = chart == Chart::leftThumb ? 1.0 : smoothStep(-0.2, 1.8, ring);
        row[index(Joint::torso)] += 1.0 - limb;
        addChain(row, (place - arm.origin).dot(arm.axis), {Joint::leftShoulder, Joint::leftElbow, Joint::leftHand},
                 {kElbowAlong, kWristAlong}, {0.050, 0.028}, limb);
        return row;
    }
    if (chart == Chart::leftLeg) {
        const Loft::Shape& leg = field.legLoft().shape();
        const double limb = smoothStep(-0.6, 1.4, ring);
        row[index(Joint::torso)] += 1.0 - limb;
        addChain(row, (place - leg.origin).dot(leg.axis), {Joint::leftHip, Joint::leftKnee, Joint::leftFoot},
                 {kKneeAlong, kAnkleAlong - 0.012}, {0.062, 0.040}, limb);
        return row;
    }
    // The neck leans forward: its borders are level behind and lower in front, as the rings are.
    const double tilt = 0.25 * (place.z() + 0.01);
    addChain(row, place.y() + tilt, {Joint::torso, Joint::neck, Joint::head}, {joints[index(Joint::neck)].y(), 1.555},
             {0.030, 0.035}, 1.0);
    return row;
}

SkinningWeights strongestFour(const Row& row) {
    std::array<std::size_t, kJointCount> order{};
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return row[a] > row[b]; });
    double sum = 0.0;
    std::array<double, 4> kept{};
    for (std::size_t i = 0; i < 4; ++i) {
        // What is below the eye's threshold only costs.
        kept[i] = row[order[i]] > 0.004 ? row[order[i]] : 0.0;
        sum += kept[i];
    }
    SkinningWeights weights;
    for (std::size_t i = 0; i < 4; ++i) {
        weights.joint[i] = kept[i] > 0.0 ? static_cast<std::uint8_t>(order[i]) : std::uint8_t{0};
        weights.weight[i] = static_cast<float>(kept[i] / sum);
    }
    return weights;
}

}  // namespace

std::vector<SkinningWeights> skinningWeights(const QuadMesh& mesh, const BodyField& field) {
    const std::vector<std::uint8_t> left = leftHalf(mesh);
    std::vector<Row> rows(mesh.positions.size(), Row{});
    std::vector<double> charts(mesh.positions.size(), 0.0);
    for (const QuadMesh::Quad& quad : mesh.quads) {
        const bool isLeft = quad.chart == Chart::leftArm || quad.chart == Chart::leftThumb ||
                            quad.chart == Chart::leftLeg || quad.chart == Chart::trunk;
        if (!isLeft) continue;
        for (std::size_t c = 0; c < 4; ++c) {
            const std::uint32_t v = quad.vertex[c];
            if (left[v] == 0) continue;
            // Where charts meet a vertex takes the mean of what each says.
            const Row row = firstWeights(quad.chart, quad.lattice[c].x(), mesh.positions[v], field);
            for (std::size_t j = 0; j < kJointCount; ++j) {
                rows[v][j] += row[j];
            }
            charts[v] += 1.0;
        }
    }
    const auto symmetrise = [&] {
        for (std::size_t v = 0; v < rows.size(); ++v) {
            if (mesh.onMidPlane(v)) {
                for (std::size_t j = 0; j < kJointCount; ++j) {
                    const std::size_t other = index(mirrorOf(static_cast<Joint>(j)));
                    if (other <= j) continue;
                    const double mean = 0.5 * (rows[v][j] + rows[v][other]);
                    rows[v][j] = mean;
                    rows[v][other] = mean;
                }
            } else if (left[v] == 0) {
                for (std::size_t j = 0; j < kJointCount; ++j) {
                    rows[v][j] = rows[mesh.mirrored[v]][index(mirrorOf(static_cast<Joint>(j)))];
                }
            }
        }
    };
    for (std::size_t v = 0; v < rows.size(); ++v) {
        for (double& weight : rows[v]) {
            weight = charts[v] > 0.0 ? weight / charts[v] : 0.0;
        }
    }
    symmetrise();
    constexpr int kRounds = 40;
    constexpr double kShare = 0.5;
    const auto around = neighbours(mesh);
    std::vector<Row> next = rows;
    for (int round = 0; round < kRounds; ++round) {
        for (std::size_t v = 0; v < rows.size(); ++v) {
            if (left[v] == 0) continue;
            Row mean{};
            for (const std::uint32_t other : around[v]) {
                for (std::size_t j = 0; j < kJointCount; ++j) {
                    mean[j] += rows[other][j];
                }
            }
            const auto count = static_cast<double>(around[v].size());
            for (std::size_t j = 0; j < kJointCount; ++j) {
                next[v][j] = rows[v][j] + kShare * (mean[j] / count - rows[v][j]);
            }
        }
        rows.swap(next);
        symmetrise();
    }
    std::vector<SkinningWeights> weights(rows.size());
    for (std::size_t v = 0; v < rows.size(); ++v) {
        if (left[v] != 0) weights[v] = strongestFour(rows[v]);
    }
    for (std::size_t v = 0; v < rows.size(); ++v) {
        if (left[v] != 0) continue;
        weights[v] = weights[mesh.mirrored[v]];
        for (std::size_t i = 0; i < 4; ++i) {
            if (weights[v].weight[i] > 0.0F) {
                weights[v].joint[i] =
                    static_cast<std::uint8_t>(index(mirrorOf(static_cast<Joint>(weights[v].joint[i]))));
            }
        }
    }
    return weights;
}

}  // namespace cheval::fitting::bake

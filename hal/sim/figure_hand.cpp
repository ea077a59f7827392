// Hands are built finger by finger: what the hull of a hand says of it is in its outline.
#include <array>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include "hal/sim/figure.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::Side;

Hold held(std::size_t first, std::size_t second, float share) {
    return {.first = static_cast<std::uint16_t>(first), .second = static_cast<std::uint16_t>(second), .share = share};
}

}  // namespace

void addHand(const Shopper& shopper, const Rig& rig, Side side, Mesh& mesh) {
    const Vector3f wrist = rig.at(side, SideBone::hand);
    const Vector3f along = (wrist - rig.at(side, SideBone::forearm)).normalized();
    const Vector3f thumbward = Vector3f::UnitZ();
    const Vector3f out = along.cross(thumbward);  // Out of the palm or out of the back; the section is symmetric.
    const float width = rig.palmHalfWidth;
    const float thickness = 0.36F * width;
    const std::size_t hand = bone(side, SideBone::hand);

    constexpr std::array<float, 8> kAlong = {-0.10F, 0.05F, 0.2F, 0.4F, 0.6F, 0.8F, 0.95F, 1.04F};
    constexpr std::array<float, 8> kWidth = {0.66F, 0.70F, 0.84F, 0.94F, 1.0F, 1.03F, 1.0F, 0.85F};
    constexpr std::array<float, 8> kThick = {1.25F, 1.15F, 1.1F, 1.05F, 1.0F, 0.92F, 0.75F, 0.4F};
    std::array<Ring, 10> rings;
    for (std::size_t i = 0; i < kAlong.size(); ++i) {
        rings[i] = {.centre = wrist + kAlong[i] * rig.palmLength * along,
                    .across = thumbward,
                    .ahead = out,
                    .halfWidth = width * kWidth[i],
                    .front = thickness * kThick[i],
                    .back = thickness * kThick[i],
                    .hold = held(hand, hand, 0.0F),
                    .colour = shopper.skin,
                    .squareness = 2.5F};
    }
    addLoft(mesh, std::span(rings).first(kAlong.size()), 16, Material::skin, Cap::open, Cap::flat);

    for (std::size_t finger = 0; finger < kFingerCount; ++finger) {
        const float length = rig.fingerLength[finger];
        const float radius = rig.fingerRadius * (finger == 0 ? 1.22F : finger == 4 ? 0.88F : 1.0F);
        const Vector3f base = rig.rest[phalanx(side, finger, 0)];
        constexpr std::array<float, 10> kStep = {-0.16F, 0.04F, 0.3F, 0.44F, 0.58F, 0.75F, 0.86F, 0.94F, 0.985F, 1.0F};
        constexpr std::array<float, 10> kRadius = {0.95F, 1.0F, 0.98F, 0.97F, 0.93F, 0.88F, 0.84F, 0.7F, 0.45F, 0.12F};
        for (std::size_t i = 0; i < kStep.size(); ++i) {
            const float s = kStep[i];
            Hold hold =
                held(hand, phalanx(side, finger, 0), finger == 0 ? (i == 0 ? 0.4F : 1.0F) : (i == 0 ? 0.0F : 1.0F));
            if (s > 0.2F) {
                hold = held(phalanx(side, finger, 0), phalanx(side, finger, 1),
                            s < 0.4F   ? 0.0F
                            : s < 0.5F ? 0.5F
                                       : 1.0F);
            }
            if (s > 0.6F) {
                hold = held(phalanx(side, finger, 1), phalanx(side, finger, 2),
                            s < 0.7F   ? 0.0F
                            : s < 0.8F ? 0.5F
                                       : 1.0F);
            }
            const float thick = finger == 0 && s < 0.1F ? 1.2F : 1.0F;
            rings[i] = {.centre = base + s * length * along,
                        .across = thumbward,
                        .ahead = out,
                        .halfWidth = radius * kRadius[i] * thick,
                        .front = 0.95F * radius * kRadius[i] * thick,
                        .back = 0.95F * radius * kRadius[i] * thick,
                        .hold = hold,
                        .colour = shopper.skin};
        }
        addLoft(mesh, std::span(rings).first(kStep.size()), 8, Material::skin, Cap::flat, Cap::flat);
    }
}

}  // namespace cheval::hal::sim

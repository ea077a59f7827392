#include "hal/sim/tape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/sim/bare_body.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using fitting::Dimension;
using fitting::Side;

constexpr float kTau = 2.0F * std::numbers::pi_v<float>;

/// Points of a section, seen along its axis.
struct Section {
    std::array<Vector2f, kMaximumTapePoints> points;
    std::size_t count = 0;

    void add(const Vector3f& point) {
        if (count < points.size()) points[count++] = {point.x(), point.z()};
    }
    [[nodiscard]] float girth() { return tapeLength(std::span(points).first(count)); }
};

/// Cuts the skin between horizontal rings, ordered by height either way, at the height y. Its triangles' edges are
/// those from ring to ring, straight and across.
void cut(std::span<const Ring> rings, int segments, float y, Section& section) {
    for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
        const float from = rings[i].centre.y();
        const float to = rings[i + 1].centre.y();
        if ((from - y) * (to - y) > 0.0F || from == to) continue;
        const float share = (y - from) / (to - from);
        for (int j = 0; j < segments; ++j) {
            const auto at = [&](const Ring& ring, int segment) {
                return pointOf(ring, kTau * static_cast<float>(segment % segments) / static_cast<float>(segments));
            };
            const Vector3f upper = at(rings[i + 1], j);
            section.add((1.0F - share) * at(rings[i], j) + share * upper);
            section.add((1.0F - share) * at(rings[i], j + 1) + share * upper);
        }
        return;
    }
}

/// The neck leans: its sections are sheared, and seen along its axis they are what a tape square to it goes round.
float neckGirth(const Shopper& shopper, const Rig& rig) {
    const auto rings = neckRings(shopper, rig);
    const Vector3f axis = (rings.back().centre - rings.front().centre).normalized();
    const Vector3f ahead = Vector3f::UnitX().cross(axis);
    float thinnest = 9.0F;
    for (const Ring& ring : rings) {
        Section section;
        for (int j = 0; j < kNeckSegments; ++j) {
            const Vector3f point = pointOf(ring, kTau * static_cast<float>(j) / kNeckSegments) - ring.centre;
            section.add({point.x(), 0.0F, point.dot(ahead)});
        }
        thinnest = std::min(thinnest, section.girth());
    }
    return thinnest;
}

}  // namespace

float tapeLength(std::span<Vector2f> points) {
    if (points.size() < 2) return 0.0F;
    // Andrew's monotone chain.
    std::sort(points.begin(), points.end(),
              [](const Vector2f& a, const Vector2f& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
    std::array<Vector2f, kMaximumTapePoints + 1> hull;
    float length = 0.0F;
    const auto half = [&](auto begin, auto end) {
        std::size_t count = 0;
        for (auto point = begin; point != end && count < hull.size(); ++point) {
            while (count > 1) {
                const Vector2f side = hull[count - 1] - hull[count - 2];
                const Vector2f next = *point - hull[count - 2];
                if (side.x() * next.y() - side.y() * next.x() > 0.0F) break;
                --count;
            }
            hull[count++] = *point;
        }
        for (std::size_t i = 0; i + 1 < count; ++i)
            length += (hull[i + 1] - hull[i]).norm();
    };
    half(points.begin(), points.end());
    half(points.rbegin(), points.rend());
    return length;
}

TrueMeasurements measureBare(const Shopper& dressed) {
    const Shopper shopper = bareOf(dressed);
    const Rig rig = makeRig(shopper);
    const Trunk trunk(shopper, rig);
    std::array<Ring, kTrunkLevelCount> rings;
    std::transform(kTrunkLevels.begin(), kTrunkLevels.end(), rings.begin(),
                   [&](const Level& level) { return trunk.at(level, 0.0F, shopper.skin); });
    const auto left = legRings(shopper, rig, Side::left, 0.0F);
    const auto right = legRings(shopper, rig, Side::right, 0.0F);

    const auto girthAt = [&](float y) {
        Section section;
        cut(rings, kTrunkSegments, y, section);
        cut(left, kLegSegments, y, section);
        cut(right, kLegSegments, y, section);
        return section.girth();
    };
    const auto heightOf = [&](float level) { return trunk.crotch + level * (trunk.neckBase - trunk.crotch); };
    const auto seat = std::max_element(rings.begin(), rings.end(), [&](const Ring& a, const Ring& b) {
        const auto behind = [&](const Ring& ring) {
            const bool low = ring.centre.y() < heightOf(0.3F);
            return low ? ring.back - ring.centre.z() : -1.0F;
        };
        return behind(a) < behind(b);
    });

    TrueMeasurements truth{};
    const auto put = [&](Dimension dimension, float metres) { truth[static_cast<std::size_t>(dimension)] = metres; };
    put(Dimension::stature, rig.crown.y() - kCrownBelow * shopper.headHeight);
    put(Dimension::chestGirth, girthAt(heightOf(kBustHeight)));
    put(Dimension::waistGirth, girthAt(heightOf(kWaistHeight)));
    put(Dimension::hipGirth, girthAt(seat->centre.y()));
    put(Dimension::neckGirth, neckGirth(shopper, rig));
    const Vector3f shoulder = rig.at(Side::left, SideBone::upperArm);
    const Vector3f elbow = rig.at(Side::left, SideBone::forearm);
    put(Dimension::shoulderBreadth, (shoulder - rig.at(Side::right, SideBone::upperArm)).norm());
    put(Dimension::armLength, (elbow - shoulder).norm() + (rig.at(Side::left, SideBone::hand) - elbow).norm());
    put(Dimension::insideLeg, rings.front().centre.y());
    return truth;
}

}  // namespace cheval::hal::sim

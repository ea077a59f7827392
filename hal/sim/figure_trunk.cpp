// Trunk and neck with what is worn on them: trousers' seat, and a shirt that follows the body or falls from the chest.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Geometry>

#include "hal/sim/bare_body.h"
#include "hal/sim/figure.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::Side;

constexpr float kBeltHeight = 0.34F;  ///< Where trousers end below the shirt.
constexpr float kHemHeight = 0.06F;   ///< The shirt's hem.

/// Moves the lower edge of what hangs over the hips with the thighs.
void followThighs(Mesh& mesh, std::size_t first, std::size_t rings, int segments, std::span<const float> shares) {
    for (std::size_t i = 0; i < rings; ++i) {
        if (shares[i] <= 0.0F) continue;
        for (int j = 0; j < segments; ++j) {
            const std::size_t v = first + i * static_cast<std::size_t>(segments) + static_cast<std::size_t>(j);
            const float x = mesh.positions[v].x();
            const Side side = x > 0.0F ? Side::left : Side::right;
            const float reach = std::min(1.0F, std::abs(x) / 0.06F);
            mesh.holds[v] = heldBy(bone(Bone::pelvis), bone(side, SideBone::thigh), shares[i] * reach);
        }
    }
}

void addSeat(const Shopper& shopper, const Trunk& trunk, Mesh& mesh) {
    std::array<Ring, kTrunkLevelCount> rings;
    std::array<float, kTrunkLevelCount> shares{};
    std::size_t count = 0;
    for (const Level& level : kTrunkLevels) {
        if (level.height > kBeltHeight + 0.05F) break;
        shares[count] = 0.55F * (1.0F - smoothStep(-0.02F, 0.16F, level.height));
        rings[count] = trunk.at(level, 0.6F * shopper.clothEase + shopper.trouserEase, shopper.trousers);
        rings[count].shade = 0.88F + 0.12F * smoothStep(0.0F, 0.2F, level.height);
        ++count;
    }
    const Material trousers = shopper.darkTrousers ? Material::darkCloth : Material::cloth;
    const std::size_t first =
        addLoft(mesh, std::span(rings).first(count), kTrunkSegments, trousers, Cap::flat, Cap::open);
    followThighs(mesh, first, count, kTrunkSegments, shares);
}

/// A round collar above the shirt's last ring: lower in front, its edge turned in. Adds three rings.
void addCollar(const Shopper& shopper, const Rig& rig, std::span<Ring> rings, std::size_t& count) {
    const auto collar = [&](float width, float lift, float shade) {
        Ring ring = rings[count - 1];
        const float neck = neckRadius(shopper);
        ring.centre = rig.at(Bone::neck) + shopper.stature * Vector3f(0.0F, lift, 0.004F);
        ring.ahead = Vector3f(0.0F, -0.42F, 1.0F).normalized();
        ring.halfWidth = ring.front = ring.back = neck * width;
        ring.hold = Trunk::hold(1.0F);
        ring.squareness = 2.0F;
        ring.shade = shade;
        rings[count++] = ring;
    };
    collar(1.30F, 0.006F, 1.0F);
    collar(1.22F, 0.009F, 0.90F);
    collar(1.06F, 0.004F, 0.5F);
}

Material shirtOf(const Shopper& shopper) {
    return shopper.darkShirt ? Material::darkCloth : Material::cloth;
}

/// From a hem that stands off the hips a little, up to the collar.
void addShirt(const Shopper& shopper, const Rig& rig, const Trunk& trunk, Mesh& mesh) {
    std::array<Ring, kTrunkLevelCount + 5> rings;
    std::array<float, kTrunkLevelCount + 5> shares{};
    std::size_t count = 0;
    const auto add = [&](const Level& level, float ease, float shade) {
        shares[count] = 0.30F * (1.0F - smoothStep(0.03F, 0.16F, level.height));
        rings[count] = trunk.at(level, ease, shopper.shirt);
        rings[count].shade = shade;
        ++count;
    };
    const Level& hip = kTrunkLevels[2];
    const Level hem{kHemHeight, hip.width, hip.front, hip.back, hip.widthByBuild, hip.frontByBuild};
    add(hem, 0.4F * shopper.clothEase, 0.45F);  // The turned-in edge.
    add(hem, 1.9F * shopper.clothEase, 0.9F);
    for (const Level& level : kTrunkLevels) {
        if (level.height <= kHemHeight + 0.02F || level.height > 0.98F) continue;
        const float loose = 1.0F + 0.9F * (1.0F - smoothStep(0.1F, 0.6F, level.height));
        add(level, loose * shopper.clothEase, 1.0F);
    }
    addCollar(shopper, rig, rings, count);
    const std::size_t first =
        addLoft(mesh, std::span(rings).first(count), kTrunkSegments, shirtOf(shopper), Cap::open, Cap::open);
    followThighs(mesh, first, 3, kTrunkSegments, shares);
}

constexpr std::size_t kFallSteps = 30;
constexpr float kFallFrom = 0.70F;  ///< Where cloth leaves the body, as a level's height.

/// Cloth that lies on shoulders and chest and falls from there: it follows only what stands out below.
void addDrape(const Shopper& shopper, const Rig& rig, const Trunk& trunk, Mesh& mesh) {
    const Drape& drape = shopper.drape;
    constexpr float kTop = 0.97F;
    const float length = trunk.neckBase - trunk.crotch;
    const float hem = drape.hem / length;
    std::array<Ring, kFallSteps + 4> rings;
    std::array<float, kFallSteps + 4> shares{};
    std::array<float, kFallSteps + 4> heights{};
    std::array<float, kFallSteps + 4> reach{};
    const auto thighs = legRings(shopper, rig, Side::left, 0.0F);
    Ring above;
    for (std::size_t i = 0; i < kFallSteps; ++i) {
        const float height = kTop + (hem - kTop) * static_cast<float>(i) / static_cast<float>(kFallSteps - 1);
        // Below the crotch the body is as wide as the thighs above it.
        Ring body = trunk.section(std::max(height, 0.03F), shopper.shirt);
        body.centre.y() = trunk.crotch + height * length;
        for (const Ring& thigh : thighs) {
            if (std::abs(thigh.centre.y() - body.centre.y()) > 0.06F) continue;
            // A section is less deep before a thigh than in the middle, and who stands holds thighs a little forward.
            const float forward = 0.12F * std::max(0.0F, thighs.front().centre.y() - body.centre.y());
            body.front = std::max(body.front, 1.1F * (thigh.centre.z() + thigh.front) + forward);
            body.halfWidth = std::max(body.halfWidth, 1.02F * (thigh.centre.x() + thigh.halfWidth));
            body.back = std::max(body.back, 1.1F * (thigh.back - thigh.centre.z()));
        }
        Ring ring = body;
        const float worn = drape.ease * (0.45F + 0.55F * smoothStep(kTop, 0.80F, height));
        ring.halfWidth += worn;
        ring.front += worn;
        ring.back += worn;
        // The trousers are below it.
        const float under = (0.6F * shopper.clothEase + shopper.trouserEase) *
                            smoothStep(kBeltHeight + 0.14F, kBeltHeight + 0.08F, height);
        if (height < kFallFrom) {
            const float wider = drape.flare * (above.centre.y() - ring.centre.y());
            const float least = std::max(0.35F * drape.ease, under + 0.007F);
            const float ahead = above.centre.z() - ring.centre.z();
            ring.halfWidth = std::max(body.halfWidth + least, above.halfWidth + wider);
            ring.front = std::max(body.front + least, above.front + ahead + wider);
            ring.back = std::max(body.back + least, above.back - ahead + wider);
        }
        above = ring;
        // Bottom up, above the turned-in edge of the hem.
        const std::size_t at = kFallSteps - i;
        ring.shade = 0.93F + 0.07F * smoothStep(hem, 0.5F, height);
        rings[at] = ring;
        heights[at] = height;
        // As the seat below it, and more where it lies on the thighs.
        shares[at] =
            0.55F * (1.0F - smoothStep(-0.02F, 0.16F, height)) + 0.30F * (1.0F - smoothStep(-0.30F, 0.02F, height));
        const float room =
            std::min({ring.halfWidth - body.halfWidth, ring.front - body.front, ring.back - body.back}) - under;
        reach[at] = std::min(drape.folds * smoothStep(kFallFrom, std::min(0.15F, hem + 0.2F), height), 0.6F * room);
    }
    rings[0] = rings[1];
    const float turned = std::min(0.5F * drape.ease, 0.012F);
    rings[0].halfWidth -= turned;
    rings[0].front -= turned;
    rings[0].back -= turned;
    rings[0].shade = 0.45F;
    heights[0] = heights[1];
    shares[0] = shares[1];
    reach[0] = reach[1];
    std::size_t count = kFallSteps + 1;
    addCollar(shopper, rig, rings, count);
    const std::size_t first =
        addLoft(mesh, std::span(rings).first(count), kTrunkSegments, shirtOf(shopper), Cap::open, Cap::open);
    followThighs(mesh, first, kFallSteps + 1, kTrunkSegments, shares);
    for (std::size_t i = 0; i <= kFallSteps; ++i) {
        if (reach[i] <= 0.0F) continue;
        for (std::size_t j = 0; j < kTrunkSegments; ++j) {
            mesh.folds.push_back({.vertex = static_cast<std::uint32_t>(first + i * kTrunkSegments + j),
                                  .reach = reach[i],
                                  .angle = 2.0F * std::numbers::pi_v<float> * static_cast<float>(j) / kTrunkSegments,
                                  // Folds lean and are never two alike.
                                  .phase = drape.phase + 1.7F * heights[i]});
        }
    }
}

}  // namespace

void addTrunk(const Shopper& shopper, const Rig& rig, Mesh& mesh) {
    const Trunk trunk(shopper, rig);
    addSeat(shopper, trunk, mesh);
    if (shopper.drape.ease > 0.0F) {
        addDrape(shopper, rig, trunk, mesh);
    } else {
        addShirt(shopper, rig, trunk, mesh);
    }
    // Neck and the skin that the collar leaves bare.
    addLoft(mesh, neckRings(shopper, rig), kNeckSegments, Material::skin, Cap::open, Cap::open);
}

}  // namespace cheval::hal::sim

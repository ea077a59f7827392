// Head, plain face and hair.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Geometry>

#include "hal/sim/figure.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;

constexpr float kPi = std::numbers::pi_v<float>;

/// Half sizes at a height between chin (0) and crown (1), all as shares of the head's height.
struct HeadLevel {
    float height, width, front, back;
};
constexpr std::array<HeadLevel, 23> kHead = {
    {{0.000F, 0.070F, 0.300F, -0.160F}, {0.020F, 0.130F, 0.345F, -0.080F}, {0.050F, 0.175F, 0.368F, -0.010F},
     {0.090F, 0.207F, 0.380F, 0.060F},  {0.140F, 0.233F, 0.384F, 0.130F},  {0.190F, 0.252F, 0.386F, 0.200F},
     {0.240F, 0.266F, 0.388F, 0.255F},  {0.290F, 0.278F, 0.390F, 0.300F},  {0.340F, 0.288F, 0.391F, 0.335F},
     {0.390F, 0.296F, 0.392F, 0.362F},  {0.440F, 0.303F, 0.392F, 0.385F},  {0.490F, 0.309F, 0.391F, 0.402F},
     {0.540F, 0.315F, 0.392F, 0.416F},  {0.590F, 0.320F, 0.396F, 0.426F},  {0.640F, 0.324F, 0.396F, 0.432F},
     {0.690F, 0.325F, 0.389F, 0.434F},  {0.740F, 0.321F, 0.376F, 0.428F},  {0.790F, 0.310F, 0.355F, 0.412F},
     {0.840F, 0.290F, 0.325F, 0.384F},  {0.890F, 0.258F, 0.283F, 0.340F},  {0.935F, 0.210F, 0.226F, 0.276F},
     {0.970F, 0.150F, 0.158F, 0.196F},  {0.992F, 0.078F, 0.082F, 0.102F}}};
constexpr int kHeadSegments = 40;

float bump(float value, float centre, float width) {
    const float u = (value - centre) / width;
    return std::exp(-u * u);
}
float smooth(float from, float to, float value) {
    const float u = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
    return u * u * (3.0F - 2.0F * u);
}

struct HeadFrame {
    float size;     ///< Height of the head.
    Vector3f chin;  ///< Middle of the head's axis at the height of the chin.
    Hold hold;
    float wide;

    [[nodiscard]] Vector3f at(float across, float height, float ahead) const {
        return chin + size * Vector3f(across * wide, height, ahead);
    }
    [[nodiscard]] Ring ring(const HeadLevel& level, float grow, const Vector3f& colour) const {
        return {.centre = chin + Vector3f(0.0F, level.height * size, 0.0F),
                .halfWidth = (level.width * wide + grow) * size,
                .front = (level.front + grow) * size,
                .back = (level.back + grow) * size,
                .hold = hold,
                .colour = colour,
                .squareness = 2.1F};
    }
};

/// Angle from straight ahead, 0 … π, of segment j.
float sideAngle(std::size_t j) {
    const float angle = 2.0F * kPi * static_cast<float>(j) / static_cast<float>(kHeadSegments);
    return std::abs(std::remainder(angle - 0.5F * kPi, 2.0F * kPi));
}

void addSkull(const Shopper& shopper, const HeadFrame& frame, Mesh& mesh) {
    std::array<Ring, kHead.size()> rings;
    for (std::size_t i = 0; i < kHead.size(); ++i)
        rings[i] = frame.ring(kHead[i], 0.0F, shopper.skin);
    const std::size_t first = addLoft(mesh, rings, kHeadSegments, Material::skin, Cap::flat, Cap::flat);
    for (std::size_t i = 0; i < kHead.size(); ++i) {
        const float v = kHead[i].height;
        for (std::size_t j = 0; j < kHeadSegments; ++j) {
            const float side = sideAngle(j);
            const float ridge = 0.030F * bump(side, 0.0F, 0.17F) * bump(v, 0.40F, 0.14F);  // Bridge of the nose.
            const float socket = -0.020F * bump(side, 0.42F, 0.20F) * bump(v, 0.495F, 0.055F);
            const float cheek = 0.012F * bump(side, 0.75F, 0.3F) * bump(v, 0.36F, 0.10F);
            const float chin = 0.022F * bump(side, 0.0F, 0.35F) * bump(v, 0.07F, 0.07F);
            const float under = -0.014F * bump(side, 0.0F, 0.4F) * bump(v, 0.155F, 0.03F);
            const std::size_t vertex = first + i * kHeadSegments + j;
            const Vector3f outward = (mesh.positions[vertex] - rings[i].centre).normalized();
            mesh.positions[vertex] += frame.size * (ridge + socket + cheek + chin + under) * outward;
            // A little blood in cheeks and nose, a little shade in the sockets and below the chin.
            const float blush = bump(side, 0.62F, 0.28F) * bump(v, 0.33F, 0.09F) +
                                0.5F * bump(side, 0.0F, 0.2F) * bump(v, 0.32F, 0.05F);
            Vector3f& albedo = mesh.albedo[vertex];
            albedo.y() *= 1.0F - 0.14F * blush;
            albedo.z() *= 1.0F - 0.14F * blush;
            albedo *= 1.0F - 0.16F * bump(side, 0.42F, 0.24F) * bump(v, 0.51F, 0.05F);
            albedo *= 1.0F - 0.30F * smooth(0.06F, -0.02F, v);
        }
    }
}

void addFace(const Shopper& shopper, const HeadFrame& frame, Mesh& mesh) {
    const Vector3f x = Vector3f::UnitX();
    const Vector3f y = Vector3f::UnitY();
    const Vector3f z = Vector3f::UnitZ();
    const auto blob = [&](const Vector3f& centre, const Vector3f& halfSize, const Vector3f& colour, Material material,
                          float tilt = 0.0F, float shade = 1.0F) {
        const Vector3f across = std::cos(tilt) * x + std::sin(tilt) * y;
        const Vector3f up = std::cos(tilt) * y - std::sin(tilt) * x;
        addEllipsoid(mesh,
                     {.centre = centre,
                      .across = across,
                      .up = up,
                      .ahead = z,
                      .halfSize = frame.size * halfSize,
                      .hold = frame.hold,
                      .colour = colour,
                      .shade = shade},
                     12, 8, material);
    };
    const Vector3f brow = 0.55F * shopper.hair + 0.25F * shopper.skin;
    const Vector3f lip(0.86F * shopper.skin.x(), 0.66F * shopper.skin.y(), 0.66F * shopper.skin.z());
    for (const float side : {-1.0F, 1.0F}) {
        blob(frame.at(side * 0.142F, 0.497F, 0.338F), {0.060F, 0.027F, 0.034F}, {0.90F, 0.89F, 0.87F}, Material::skin,
             side * 0.06F, 0.86F);
        blob(frame.at(side * 0.140F, 0.497F, 0.352F), {0.029F, 0.028F, 0.028F}, {0.24F, 0.17F, 0.13F}, Material::skin);
        // The upper lid, then the brow.
        blob(frame.at(side * 0.143F, 0.523F, 0.338F), {0.065F, 0.012F, 0.040F}, 0.72F * shopper.skin, Material::skin,
             side * 0.05F);
        blob(frame.at(side * 0.148F, 0.575F, 0.358F), {0.078F, 0.013F, 0.030F}, brow, Material::hair, -side * 0.10F);
        // Ear and nostril wing.
        blob(frame.at(side * 0.318F, 0.44F, -0.03F), {0.030F, 0.095F, 0.060F}, shopper.skin, Material::skin,
             -side * 0.12F, 0.9F);
        blob(frame.at(side * 0.036F, 0.335F, 0.408F), {0.030F, 0.026F, 0.035F}, shopper.skin, Material::skin, 0.0F,
             0.94F);
    }
    blob(frame.at(0.0F, 0.345F, 0.430F), {0.036F, 0.034F, 0.042F}, shopper.skin, Material::skin);
    blob(frame.at(0.0F, 0.224F, 0.382F), {0.088F, 0.014F, 0.024F}, 0.92F * lip, Material::skin);
    blob(frame.at(0.0F, 0.200F, 0.380F), {0.074F, 0.018F, 0.026F}, lip, Material::skin);
}

/// How far hair stands off the skull at a place, as a share of the head; negative where skin is bare.
float hairOffset(HairStyle style, float side, float height) {
    // The hairline: high over the forehead, down before the ears, round to the nape.
    const float front = 0.80F;
    const float temple = style == HairStyle::cropped ? 0.52F : 0.47F;
    const float nape = style == HairStyle::bob ? 0.02F : 0.16F;
    float line = front + (temple - front) * smooth(0.55F, 1.15F, side);
    line += (nape - temple) * smooth(1.35F, 2.1F, side);
    if (style == HairStyle::bob) line += (0.10F - line) * smooth(0.95F, 1.30F, side);
    float thickness = 0.05F;
    if (style == HairStyle::cropped) thickness = 0.026F;
    if (style == HairStyle::bob) thickness = 0.062F;
    if (style == HairStyle::ponytail) thickness = 0.036F;
    if (style == HairStyle::parted) thickness += 0.03F * smooth(0.75F, 1.0F, height);
    return -0.05F + (thickness + 0.05F) * smooth(line - 0.025F, line + 0.045F, height);
}

void addHair(const Shopper& shopper, const HeadFrame& frame, Mesh& mesh) {
    std::array<Ring, kHead.size()> rings;
    std::size_t count = 0;
    for (const HeadLevel& level : kHead) {
        HeadLevel lower = level;
        // A bob hangs straight down from the widest place instead of following the jaw.
        if (shopper.hairStyle == HairStyle::bob && level.height < 0.6F) {
            lower.width = std::max(level.width, 0.318F);
            lower.back = std::max(level.back, 0.40F);
        } else {
            lower.back = std::max(level.back, 0.10F);
        }
        rings[count++] = frame.ring(lower, 0.0F, shopper.hair);
    }
    const std::size_t first = addLoft(mesh, rings, kHeadSegments, Material::hair, Cap::flat, Cap::flat);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < kHeadSegments; ++j) {
            const std::size_t vertex = first + i * kHeadSegments + j;
            const float side = sideAngle(j);
            const float v = kHead[i].height;
            const Vector3f middle = frame.at(0.0F, std::min(v, 0.62F), 0.0F);
            const Vector3f outward = (mesh.positions[vertex] - middle).normalized();
            mesh.positions[vertex] += frame.size * hairOffset(shopper.hairStyle, side, v) * outward;
            mesh.positions[vertex] += shopper.hairRise * smooth(0.60F, 0.95F, v) * outward;
            // Soft strands, and shade towards the ends.
            const float strand = 0.90F + 0.10F * std::sin(9.0F * side + 3.0F * v);
            mesh.albedo[vertex] *= strand * (0.75F + 0.25F * smooth(0.1F, 0.8F, v));
        }
    }
    // The cap over the crown follows the last ring.
    mesh.positions[first + count * kHeadSegments + 1] += Vector3f(0.0F, 0.035F * frame.size + shopper.hairRise, 0.0F);
    if (shopper.hairStyle == HairStyle::ponytail) {
        constexpr std::array<float, 7> kDown = {0.70F, 0.66F, 0.52F, 0.32F, 0.10F, -0.10F, -0.20F};
        constexpr std::array<float, 7> kBehind = {-0.40F, -0.49F, -0.56F, -0.57F, -0.54F, -0.50F, -0.47F};
        constexpr std::array<float, 7> kRadius = {0.05F, 0.075F, 0.11F, 0.115F, 0.095F, 0.06F, 0.02F};
        std::array<Ring, 7> tail;
        for (std::size_t i = 0; i < tail.size(); ++i) {
            tail[i] = {.centre = frame.at(0.0F, kDown[i], kBehind[i]),
                       .halfWidth = kRadius[i] * frame.size,
                       .front = 0.75F * kRadius[i] * frame.size,
                       .back = 0.75F * kRadius[i] * frame.size,
                       .hold = frame.hold,
                       .colour = shopper.hair};
        }
        addLoft(mesh, tail, 14, Material::hair, Cap::flat, Cap::flat);
    }
}

}  // namespace

void addHead(const Shopper& shopper, const Rig& rig, Mesh& mesh) {
    const Hold hold{.first = static_cast<std::uint16_t>(bone(Bone::head)),
                    .second = static_cast<std::uint16_t>(bone(Bone::head)),
                    .share = 0.0F};
    const HeadFrame frame{
        .size = shopper.headHeight,
        .chin = Vector3f(0.0F, shopper.stature + shopper.lift - shopper.headHeight, rig.headCentre.z()),
        .hold = hold,
        .wide = 0.96F + 0.06F * shopper.masculine + 0.05F * shopper.build};
    addSkull(shopper, frame, mesh);
    addFace(shopper, frame, mesh);
    if (shopper.hairStyle != HairStyle::none) addHair(shopper, frame, mesh);
}

}  // namespace cheval::hal::sim

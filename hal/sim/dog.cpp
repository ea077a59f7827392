#include "hal/sim/dog.h"

#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Geometry>

#include "hal/sim/hash.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;
using fitting::Side;

constexpr float kPi = std::numbers::pi_v<float>;
constexpr std::array<Side, 2> kSides = {Side::left, Side::right};

Hold held(std::size_t which) {
    return {.first = static_cast<std::uint16_t>(which), .second = static_cast<std::uint16_t>(which), .share = 0.0F};
}

/// A cross-section of the trunk, upright across its length; shares of the length and of the shoulder's height.
struct Section {
    float ahead, height, halfWidth, halfHeight;
};
constexpr std::array<Section, 8> kTrunk = {{{-0.52F, 0.86F, 0.06F, 0.07F},
                                            {-0.46F, 0.84F, 0.15F, 0.18F},
                                            {-0.30F, 0.82F, 0.18F, 0.21F},
                                            {-0.05F, 0.80F, 0.165F, 0.20F},
                                            {0.20F, 0.76F, 0.20F, 0.26F},
                                            {0.38F, 0.78F, 0.20F, 0.26F},
                                            {0.48F, 0.84F, 0.15F, 0.20F},
                                            {0.55F, 0.88F, 0.06F, 0.09F}}};

void addTrunk(const Dog& dog, Mesh& mesh) {
    std::array<Ring, kTrunk.size()> rings;
    for (std::size_t i = 0; i < kTrunk.size(); ++i) {
        const Section& section = kTrunk[i];
        rings[i] = {.centre = {0.0F, section.height * dog.shoulderHeight, section.ahead * dog.length},
                    .across = Vector3f::UnitX(),
                    .ahead = Vector3f::UnitY(),
                    .halfWidth = section.halfWidth * dog.shoulderHeight,
                    .front = section.halfHeight * dog.shoulderHeight,
                    .back = section.halfHeight * dog.shoulderHeight,
                    .hold = held(bone(Bone::pelvis)),
                    .colour = dog.coat};
    }
    addLoft(mesh, rings, 24, Material::hair, Cap::flat, Cap::flat);
}

/// A tube of coat from one point to another.
void addTaper(Mesh& mesh, const Vector3f& from, const Vector3f& to, float thick, float thin, std::size_t which,
              const Vector3f& colour) {
    const Vector3f along = (to - from).normalized();
    const Vector3f side = std::abs(along.x()) > 0.9F ? Vector3f::UnitY() : Vector3f::UnitX();
    const Vector3f across = (side - side.dot(along) * along).normalized();
    std::array<Ring, 4> rings;
    for (std::size_t i = 0; i < rings.size(); ++i) {
        const float share = static_cast<float>(i) / static_cast<float>(rings.size() - 1);
        const float radius = thick + share * (thin - thick);
        rings[i] = {.centre = from + share * (to - from),
                    .across = across,
                    .ahead = along.cross(across),
                    .halfWidth = radius,
                    .front = radius,
                    .back = radius,
                    .hold = held(which),
                    .colour = colour};
    }
    addLoft(mesh, rings, 12, Material::hair, Cap::flat, Cap::flat);
}

void addHeadAndTail(const Dog& dog, const Rig& rig, Mesh& mesh) {
    const float h = dog.shoulderHeight;
    const Vector3f neck = rig.at(Bone::neck);
    const Vector3f head = rig.at(Bone::head);
    const Vector3f nose = head + h * Vector3f(0.0F, -0.09F, 0.33F);
    addTaper(mesh, neck + h * Vector3f(0.0F, -0.05F, -0.1F), head, 0.16F * h, 0.12F * h, bone(Bone::neck), dog.coat);
    addTaper(mesh, head - h * Vector3f(0.0F, 0.0F, 0.10F), nose, 0.14F * h, 0.06F * h, bone(Bone::head), dog.coat);
    for (const float side : {-1.0F, 1.0F}) {
        addTaper(mesh, head + h * Vector3f(0.09F * side, 0.08F, 0.0F), head + h * Vector3f(0.12F * side, 0.24F, -0.02F),
                 0.05F * h, 0.015F * h, bone(Bone::head), 0.8F * dog.coat);
    }
    const Vector3f root(0.0F, 0.90F * h, -0.50F * dog.length);
    addTaper(mesh, root, root + h * Vector3f(0.0F, 0.28F, -0.36F), 0.05F * h, 0.02F * h, bone(Bone::pelvis), dog.coat);
}

}  // namespace

Dog makeDog(std::uint32_t key) {
    Draw draw(key);
    constexpr std::array<std::array<float, 3>, 4> kCoats = {
        {{0.55F, 0.42F, 0.28F}, {0.20F, 0.18F, 0.17F}, {0.80F, 0.72F, 0.58F}, {0.45F, 0.44F, 0.43F}}};
    Dog dog;
    dog.shoulderHeight = draw.between(0.32F, 0.72F);
    dog.length = dog.shoulderHeight * draw.between(1.05F, 1.25F);
    const auto& coat = kCoats[draw.choice(4)];
    dog.coat = {coat[0], coat[1], coat[2]};
    return dog;
}

Rig makeDogRig(const Dog& dog) {
    Rig rig;
    rig.rest.fill(Vector3f::Zero());
    const float h = dog.shoulderHeight;
    rig.crown = {0.0F, h, 0.0F};
    rig.rest[bone(Bone::pelvis)] = {0.0F, 0.8F * h, 0.0F};
    rig.rest[bone(Bone::neck)] = {0.0F, 0.92F * h, 0.48F * dog.length};
    rig.rest[bone(Bone::head)] = {0.0F, 1.22F * h, 0.48F * dog.length + 0.22F * h};
    for (const Side side : kSides) {
        const float x = (side == Side::left ? 0.13F : -0.13F) * h;
        rig.rest[bone(side, SideBone::upperArm)] = {x, 0.72F * h, 0.38F * dog.length};
        rig.rest[bone(side, SideBone::forearm)] = {x, 0.38F * h, 0.35F * dog.length};
        rig.rest[bone(side, SideBone::thigh)] = {x, 0.76F * h, -0.38F * dog.length};
        rig.rest[bone(side, SideBone::shin)] = {x, 0.40F * h, -0.40F * dog.length};
    }
    return rig;
}

void buildDog(const Dog& dog, const Rig& rig, Mesh& mesh) {
    mesh.clear();
    addTrunk(dog, mesh);
    addHeadAndTail(dog, rig, mesh);
    const float h = dog.shoulderHeight;
    for (const Side side : kSides) {
        for (const auto& [upper, lower] :
             {std::pair{SideBone::upperArm, SideBone::forearm}, std::pair{SideBone::thigh, SideBone::shin}}) {
            const Vector3f hip = rig.at(side, upper);
            const Vector3f knee = rig.at(side, lower);
            const Vector3f paw(knee.x(), 0.02F * h, knee.z() + 0.04F * h);
            addTaper(mesh, hip, knee, 0.12F * h, 0.065F * h, bone(side, upper), dog.coat);
            addTaper(mesh, knee, paw, 0.06F * h, 0.05F * h, bone(side, lower), 0.9F * dog.coat);
        }
    }
    mesh.finish();
}

Pose solveDog(const Dog& dog, const Rig& rig, const Walk& walk, double time) {
    const Place place = walk.place(walk.progress(time));
    const auto about = [](float angle, const Vector3f& axis) {
        return Matrix3f(Eigen::AngleAxisf(angle, axis).toRotationMatrix());
    };
    const Matrix3f facing = about(kPi + place.yaw, Vector3f::UnitY());
    const float phase = kPi * walk.gait(time);
    const float vigour = walk.vigour(time);
    Pose pose;
    pose.rotation.fill(facing);
    const std::size_t body = bone(Bone::pelvis);
    pose.position.fill(Vector3f::Zero());
    pose.position[body] = {place.position.x(),
                           rig.rest[body].y() + 0.015F * dog.shoulderHeight * std::sin(2.0F * phase),
                           place.position.y()};
    const auto hang = [&](std::size_t child, std::size_t parent, float swing) {
        pose.position[child] = pose.apply(rig, parent, rig.rest[child]);
        pose.rotation[child] = pose.rotation[parent] * about(swing, Vector3f::UnitX());
    };
    hang(bone(Bone::neck), body, 0.08F * vigour * std::sin(2.0F * phase));
    hang(bone(Bone::head), bone(Bone::neck), -0.05F * vigour * std::sin(2.0F * phase));
    for (const Side side : kSides) {
        // A foreleg goes with the hind leg of the other side.
        const float swing = (side == Side::left ? 0.45F : -0.45F) * vigour * std::sin(phase);
        hang(bone(side, SideBone::upperArm), body, swing);
        hang(bone(side, SideBone::forearm), bone(side, SideBone::upperArm), 0.4F * std::abs(swing));
        hang(bone(side, SideBone::thigh), body, -swing);
        hang(bone(side, SideBone::shin), bone(side, SideBone::thigh), 0.4F * std::abs(swing));
    }
    return pose;
}

}  // namespace cheval::hal::sim

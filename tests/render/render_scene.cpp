#include "tests/render/render_scene.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace cheval::test {
namespace {

constexpr float kSensorHeight = 1.05F;
constexpr float kWallZ = 3.4F;

struct Capsule {
    Eigen::Vector3f a, b;
    float radius = 0.0F;
    hal::Rgb8 colour;
    bool person = true;
};

/// Nearest distance along the ray from the origin at which it meets the capsule; infinite if it does not.
float meet(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, const Capsule& capsule) {
    const Eigen::Vector3f axis = capsule.b - capsule.a;
    const Eigen::Vector3f offset = origin - capsule.a;
    const float length2 = axis.squaredNorm();
    const float along = axis.dot(direction);
    const float start = axis.dot(offset);
    const float a = length2 - along * along;
    const float b = length2 * direction.dot(offset) - start * along;
    const float c = length2 * offset.squaredNorm() - start * start - capsule.radius * capsule.radius * length2;
    float best = std::numeric_limits<float>::infinity();
    if (a > 1e-9F && b * b - a * c >= 0.0F) {
        const float t = (-b - std::sqrt(b * b - a * c)) / a;
        const float at = start + t * along;
        if (t > 0.0F && at > 0.0F && at < length2) best = t;
    }
    for (const Eigen::Vector3f& end : {capsule.a, capsule.b}) {
        const Eigen::Vector3f to = origin - end;
        const float half = direction.dot(to);
        const float discriminant = half * half - to.squaredNorm() + capsule.radius * capsule.radius;
        if (discriminant >= 0.0F && -half - std::sqrt(discriminant) > 0.0F)
            best = std::min(best, -half - std::sqrt(discriminant));
    }
    return best;
}

}  // namespace

RenderScene::RenderScene(const RenderSceneOptions& options) : options_(options) {
    switch (options.mounting) {
        case Mounting::upright:
            break;
        case Mounting::rightEdgeUp:
            placement_.rotation << 0, 1, 0, 1, 0, 0, 0, 0, 1;
            break;
        case Mounting::leftEdgeUp:
            placement_.rotation << 0, -1, 0, -1, 0, 0, 0, 0, 1;
            break;
    }
    placement_.translation = {0.0F, kSensorHeight, 0.0F};
    const Eigen::Vector3f ground(options.personX, 0.0F, options.personZ);
    skeleton_.userId = 1;
    const auto joint = [&](fitting::Joint which, float x, float y, float z) {
        skeleton_[which] = {.position = ground + Eigen::Vector3f(x, y, z), .confidence = 1.0F};
    };
    using fitting::Joint;
    joint(Joint::head, 0, 1.62F, 0);
    joint(Joint::neck, 0, 1.42F, 0);
    joint(Joint::torso, 0, 1.15F, 0);
    joint(Joint::leftShoulder, -0.19F, 1.40F, 0);
    joint(Joint::rightShoulder, 0.19F, 1.40F, 0);
    joint(Joint::leftElbow, -0.36F, 1.15F, 0);
    joint(Joint::rightElbow, 0.36F, 1.15F, 0);
    joint(Joint::leftHand, -0.52F, 0.92F, 0);
    joint(Joint::rightHand, 0.52F, 0.92F, 0);
    joint(Joint::leftHip, -0.1F, 0.88F, 0);
    joint(Joint::rightHip, 0.1F, 0.88F, 0);
    joint(Joint::leftKnee, -0.12F, 0.48F, 0);
    joint(Joint::rightKnee, 0.12F, 0.48F, 0);
    joint(Joint::leftFoot, -0.13F, 0.08F, 0);
    joint(Joint::rightFoot, 0.13F, 0.08F, 0);
    if (options.armAcross) {
        joint(Joint::leftElbow, -0.30F, 1.15F, -0.2F);
        joint(Joint::leftHand, 0.14F, 1.16F, -0.28F);
    }
    makeMaterials();
    makeMesh();
    takePicture();
}

Eigen::Vector3f RenderScene::marker() const {
    return {options_.personX - 0.42F, 1.55F, options_.personZ};
}
Eigen::Vector3f RenderScene::chest() const {
    return {options_.personX, 1.28F, options_.personZ - 0.16F};
}
Eigen::Vector3f RenderScene::forearm() const {
    return (skeleton_[fitting::Joint::leftElbow].position + skeleton_[fitting::Joint::leftHand].position) / 2.0F;
}

void RenderScene::makeMaterials() {
    fitting::Material body{.name = "mannequin", .baseColour = {0.62F, 0.56F, 0.52F, 1.0F}, .roughness = 0.6F};
    fitting::Material cloth{.name = "striped cloth", .doubleSided = true};
    cloth.baseColourTexture.resize(64, 64);
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x)
            cloth.baseColourTexture.view().at(x, y) =
                (y / 8) % 2 == 0 ? hal::Rgba8{40, 92, 160, 255} : hal::Rgba8{226, 224, 214, 255};
    }
    materials_ = {std::move(body), std::move(cloth)};
}

void RenderScene::addTube(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius, fitting::PartKind kind,
                          std::uint32_t material, std::uint8_t layer) {
    constexpr std::uint32_t kAround = 40;
    constexpr std::uint32_t kAlong = 12;
    const Eigen::Vector3f axis = (to - from).normalized();
    const Eigen::Vector3f side = axis.unitOrthogonal();
    const Eigen::Vector3f other = axis.cross(side);
    const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
    const auto firstIndex = static_cast<std::uint32_t>(mesh_.indices.size());
    for (std::uint32_t j = 0; j <= kAlong; ++j) {
        for (std::uint32_t i = 0; i <= kAround; ++i) {
            const float u = static_cast<float>(i) / kAround;
            const float v = static_cast<float>(j) / kAlong;
            const float angle = 2.0F * std::numbers::pi_v<float> * u;
            const Eigen::Vector3f normal = side * std::cos(angle) + other * std::sin(angle);
            const Eigen::Vector3f point = from + (to - from) * v + normal * radius;
            mesh_.vertices.push_back(
                {point.x(), point.y(), point.z(), normal.x(), normal.y(), normal.z(), u, 1.0F - v});
        }
    }
    for (std::uint32_t j = 0; j < kAlong; ++j) {
        for (std::uint32_t i = 0; i < kAround; ++i) {
            const std::uint32_t a = first + j * (kAround + 1) + i;
            const std::uint32_t b = a + kAround + 1;
            for (const std::uint32_t index : {a, a + 1, b, a + 1, b + 1, b})
                mesh_.indices.push_back(index);
        }
    }
    mesh_.parts.push_back({.kind = kind,
                           .firstIndex = firstIndex,
                           .indexCount = static_cast<std::uint32_t>(mesh_.indices.size()) - firstIndex,
                           .material = material,
                           .layer = layer});
}

void RenderScene::makeMesh() {
    if (!options_.dressed) return;
    using fitting::Joint;
    const auto at = [this](Joint joint) { return skeleton_[joint].position; };
    const auto limb = [&](Joint a, Joint b, float radius) {
        addTube(at(a), at(b), radius, fitting::PartKind::body, 0, 0);
    };
    addTube(at(Joint::torso) - Eigen::Vector3f(0, 0.35F, 0), at(Joint::neck), 0.15F, fitting::PartKind::body, 0, 0);
    addTube(at(Joint::neck), at(Joint::head) + Eigen::Vector3f(0, 0.1F, 0), 0.085F, fitting::PartKind::body, 0, 0);
    limb(Joint::leftShoulder, Joint::leftElbow, 0.05F);
    limb(Joint::leftElbow, Joint::leftHand, 0.04F);
    limb(Joint::rightShoulder, Joint::rightElbow, 0.05F);
    limb(Joint::rightElbow, Joint::rightHand, 0.04F);
    limb(Joint::leftHip, Joint::leftKnee, 0.075F);
    limb(Joint::leftKnee, Joint::leftFoot, 0.055F);
    limb(Joint::rightHip, Joint::rightKnee, 0.075F);
    limb(Joint::rightKnee, Joint::rightFoot, 0.055F);
    const Eigen::Vector3f moved(0, 0, options_.clothBehind);
    addTube(at(Joint::torso) - Eigen::Vector3f(0, 0.3F, 0) + moved,
            at(Joint::neck) - Eigen::Vector3f(0, 0.03F, 0) + moved, 0.165F, fitting::PartKind::garment, 1, 1);
    mesh_.topologyRevision = 1;
}

void RenderScene::takePicture() {
    using fitting::Joint;
    const auto at = [this](Joint joint) { return skeleton_[joint].position; };
    std::vector<Capsule> world;
    const auto limb = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b, float radius) {
        world.push_back({.a = a, .b = b, .radius = radius, .colour = kSkinColour});
    };
    limb(at(Joint::torso) - Eigen::Vector3f(0, 0.25F, 0), at(Joint::neck) - Eigen::Vector3f(0, 0.12F, 0), 0.15F);
    limb(at(Joint::neck), at(Joint::head) + Eigen::Vector3f(0, 0.03F, 0), 0.085F);
    limb(at(Joint::leftShoulder), at(Joint::leftElbow), 0.05F);
    limb(at(Joint::leftElbow), at(Joint::leftHand), 0.045F);
    limb(at(Joint::rightShoulder), at(Joint::rightElbow), 0.05F);
    limb(at(Joint::rightElbow), at(Joint::rightHand), 0.045F);
    limb(at(Joint::leftHip), at(Joint::leftKnee), 0.075F);
    limb(at(Joint::leftKnee), at(Joint::leftFoot), 0.055F);
    limb(at(Joint::rightHip), at(Joint::rightKnee), 0.075F);
    limb(at(Joint::rightKnee), at(Joint::rightFoot), 0.055F);
    if (options_.sideMarker)
        world.push_back({.a = marker(),
                         .b = marker() + Eigen::Vector3f(0, 1e-3F, 0),
                         .radius = 0.06F,
                         .colour = kMarkerColour,
                         .person = false});
    colour_.resize(intrinsics_.width, intrinsics_.height);
    depth_.resize(intrinsics_.width, intrinsics_.height);
    userMap_.resize(intrinsics_.width, intrinsics_.height);
    for (int v = 0; v < intrinsics_.height; ++v) {
        for (int u = 0; u < intrinsics_.width; ++u) {
            const Eigen::Vector3f seen =
                fitting::unproject(intrinsics_, static_cast<float>(u), static_cast<float>(v), 1000.0F);
            const Eigen::Vector3f origin = placement_.translation;
            const Eigen::Vector3f direction = placement_.toMirror(seen) - origin;  // z along the axis is 1 m.
            const float length = direction.norm();
            const Capsule* nearest = nullptr;
            float best = std::numeric_limits<float>::infinity();
            for (const Capsule& capsule : world) {
                const float distance = meet(origin, direction / length, capsule) / length;
                if (distance < best) {
                    best = distance;
                    nearest = &capsule;
                }
            }
            const float wall = (kWallZ - origin.z()) / direction.z();
            const float floor = direction.y() < 0.0F ? -origin.y() / direction.y() : wall + 1.0F;
            const float scene = std::min(wall, floor);
            hal::Rgb8 colour;
            if (nearest != nullptr && best < scene) {
                const Eigen::Vector3f point = origin + direction * best;
                const float shade = 0.75F + 0.25F * std::cos(14.0F * point.y());
                const auto lit = [shade](std::uint8_t value) {
                    return static_cast<std::uint8_t>(static_cast<float>(value) * shade);
                };
                colour = nearest->person
                             ? hal::Rgb8{lit(nearest->colour.r), lit(nearest->colour.g), lit(nearest->colour.b)}
                             : nearest->colour;
                if (nearest->person) userMap_.view().at(u, v) = kUserLabel;
            } else {
                best = scene;
                const Eigen::Vector3f point = origin + direction * best;
                const bool odd = (static_cast<int>(std::floor(point.x() * 4.0F)) +
                                  static_cast<int>(std::floor((point.y() + point.z()) * 4.0F))) %
                                     2 !=
                                 0;
                colour = odd ? hal::Rgb8{150, 152, 150} : hal::Rgb8{128, 132, 136};
            }
            colour_.view().at(u, v) = colour;
            depth_.view().at(u, v) = static_cast<std::uint16_t>(std::lround(best * 1000.0F));
        }
    }
}

render::Scene RenderScene::scene(render::View view) const {
    render::Scene scene;
    scene.view = view;
    scene.mesh = options_.dressed ? &mesh_ : nullptr;
    if (options_.colour) scene.camera.colour = colour_.view();
    scene.camera.depth = depth_.view();
    scene.camera.userMap = userMap_.view();
    scene.camera.userLabel = kUserLabel;
    scene.camera.intrinsics = intrinsics_;
    scene.camera.placement = placement_;
    scene.skeleton = skeleton_;
    scene.hud.screen = render::Screen::acquiring;
    return scene;
}

}  // namespace cheval::test

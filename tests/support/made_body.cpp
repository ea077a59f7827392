#include "tests/support/made_body.h"

#include <cmath>
#include <numbers>

#include "fitting/layering/smooth_normals.h"

namespace cheval::test {

using namespace fitting;

namespace {

constexpr int kTubes = 6;

struct Ring {
    Eigen::Vector3f centre;
    float breadth = 0.1F;  // Half axes.
    float depth = 0.1F;
    Joint bone = Joint::torso;
    Joint next = Joint::torso;
    float nextWeight = 0.0F;
    BodyPart part = BodyPart::chest;
    bool top = false;       // Covered by a top …
    bool trousers = false;  // … or by trousers.
};

struct Tube {
    std::vector<Ring> rings;
    bool right = false;  // Mirror image of the tube before it.
};

constexpr Joint mirroredJoint(Joint joint) {
    if (joint >= Joint::leftShoulder && joint <= Joint::leftHand) return static_cast<Joint>(index(joint) + 3);
    if (joint >= Joint::leftHip && joint <= Joint::leftFoot) return static_cast<Joint>(index(joint) + 3);
    return joint;
}
constexpr BodyPart mirroredPart(BodyPart part) {
    const auto p = static_cast<int>(part);
    const bool left = (p >= static_cast<int>(BodyPart::leftUpperArm) && p <= static_cast<int>(BodyPart::leftHand)) ||
                      (p >= static_cast<int>(BodyPart::leftThigh) && p <= static_cast<int>(BodyPart::leftFoot));
    return left ? static_cast<BodyPart>(p + 3) : part;
}

// Rings from `from` to `to`, both included; the second half of a limb hands over to the next bone.
void addRings(std::vector<Ring>& rings, int count, Ring from, const Ring& to, float handOver) {
    for (int i = rings.empty() ? 0 : 1; i < count; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(count - 1);
        Ring ring = from;
        ring.centre = from.centre + t * (to.centre - from.centre);
        ring.breadth = from.breadth + t * (to.breadth - from.breadth);
        ring.depth = from.depth + t * (to.depth - from.depth);
        ring.next = to.bone;
        ring.nextWeight = t > handOver ? 0.5F * (t - handOver) / (1.0F - handOver) : 0.0F;
        rings.push_back(ring);
    }
}

std::vector<Tube> bodyTubes(int fine) {
    std::vector<Tube> tubes(kTubes);
    const auto rings = [fine](int coarse) { return (coarse - 1) * fine + 1; };
    addRings(tubes[0].rings, rings(5),
             {.centre = {0, 0.86F, 0},
              .breadth = 0.17F,
              .depth = 0.11F,
              .bone = Joint::torso,
              .part = BodyPart::hips,
              .top = true,
              .trousers = true},
             {.centre = {0, 1.10F, 0}, .breadth = 0.14F, .depth = 0.10F, .bone = Joint::torso}, 1.0F);
    addRings(tubes[0].rings, rings(6),
             {.centre = {0, 1.10F, 0},
              .breadth = 0.14F,
              .depth = 0.10F,
              .bone = Joint::torso,
              .part = BodyPart::chest,
              .top = true},
             {.centre = {0, 1.45F, 0}, .breadth = 0.16F, .depth = 0.10F, .bone = Joint::torso}, 1.0F);
    addRings(tubes[1].rings, rings(6),
             {.centre = {0, 1.45F, 0}, .breadth = 0.06F, .depth = 0.06F, .bone = Joint::neck, .part = BodyPart::neck},
             {.centre = {0, 1.75F, 0}, .breadth = 0.08F, .depth = 0.09F, .bone = Joint::head}, 0.2F);
    const Eigen::Vector3f down = Eigen::Vector3f(1, -1, 0).normalized();
    const Eigen::Vector3f shoulder(0.18F, 1.40F, 0);
    addRings(tubes[2].rings, rings(6),
             {.centre = shoulder,
              .breadth = 0.05F,
              .depth = 0.05F,
              .bone = Joint::leftShoulder,
              .part = BodyPart::leftUpperArm,
              .top = true},
             {.centre = shoulder + 0.28F * down, .breadth = 0.04F, .depth = 0.04F, .bone = Joint::leftElbow}, 0.6F);
    addRings(tubes[2].rings, rings(6),
             {.centre = shoulder + 0.28F * down,
              .breadth = 0.04F,
              .depth = 0.04F,
              .bone = Joint::leftElbow,
              .part = BodyPart::leftForearm},
             {.centre = shoulder + 0.60F * down, .breadth = 0.03F, .depth = 0.02F, .bone = Joint::leftHand}, 0.7F);
    addRings(tubes[4].rings, rings(6),
             {.centre = {0.09F, 0.86F, 0},
              .breadth = 0.075F,
              .depth = 0.08F,
              .bone = Joint::leftHip,
              .part = BodyPart::leftThigh,
              .trousers = true},
             {.centre = {0.11F, 0.48F, 0}, .breadth = 0.05F, .depth = 0.05F, .bone = Joint::leftKnee}, 0.6F);
    addRings(tubes[4].rings, rings(6),
             {.centre = {0.11F, 0.48F, 0},
              .breadth = 0.05F,
              .depth = 0.05F,
              .bone = Joint::leftKnee,
              .part = BodyPart::leftShin,
              .trousers = true},
             {.centre = {0.12F, 0.02F, 0}, .breadth = 0.04F, .depth = 0.05F, .bone = Joint::leftFoot}, 0.7F);
    for (const std::size_t left : {std::size_t{2}, std::size_t{4}}) {
        tubes[left + 1] = tubes[left];
        tubes[left + 1].right = true;
    }
    return tubes;
}

struct Skin {
    RestMesh mesh;
    CageTemplate cageTemplate;
    std::vector<std::uint8_t> top, trousers;
};

// Sweeps ellipses along the tubes, `out` metres outside the body's surface.
Skin sweep(int fine, int sectors, float out) {
    Skin skin;
    const std::vector<Tube> tubes = bodyTubes(fine);
    std::vector<std::size_t> firstOfTube;
    for (std::size_t k = 0; k < tubes.size(); ++k) {
        const Tube& tube = tubes[k];
        const std::size_t first = skin.mesh.positions.size();
        firstOfTube.push_back(first);
        const Eigen::Vector3f axis = (tube.rings.back().centre - tube.rings.front().centre).normalized();
        // From the seam at the back, around; the right tube is made as the left one and then mirrored.
        const Eigen::Vector3f back(0, 0, -1);
        const Eigen::Vector3f side = axis.cross(back).normalized();
        for (std::size_t r = 0; r < tube.rings.size(); ++r) {
            const Ring& ring = tube.rings[r];
            for (int c = 0; c <= sectors; ++c) {
                // The seam's second column takes the first one's angle, to the bit.
                const float angle =
                    2.0F * std::numbers::pi_v<float> * static_cast<float>(c % sectors) / static_cast<float>(sectors);
                Eigen::Vector3f p = ring.centre + (ring.depth + out) * std::cos(angle) * back +
                                    (ring.breadth + out) * std::sin(angle) * side;
                if (tube.right) p.x() = -p.x();
                skin.mesh.positions.push_back(p);
                const float u =
                    (static_cast<float>(k) + 0.05F + 0.9F * static_cast<float>(c) / static_cast<float>(sectors)) /
                    kTubes;
                const float v = 0.02F + 0.96F * static_cast<float>(r) / static_cast<float>(tube.rings.size() - 1);
                skin.mesh.uv.emplace_back(u, v);
                const Joint bone = tube.right ? mirroredJoint(ring.bone) : ring.bone;
                const Joint next = tube.right ? mirroredJoint(ring.next) : ring.next;
                SkinningWeights weights;
                weights.joint[0] = static_cast<std::uint8_t>(index(bone));
                weights.joint[1] = static_cast<std::uint8_t>(ring.nextWeight > 0.0F ? index(next) : 0);
                weights.weight[0] = 1.0F - ring.nextWeight;
                weights.weight[1] = ring.nextWeight;
                skin.mesh.weights.push_back(weights);
                const std::size_t here = skin.mesh.positions.size() - 1;
                skin.cageTemplate.weld.push_back(
                    static_cast<std::uint16_t>(c == sectors ? here - static_cast<std::size_t>(sectors) : here));
                skin.cageTemplate.part.push_back(tube.right ? mirroredPart(ring.part) : ring.part);
                skin.top.push_back(ring.top ? 1 : 0);
                skin.trousers.push_back(ring.trousers ? 1 : 0);
            }
        }
        const auto columns = static_cast<std::size_t>(sectors) + 1;
        for (std::size_t r = 0; r + 1 < tube.rings.size(); ++r) {
            for (std::size_t c = 0; c + 1 < columns; ++c) {
                const auto a = static_cast<std::uint32_t>(first + r * columns + c);
                const auto b = a + 1;
                const auto d = static_cast<std::uint32_t>(a + columns);
                const auto e = d + 1;
                // Outwards: the columns run around the axis one way, and the other way in a mirrored tube.
                if (tube.right) {
                    skin.mesh.triangles.push_back({a, d, b});
                    skin.mesh.triangles.push_back({b, d, e});
                } else {
                    skin.mesh.triangles.push_back({a, b, d});
                    skin.mesh.triangles.push_back({b, e, d});
                }
            }
        }
    }
    const auto columns = static_cast<std::size_t>(sectors) + 1;
    for (std::size_t k = 0; k < tubes.size(); ++k) {
        const std::size_t other = k < 2 ? k : (tubes[k].right ? k - 1 : k + 1);
        for (std::size_t i = 0; i < tubes[k].rings.size() * columns; ++i) {
            const std::size_t r = i / columns;
            const std::size_t c = i % columns;
            // Trunk and head are their own mirror images: the columns run back.
            const std::size_t partner = k < 2 ? r * columns + (columns - 1 - c) : i;
            skin.cageTemplate.mirrored.push_back(static_cast<std::uint16_t>(firstOfTube[other] + partner));
        }
    }
    skin.cageTemplate.uv = skin.mesh.uv;
    skin.cageTemplate.triangles = skin.mesh.triangles;
    skin.mesh.normals.resize(skin.mesh.positions.size());
    smoothNormals(skin.mesh.positions, skin.mesh.triangles, weldByPosition(skin.mesh.positions), skin.mesh.normals);
    return skin;
}

constexpr int kCageSectors = 8;
constexpr float kCageGap = 0.005F;

}  // namespace

Body makeBody() {
    Body body;
    Skin cage = sweep(1, kCageSectors, kCageGap);
    body.cageTemplate = std::move(cage.cageTemplate);
    body.cageTemplate.hash = hashCageTemplate(body.cageTemplate);
    body.outerCage = cage.mesh.positions;
    body.cageWeights = cage.mesh.weights;
    body.mesh = sweep(3, 16, 0.0F).mesh;
    const Eigen::Vector3f down = Eigen::Vector3f(1, -1, 0).normalized();
    const Eigen::Vector3f shoulder(0.18F, 1.40F, 0);
    const auto put = [&body](Joint joint, const Eigen::Vector3f& place) { body.joints[index(joint)] = place; };
    put(Joint::head, {0, 1.63F, 0});
    put(Joint::neck, {0, 1.45F, 0});
    put(Joint::torso, {0, 0.5F * (1.45F + 0.88F), 0});
    put(Joint::leftShoulder, shoulder);
    put(Joint::leftElbow, shoulder + 0.28F * down);
    put(Joint::leftHand, shoulder + 0.54F * down);
    put(Joint::leftHip, {0.09F, 0.88F, 0});
    put(Joint::leftKnee, {0.11F, 0.48F, 0});
    put(Joint::leftFoot, {0.12F, 0.08F, 0});
    for (const Joint joint :
         {Joint::leftShoulder, Joint::leftElbow, Joint::leftHand, Joint::leftHip, Joint::leftKnee, Joint::leftFoot}) {
        Eigen::Vector3f place = body.joints[index(joint)];
        place.x() = -place.x();
        put(mirroredJoint(joint), place);
    }
    return body;
}

Garment makeGarment(const Body& body, const MadeGarment& made) {
    Garment garment;
    garment.id = made.legs ? "trousers" : "top";
    garment.name = made.legs ? "Trousers" : "Top";
    garment.kind = made.legs ? GarmentKind::trousers : GarmentKind::top;
    const Skin outer = sweep(1, kCageSectors, kCageGap + made.thickness);
    garment.innerCage = body.outerCage;
    garment.outerCage = outer.mesh.positions;
    garment.covered = made.legs ? outer.trousers : outer.top;
    // The cloth: what of a finer sweep is covered.
    const Skin cloth = sweep(2, 16, kCageGap + made.gap);
    const std::vector<std::uint8_t>& kept = made.legs ? cloth.trousers : cloth.top;
    std::vector<std::uint32_t> number(kept.size(), 0);
    RestMesh& mesh = garment.mesh;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        if (kept[i] == 0) continue;
        number[i] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(cloth.mesh.positions[i]);
        mesh.normals.push_back(cloth.mesh.normals[i]);
        mesh.uv.push_back(cloth.mesh.uv[i]);
        mesh.weights.push_back(cloth.mesh.weights[i]);
    }
    for (const Triangle& t : cloth.mesh.triangles) {
        if (kept[t.a] != 0 && kept[t.b] != 0 && kept[t.c] != 0) {
            mesh.triangles.push_back({number[t.a], number[t.b], number[t.c]});
        }
    }
    garment.simulated.assign(mesh.positions.size(), 0);
    return garment;
}

Skeleton movedSkeleton(const Body& body, const Eigen::Isometry3f& motion) {
    const Eigen::Quaternionf facing(0, 0, 1, 0);
    Skeleton skeleton;
    skeleton.userId = 1;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        skeleton.joints[i].position = motion * (facing * body.joints[i]);
        skeleton.joints[i].orientation = Eigen::Quaternionf(motion.rotation()) * facing;
        skeleton.joints[i].confidence = 1.0F;
    }
    return skeleton;
}

Skeleton restSkeleton(const Body& body, const Eigen::Vector3f& moved) {
    return movedSkeleton(body, Eigen::Isometry3f(Eigen::Translation3f(moved)));
}

}  // namespace cheval::test

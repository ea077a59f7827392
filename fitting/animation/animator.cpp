#include "fitting/animation/animator.h"

#include <algorithm>
#include <array>

#include "fitting/animation/body_cover.h"
#include "fitting/animation/bone_transforms.h"
#include "fitting/animation/skinning.h"

namespace cheval::fitting {

namespace {

// The rest pose of everything that is worn, structure of arrays. Filled when body or outfit changes.
struct RestVertices {
    std::vector<float> x, y, z, nx, ny, nz, u, v;
    std::vector<SkinningWeights> weights;

    void reserve(std::size_t count) {
        for (std::vector<float>* values : {&x, &y, &z, &nx, &ny, &nz, &u, &v})
            values->reserve(count);
        weights.reserve(count);
    }
    void clear() {
        for (std::vector<float>* values : {&x, &y, &z, &nx, &ny, &nz, &u, &v})
            values->clear();
        weights.clear();
    }
    void append(const RestMesh& mesh, const std::vector<Eigen::Vector3f>& positions,
                const std::vector<Eigen::Vector3f>& normals) {
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            x.push_back(positions[i].x());
            y.push_back(positions[i].y());
            z.push_back(positions[i].z());
            nx.push_back(normals[i].x());
            ny.push_back(normals[i].y());
            nz.push_back(normals[i].z());
            u.push_back(mesh.uv[i].x());
            v.push_back(mesh.uv[i].y());
            weights.push_back(mesh.weights[i]);
        }
    }
    [[nodiscard]] std::size_t size() const { return x.size(); }
    [[nodiscard]] SkinningSource source() const {
        return {.x = x, .y = y, .z = z, .nx = nx, .ny = ny, .nz = nz, .u = u, .v = v, .weights = weights};
    }
};

bool sizesAgree(const RestMesh& mesh, std::size_t positions, std::size_t normals) {
    const std::size_t n = mesh.positions.size();
    return positions == n && normals == n && mesh.uv.size() == n && mesh.weights.size() == n;
}

}  // namespace

struct Animator::State {
    const Body& body;
    AnimatorOptions options;
    BoneTransforms bones;
    BodyCover cover;
    RestVertices rest;
    std::array<BoneMatrix, kJointCount> matrices{};
    std::array<const Garment*, kMaximumLayers> worn{};
    std::size_t wornCount = 0;
    std::vector<std::uint32_t> indices;
    std::vector<MeshPart> parts;
    std::uint64_t topologyRevision = 0;
    std::uint64_t outfitRevision = 0;
    std::uint32_t bodyRevision = 0;
    bool filled = false;

    State(const Body& mannequin, const AnimatorOptions& animatorOptions)
        : body(mannequin),
          options(animatorOptions),
          bones({.minimumConfidence = animatorOptions.minimumConfidence}),
          cover(mannequin) {
        rest.reserve(options.maximumVertices);
        indices.reserve(options.maximumIndices);
        parts.reserve(kMaximumLayers + 1);
    }

    [[nodiscard]] bool fits(const RestMesh& mesh) const {
        return rest.size() + mesh.positions.size() <= options.maximumVertices &&
               indices.size() + 3 * mesh.triangles.size() <= options.maximumIndices;
    }

    void fill(const ShapedBody& shaped, const FittedOutfit& outfit);
    void appendPart(PartKind kind, const RestMesh& mesh, std::uint32_t material, std::uint8_t layer);
};

void Animator::State::appendPart(PartKind kind, const RestMesh& mesh, std::uint32_t material, std::uint8_t layer) {
    const auto firstIndex = static_cast<std::uint32_t>(indices.size());
    const auto firstVertex = static_cast<std::uint32_t>(rest.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (kind == PartKind::body && cover.hidden(i)) continue;
        const Triangle& t = mesh.triangles[i];
        for (const std::uint32_t corner : {t.a, t.b, t.c})
            indices.push_back(firstVertex + corner);
    }
    parts.push_back({.kind = kind,
                     .firstIndex = firstIndex,
                     .indexCount = static_cast<std::uint32_t>(indices.size()) - firstIndex,
                     .material = material,
                     .layer = layer});
}

void Animator::State::fill(const ShapedBody& shaped, const FittedOutfit& outfit) {
    // What is worn decides indices and parts; a new shape or fit of the same garments moves vertices only.
    std::array<const Garment*, kMaximumLayers> wears{};
    const std::size_t count = std::min(outfit.count, kMaximumLayers);
    for (std::size_t i = 0; i < count; ++i)
        wears[i] = outfit.layers[i].garment;
    const bool sameTopology = filled && count == wornCount && wears == worn;
    if (!sameTopology) {
        worn = wears;
        wornCount = count;
        ++topologyRevision;
        cover.update(outfit);
    }

    // Rebuilt whole; the result is the same where the topology is.
    rest.clear();
    indices.clear();
    parts.clear();
    const bool shapedFits = sizesAgree(body.mesh, shaped.positions.size(), shaped.normals.size());
    if (fits(body.mesh)) {
        appendPart(PartKind::body, body.mesh, 0, 0);
        rest.append(body.mesh, shapedFits ? shaped.positions : body.mesh.positions,
                    shapedFits ? shaped.normals : body.mesh.normals);
    }
    for (std::size_t i = 0; i < count; ++i) {
        const FittedGarment& layer = outfit.layers[i];
        const RestMesh& mesh = layer.garment->mesh;
        if (!fits(mesh) || !sizesAgree(mesh, layer.positions.size(), layer.normals.size())) continue;
        appendPart(PartKind::garment, mesh, layer.material, static_cast<std::uint8_t>(i + 1));
        rest.append(mesh, layer.positions, layer.normals);
    }
    outfitRevision = outfit.revision;
    bodyRevision = shaped.revision;
    filled = true;
}

Animator::Animator(const Body& body, const AnimatorOptions& options) : state_(std::make_unique<State>(body, options)) {}

Animator::~Animator() = default;

void Animator::reserve(PosedMesh& mesh) const {
    mesh.vertices.reserve(state_->options.maximumVertices);
    mesh.indices.reserve(state_->options.maximumIndices);
    mesh.parts.reserve(kMaximumLayers + 1);
}

void Animator::pose(const ShapedBody& body, const FittedOutfit& outfit, const Skeleton& skeleton, PosedMesh& posed) {
    State& s = *state_;
    if (!s.filled || s.outfitRevision != outfit.revision || s.bodyRevision != body.revision) s.fill(body, outfit);
    // The meshes of a triple buffer come round in turn; each is brought up to date when it does.
    if (posed.topologyRevision != s.topologyRevision) {
        posed.indices.assign(s.indices.begin(), s.indices.end());
        posed.parts.assign(s.parts.begin(), s.parts.end());
        posed.topologyRevision = s.topologyRevision;
    }
    s.bones.update(body.positions.empty() ? s.body.joints : body.joints, skeleton);
    for (std::size_t i = 0; i < kJointCount; ++i)
        s.matrices[i] = BoneMatrix(s.bones.transforms()[i]);
    posed.vertices.resize(s.rest.size());
    const SkinningJob job{.source = s.rest.source(), .bones = s.matrices, .vertices = posed.vertices};
    if (!job.run()) posed.vertices.clear();
    posed.captureTime = skeleton.captureTime;
}

void Animator::reset() {
    state_->bones.reset();
}

}  // namespace cheval::fitting

#include "fitting/layering/outfit_fitter.h"

#include <algorithm>

#include "fitting/layering/cage_binding.h"
#include "fitting/layering/smooth_normals.h"
#include "fitting/layering/triangle_deformer.h"

namespace cheval::fitting {

namespace {

// What is found once per garment, so that a new body costs evaluation only.
struct BoundGarment {
    std::vector<CageBinding> bindings;        // Empty: the garment covers nothing and cannot be worn.
    std::vector<std::uint32_t> weld;          // Of the render mesh.
    std::vector<Eigen::Vector3f> ownNormals;  // Smooth normals on the reference body.
};

}  // namespace

struct OutfitFitter::State {
    std::span<const Garment> wardrobe;
    std::span<const Triangle> triangles;
    std::span<const std::uint16_t> weld;
    std::vector<BoundGarment> bound;
    FittedOutfit outfit;
    std::vector<Eigen::Vector3f> below;  // Outer cage of what is worn so far.
    std::vector<Eigen::Vector3f> newOuter;
    std::vector<Eigen::Matrix3f> vertexTransforms;
    std::vector<CageVertexSum> sums;
    std::vector<Eigen::Vector3f> smooth;
};

OutfitFitter::OutfitFitter(const Body& body, std::span<const Garment> wardrobe) : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.wardrobe = wardrobe;
    s.triangles = body.cageTemplate.triangles;
    s.weld = body.cageTemplate.weld;
    const std::size_t cageVertices = body.cageTemplate.vertexCount();
    s.below.resize(cageVertices);
    s.newOuter.resize(cageVertices);
    s.vertexTransforms.resize(cageVertices, Eigen::Matrix3f::Identity());
    s.sums.resize(cageVertices);

    std::size_t largest = 0;
    s.bound.reserve(wardrobe.size());
    for (const Garment& garment : wardrobe) {
        BoundGarment bound;
        const bool fitsTemplate = garment.innerCage.size() == cageVertices &&
                                  garment.outerCage.size() == cageVertices && garment.covered.size() == cageVertices;
        if (fitsTemplate) {
            bound.weld = weldByPosition(garment.mesh.positions);
            bound.ownNormals.resize(garment.mesh.positions.size());
            smoothNormals(garment.mesh.positions, garment.mesh.triangles, bound.weld, bound.ownNormals);
            // Smooth normals, not the mesh's: vertices at one place must bind alike, or seams would open.
            bound.bindings = bindToCages({s.triangles, garment.innerCage, garment.outerCage}, garment.covered,
                                         garment.mesh.positions, bound.ownNormals);
        }
        largest = std::max(largest, garment.mesh.positions.size());
        s.bound.push_back(std::move(bound));
    }
    s.smooth.resize(largest);
    s.outfit.layers.resize(kMaximumLayers);
    for (FittedGarment& layer : s.outfit.layers) {
        layer.positions.reserve(largest);
        layer.normals.reserve(largest);
    }
}

OutfitFitter::~OutfitFitter() = default;

const FittedOutfit& OutfitFitter::fit(const ShapedBody& body, const Outfit& outfit) {
    State& s = *state_;
    s.outfit.count = 0;
    ++s.outfit.revision;
    if (body.outerCage.size() != s.below.size()) return s.outfit;
    std::copy(body.outerCage.begin(), body.outerCage.end(), s.below.begin());

    for (std::size_t i = 0; i < std::min(outfit.count, kMaximumLayers); ++i) {
        const std::size_t which = outfit.garments[i];
        if (which >= s.wardrobe.size() || s.bound[which].bindings.empty()) continue;
        const Garment& garment = s.wardrobe[which];
        const BoundGarment& bound = s.bound[which];
        const TriangleDeformerJob job{.triangles = s.triangles,
                                      .weld = s.weld,
                                      .covered = garment.covered,
                                      .below = s.below,
                                      .inner = garment.innerCage,
                                      .outer = garment.outerCage,
                                      .sums = s.sums,
                                      .newOuter = s.newOuter,
                                      .vertexTransforms = s.vertexTransforms};
        if (!job.run()) continue;

        FittedGarment& layer = s.outfit.layers[s.outfit.count];
        ++s.outfit.count;
        const std::size_t vertices = garment.mesh.positions.size();
        layer.garment = &garment;
        layer.material = static_cast<std::uint32_t>(which + 1);
        layer.positions.resize(vertices);
        layer.normals.resize(vertices);
        // The garment's inner cage now is the cage below it.
        evaluateBindings({s.triangles, s.below, s.newOuter}, s.vertexTransforms, bound.bindings, layer.positions);
        const std::span<Eigen::Vector3f> smooth(s.smooth.data(), vertices);
        smoothNormals(layer.positions, garment.mesh.triangles, bound.weld, smooth);
        for (std::size_t v = 0; v < vertices; ++v) {
            layer.normals[v] = turnAlong(garment.mesh.normals[v], bound.ownNormals[v], smooth[v]);
        }
        std::swap(s.below, s.newOuter);
    }
    return s.outfit;
}

const FittedOutfit& OutfitFitter::fitted() const {
    return state_->outfit;
}

}  // namespace cheval::fitting

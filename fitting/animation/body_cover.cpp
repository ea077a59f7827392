#include "fitting/animation/body_cover.h"

#include <algorithm>

#include "fitting/layering/cage_binding.h"

namespace cheval::fitting {

BodyCover::BodyCover(const Body& body) : body_(&body) {
    const CageTemplate& cage = body.cageTemplate;
    covered_.resize(cage.vertexCount(), 1);
    atEdge_.resize(cage.vertexCount(), 0);
    hiddenCage_.resize(cage.triangles.size(), 0);
    const std::vector<CageBinding> bindings =
        bindToCages({cage.triangles, body.outerCage, body.outerCage}, covered_, body.mesh.positions, body.mesh.normals);
    cageTriangleOfVertex_.reserve(bindings.size());
    for (const CageBinding& binding : bindings)
        cageTriangleOfVertex_.push_back(binding.triangle);
}

void BodyCover::update(const FittedOutfit& outfit) {
    const CageTemplate& cage = body_->cageTemplate;
    std::fill(covered_.begin(), covered_.end(), std::uint8_t{0});
    std::fill(atEdge_.begin(), atEdge_.end(), std::uint8_t{0});
    for (std::size_t layer = 0; layer < outfit.count; ++layer) {
        const std::vector<std::uint8_t>& covered = outfit.layers[layer].garment->covered;
        for (std::size_t i = 0; i < std::min(covered.size(), covered_.size()); ++i) {
            if (covered[i] != 0) covered_[cage.weld[i]] = 1;
        }
    }
    for (const Triangle& t : cage.triangles) {
        const std::array corners = {cage.weld[t.a], cage.weld[t.b], cage.weld[t.c]};
        const bool open = std::any_of(corners.begin(), corners.end(), [this](auto i) { return covered_[i] == 0; });
        if (!open) continue;
        for (const std::uint16_t corner : corners)
            atEdge_[corner] = 1;
    }
    for (std::size_t i = 0; i < cage.triangles.size(); ++i) {
        const Triangle& t = cage.triangles[i];
        const auto deep = [&](std::uint32_t corner) {
            return covered_[cage.weld[corner]] != 0 && atEdge_[cage.weld[corner]] == 0;
        };
        hiddenCage_[i] = deep(t.a) && deep(t.b) && deep(t.c) ? 1 : 0;
    }
}

bool BodyCover::hidden(std::size_t i) const {
    if (cageTriangleOfVertex_.empty()) return false;
    const Triangle& t = body_->mesh.triangles[i];
    return hiddenCage_[cageTriangleOfVertex_[t.a]] != 0 && hiddenCage_[cageTriangleOfVertex_[t.b]] != 0 &&
           hiddenCage_[cageTriangleOfVertex_[t.c]] != 0;
}

}  // namespace cheval::fitting

#include "fitting/bake/wardrobe.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "fitting/bake/pattern_layout.h"

namespace cheval::fitting::bake {
namespace {

/// How far the outer cage lies outside the cloth, metres.
constexpr double kOuterCageDistance = 0.004;

const std::array<GarmentSpecification, 6>& table() {
    static const std::array<GarmentSpecification, 6> kTable = {{
        {"tshirt",
         "T-shirt",
         GarmentKind::top,
         0.2F,
         TopCut{},
         {Weave::jersey, {0.145, 0.315, 0.400}, {0.945, 0.925, 0.870}, true}},
        {"trousers",
         "Trousers",
         GarmentKind::trousers,
         0.35F,
         TrousersCut{},
         {Weave::denim, {0.185, 0.245, 0.345}, {0.770, 0.565, 0.320}, false}},
        {"tshirt-striped",
         "T-shirt, striped",
         GarmentKind::top,
         0.2F,
         TopCut{},
         {Weave::striped, {0.930, 0.915, 0.880}, {0.120, 0.165, 0.290}, false}},
        {"shirt-long",
         "Long-sleeved shirt",
         GarmentKind::top,
         0.2F,
         TopCut{.sleeveRing = 12.75, .sleeveEase = 0.014},
         {Weave::jersey, {0.560, 0.155, 0.165}, {0.950, 0.930, 0.890}, false}},
        {"chinos",
         "Chinos",
         GarmentKind::trousers,
         0.35F,
         TrousersCut{.extraWidth = -0.002},
         {Weave::chino, {0.690, 0.600, 0.460}, {0.560, 0.470, 0.340}, false}},
        {"shorts",
         "Shorts",
         GarmentKind::trousers,
         0.3F,
         TrousersCut{.hemRing = 5.5, .hang = 0.0, .extraWidth = 0.012},
         {Weave::chino, {0.250, 0.305, 0.250}, {0.330, 0.380, 0.320}, false}},
    }};
    return kTable;
}

/// The cloth as a mesh with the pattern's UV: a vertex is split where panels meet.
RestMesh renderMesh(const Cloth& cloth, const PatternLayout& layout) {
    std::vector<Triangle> triangles;
    for (const Cloth::Face& face : cloth.faces) {
        triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
        triangles.push_back({face.vertex[0], face.vertex[2], face.vertex[3]});
    }
    const std::vector<Vec3> normals = vertexNormals(cloth.positions, triangles);
    RestMesh mesh;
    std::map<std::tuple<std::uint32_t, Panel, GridPlace>, std::uint32_t> numberOf;
    for (const Cloth::Face& face : cloth.faces) {
        std::array<std::uint32_t, 4> corner{};
        for (std::size_t c = 0; c < 4; ++c) {
            const std::uint32_t v = face.vertex[c];
            const auto [found, isNew] =
                numberOf.try_emplace({v, face.panel, face.at[c]}, static_cast<std::uint32_t>(mesh.positions.size()));
            if (isNew) {
                mesh.positions.push_back(cloth.positions[v].cast<float>());
                mesh.normals.push_back(normals[v].cast<float>());
                mesh.uv.push_back(layout.uv(face.panel, face.at[c]).cast<float>());
                mesh.weights.push_back(cloth.weights[v]);
            }
            corner[c] = found->second;
        }
        mesh.triangles.push_back({corner[0], corner[1], corner[2]});
        mesh.triangles.push_back({corner[0], corner[2], corner[3]});
    }
    return mesh;
}

void addCages(Garment& garment, const Cloth& cloth, const BodyModel& model) {
    const Body& body = model.body;
    std::vector<Triangle> triangles;
    for (const Cloth::Face& face : cloth.faces) {
        triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
        triangles.push_back({face.vertex[0], face.vertex[2], face.vertex[3]});
    }
    const std::vector<Vec3> normals = vertexNormals(cloth.positions, triangles);
    garment.innerCage = body.outerCage;
    garment.outerCage = body.outerCage;
    garment.covered.assign(body.outerCage.size(), 0);
    for (std::size_t i = 0; i < body.outerCage.size(); ++i) {
        // The coarse vertices are the fine mesh's first ones.
        const std::uint32_t skin = model.topology.meshVertexOf[i];
        if (cloth.coveredSkin[skin] == 0) continue;
        garment.covered[i] = 1;
        const std::uint32_t above = cloth.clothOnSkin[skin];
        garment.outerCage[i] = (cloth.positions[above] + kOuterCageDistance * normals[above]).cast<float>();
    }
}

}  // namespace

std::span<const GarmentSpecification> wardrobe() {
    return table();
}

const GarmentSpecification* findGarment(std::string_view id) {
    const auto found = std::find_if(table().begin(), table().end(), [&](const auto& entry) { return entry.id == id; });
    return found == table().end() ? nullptr : &*found;
}

Garment makeGarment(const GarmentSpecification& specification, const BodyModel& model) {
    const Cloth cloth = std::holds_alternative<TopCut>(specification.cut)
                            ? cutTop(model, std::get<TopCut>(specification.cut))
                            : cutTrousers(model, std::get<TrousersCut>(specification.cut));
    const PatternLayout layout = layOut(cloth);
    Garment garment;
    garment.id = specification.id;
    garment.name = specification.name;
    garment.kind = specification.kind;
    garment.rigidity = specification.rigidity;
    garment.layerOrder = specification.kind == GarmentKind::top ? 2 : 1;  // Shirts hang over waistbands.
    garment.mesh = renderMesh(cloth, layout);
    garment.simulated.assign(garment.mesh.positions.size(), 0);
    addCages(garment, cloth, model);
    garment.material.name = specification.name;
    garment.material.roughness = 0.92F;
    garment.material.doubleSided = true;
    garment.material.baseColourTexture = paint(layout, specification.fabric);
    return garment;
}

}  // namespace cheval::fitting::bake

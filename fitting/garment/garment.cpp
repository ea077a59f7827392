#include "fitting/garment/garment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "fitting/animation/weight_transfer.h"
#include "fitting/garment/asset_file.h"
#include "fitting/garment/cage_matching.h"
#include "fitting/garment/garment_sizes.h"
#include "fitting/outfit.h"

namespace cheval::fitting {

namespace {

constexpr std::string_view kInnerSuffix = "_InnerCage";
constexpr std::string_view kOuterSuffix = "_OuterCage";
constexpr std::size_t kLongestName = 80;
constexpr float kSmallestGarment = 0.01F;  // metres across

constexpr std::array<std::pair<std::string_view, GarmentKind>, 7> kKinds = {{{"top", GarmentKind::top},
                                                                             {"trousers", GarmentKind::trousers},
                                                                             {"skirt", GarmentKind::skirt},
                                                                             {"dress", GarmentKind::dress},
                                                                             {"outerwear", GarmentKind::outerwear},
                                                                             {"headwear", GarmentKind::headwear},
                                                                             {"other", GarmentKind::other}}};

struct NodeNames {
    std::string render, inner, outer;
};

// The three nodes of a garment, found by whichever of them are there; the error names the one that is not.
Expected<NodeNames> findNodes(const AssetFile& asset) {
    std::string name;
    std::string plain;
    for (const std::string& node : asset.meshNodes()) {
        const std::string_view view = node;
        if (view.ends_with(kInnerSuffix) || view.ends_with(kOuterSuffix)) {
            name = view.substr(0, view.size() - kInnerSuffix.size());
        } else if (plain.empty()) {
            plain = node;
        }
    }
    if (name.empty()) name = plain;
    NodeNames names{
        .render = name, .inner = name + std::string(kInnerSuffix), .outer = name + std::string(kOuterSuffix)};
    for (const std::string& node : {names.render, names.inner, names.outer}) {
        if (node.empty() || !asset.hasNode(node)) {
            return asset.refuse(node, "the mesh \"" + node + "\" is missing",
                                "name the objects <Name>, <Name>_InnerCage and <Name>_OuterCage",
                                "a garment follows the body by its two cages");
        }
    }
    return names;
}

std::vector<Eigen::Vector3f> inTemplateOrder(const AssetMesh& cage, const std::vector<std::size_t>& vertexAt,
                                             const CageTemplate& cageTemplate) {
    std::vector<Eigen::Vector3f> positions(vertexAt.size());
    // Seam partners take one place exactly, so that no seam opens by rounding.
    for (std::size_t j = 0; j < vertexAt.size(); ++j)
        positions[j] = cage.mesh.positions[vertexAt[cageTemplate.weld[j]]];
    return positions;
}

Expected<void> readCages(const AssetFile& asset, const NodeNames& names, const CageTemplate& cageTemplate,
                         Garment& garment) {
    const auto inner = asset.mesh(names.inner, {.uv = true});
    if (!inner) return inner.error();
    const auto outer = asset.mesh(names.outer, {.uv = true});
    if (!outer) return outer.error();
    const auto innerOrder = matchCage(asset, *inner, cageTemplate);
    if (!innerOrder) return innerOrder.error();
    const auto outerOrder = matchCage(asset, *outer, cageTemplate);
    if (!outerOrder) return outerOrder.error();
    garment.innerCage = inTemplateOrder(*inner, *innerOrder, cageTemplate);
    garment.outerCage = inTemplateOrder(*outer, *outerOrder, cageTemplate);

    const auto covered = inner->scalars.find("_COVERED");
    if (covered == inner->scalars.end()) {
        return asset.refuse(names.inner + "._COVERED", "the attribute is missing",
                            "add a float attribute _COVERED: 1 where there is cloth, else 0",
                            "where a garment covers nothing its cages do not count");
    }
    garment.covered.assign(cageTemplate.vertexCount(), 0);
    for (std::size_t j = 0; j < innerOrder->size(); ++j) {
        if (covered->second[(*innerOrder)[j]] > 0.5F) garment.covered[cageTemplate.weld[j]] = 1;
    }
    for (std::size_t j = 0; j < garment.covered.size(); ++j)
        garment.covered[j] = garment.covered[cageTemplate.weld[j]];
    const bool covers =
        std::any_of(cageTemplate.triangles.begin(), cageTemplate.triangles.end(), [&](const Triangle& t) {
            return garment.covered[t.a] != 0 && garment.covered[t.b] != 0 && garment.covered[t.c] != 0;
        });
    if (!covers) {
        return asset.refuse(names.inner + "._COVERED", "the garment covers no triangle of its cage",
                            "mark the vertices under the cloth with 1", "it would hang on nothing");
    }
    return {};
}

Expected<void> readProperties(const AssetFile& asset, Garment& garment) {
    const auto name = asset.text("name");
    if (!name || name->empty() || name->size() > kLongestName) {
        return asset.refuse("asset.extras.cheval.name", "it is missing or longer than 80 bytes",
                            "give the garment a name", "shoppers read it");
    }
    garment.name = *name;
    const std::string kind = asset.text("kind").value_or("");
    const auto known =
        std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& entry) { return entry.first == kind; });
    if (known == kKinds.end()) {
        return asset.refuse("asset.extras.cheval.kind", "\"" + kind.substr(0, 40) + "\" is no kind of garment",
                            "use top, trousers, skirt, dress, outerwear, headwear or other", "outfits go by kind");
    }
    garment.kind = known->second;
    const double layer = asset.number("layer").value_or(0.0);
    if (!(layer >= 1.0 && layer <= static_cast<double>(kMaximumLayers)) || layer != std::floor(layer)) {
        return asset.refuse("asset.extras.cheval.layer", "it is not a whole number from 1 to 8", "1 is worn innermost",
                            "garments are put on in this order");
    }
    garment.layerOrder = static_cast<std::uint8_t>(layer);
    const double rigidity = asset.number("rigidity").value_or(static_cast<double>(garment.rigidity));
    if (!(rigidity >= 0.0 && rigidity <= 1.0)) {
        return asset.refuse("asset.extras.cheval.rigidity", "it is not within 0 … 1", "0.2 suits jersey, 0.8 leather",
                            "it shares out how layers give way");
    }
    garment.rigidity = static_cast<float>(rigidity);
    return readGarmentSizes(asset, garment);
}

Expected<Garment> parse(std::span<const std::byte> bytes, const std::string& file, const CageTemplate& cageTemplate,
                        const RestMesh* bodyMesh, const GarmentLimits& limits) {
    const AssetLimits assetLimits{.glb = {.fileBytes = limits.fileBytes,
                                          .vertices = std::max<std::uint64_t>(limits.vertices, kMaximumCageVertices),
                                          .indices = 3ULL * limits.triangles},
                                  .triangles = limits.triangles,
                                  .texturePixels = limits.texturePixels};
    const auto asset = AssetFile::parse(bytes, file, assetLimits);
    if (!asset) return asset.error();
    const auto hash = asset->templateHash("cheval-garment-1");
    if (!hash) return hash.error();
    if (*hash != cageTemplate.hash) {
        return asset->refuse("asset.extras.cheval.template_hash", "the garment was made for another cage template",
                             "make it anew on this mirror's body", "its cages would correspond to nothing here");
    }
    const auto names = findNodes(*asset);
    if (!names) return names.error();

    Garment garment;
    garment.id = std::filesystem::path(file).stem().string();
    if (auto read = readProperties(*asset, garment); !read) return std::move(read).error();
    if (auto read = readCages(*asset, *names, cageTemplate, garment); !read) return std::move(read).error();
    auto mesh =
        asset->mesh(names->render, {.normals = true, .uv = true, .weights = bodyMesh == nullptr, .triangles = true});
    if (!mesh) return mesh.error();
    garment.mesh = std::move(mesh->mesh);
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& position : garment.mesh.positions)
        box.extend(position);
    if (garment.mesh.triangles.empty() || box.diagonal().norm() < kSmallestGarment) {
        return asset->refuse(names->render, "the garment has no size", "check its unit: metres",
                             "it would not be seen");
    }
    if (garment.mesh.weights.empty()) {
        garment.mesh.weights = transferWeights(*bodyMesh, garment.mesh.positions, garment.mesh.normals);
    }
    garment.simulated.assign(garment.mesh.positions.size(), 0);
    if (const auto free = mesh->scalars.find("_FREE"); free != mesh->scalars.end()) {
        for (std::size_t i = 0; i < free->second.size(); ++i)
            garment.simulated[i] = free->second[i] > 0.5F ? 1 : 0;
    }
    auto material = asset->material(names->render);
    if (!material) return material.error();
    garment.material = std::move(*material);
    return garment;
}

Expected<Garment> load(const std::string& path, const CageTemplate& cageTemplate, const RestMesh* bodyMesh,
                       const GarmentLimits& limits) {
    const auto bytes = readAsset(path, limits.fileBytes);
    if (!bytes) return bytes.error();
    return parse(*bytes, path, cageTemplate, bodyMesh, limits);
}

}  // namespace

Expected<Garment> parseGarment(std::span<const std::byte> bytes, const std::string& file,
                               const CageTemplate& cageTemplate, const GarmentLimits& limits) {
    return parse(bytes, file, cageTemplate, nullptr, limits);
}

Expected<Garment> parseGarment(std::span<const std::byte> bytes, const std::string& file, const Body& body,
                               const GarmentLimits& limits) {
    return parse(bytes, file, body.cageTemplate, &body.mesh, limits);
}

Expected<Garment> loadGarment(const std::string& path, const CageTemplate& cageTemplate, const GarmentLimits& limits) {
    return load(path, cageTemplate, nullptr, limits);
}

Expected<Garment> loadGarment(const std::string& path, const Body& body, const GarmentLimits& limits) {
    return load(path, body.cageTemplate, &body.mesh, limits);
}

}  // namespace cheval::fitting

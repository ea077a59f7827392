#include <algorithm>
#include <cmath>
#include <optional>

#include "fitting/body/body.h"
#include "fitting/garment/asset_file.h"

namespace cheval::fitting {

namespace {

constexpr float kUniqueUv = 1e-4F;
constexpr float kSeamTolerance = 1e-6F;  // metres

// Whole numbers below `limit` from a float attribute; nothing when any is not one.
template <typename Number>
std::optional<std::vector<Number>> readNumbers(const AssetMesh& cage, const char* name, std::size_t limit) {
    const auto found = cage.scalars.find(name);
    if (found == cage.scalars.end()) return std::nullopt;
    std::vector<Number> numbers;
    numbers.reserve(found->second.size());
    for (const float value : found->second) {
        if (!(value >= 0.0F && value < static_cast<float>(limit)) || value != std::floor(value)) return std::nullopt;
        numbers.push_back(static_cast<Number>(static_cast<std::uint32_t>(value)));
    }
    return numbers;
}

Error badTemplate(const AssetFile& asset, const char* attribute, const char* cause) {
    return asset.refuse(std::string("Body_OuterCage.") + attribute, cause, "make the body anew with cheval-bake",
                        "the cage template is frozen");
}

Expected<void> checkTemplate(const AssetFile& asset, const CageTemplate& cageTemplate,
                             const std::vector<Eigen::Vector3f>& cage) {
    const std::size_t count = cageTemplate.vertexCount();
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t target = cageTemplate.weld[i];
        if (target > i || cageTemplate.weld[target] != target || (cage[i] - cage[target]).norm() > kSeamTolerance) {
            return badTemplate(asset, "_WELD", "a vertex is welded to one that is elsewhere or welded itself");
        }
        if (cageTemplate.mirrored[cageTemplate.mirrored[i]] != i) {
            return badTemplate(asset, "_MIRRORED", "a vertex is not the mirror image of its mirror image");
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if ((cageTemplate.uv[i] - cageTemplate.uv[j]).norm() <= kUniqueUv) {
                return badTemplate(asset, "TEXCOORD_0", "two vertices share a UV");
            }
        }
    }
    return {};
}

Expected<void> readCage(const AssetFile& asset, Body& body) {
    const auto cage = asset.mesh("Body_OuterCage", {.uv = true, .weights = true, .triangles = true});
    if (!cage) return cage.error();
    const std::size_t count = cage->mesh.positions.size();
    if (count > kMaximumCageVertices) {
        return badTemplate(asset, "POSITION", "the cage has more than 1200 vertices");
    }
    const auto weld = readNumbers<std::uint16_t>(*cage, "_WELD", count);
    if (!weld) return badTemplate(asset, "_WELD", "it is missing or not the number of a vertex");
    const auto mirrored = readNumbers<std::uint16_t>(*cage, "_MIRRORED", count);
    if (!mirrored) return badTemplate(asset, "_MIRRORED", "it is missing or not the number of a vertex");
    const auto part = readNumbers<BodyPart>(*cage, "_PART", kBodyPartCount);
    if (!part) return badTemplate(asset, "_PART", "it is missing or not the number of a body part");

    CageTemplate& cageTemplate = body.cageTemplate;
    cageTemplate.uv = cage->mesh.uv;
    cageTemplate.triangles = cage->mesh.triangles;
    cageTemplate.weld = *weld;
    cageTemplate.mirrored = *mirrored;
    cageTemplate.part = *part;
    cageTemplate.hash = hashCageTemplate(cageTemplate);
    body.outerCage = cage->mesh.positions;
    body.cageWeights = cage->mesh.weights;
    return checkTemplate(asset, cageTemplate, body.outerCage);
}

}  // namespace

Expected<Body> parseBody(std::span<const std::byte> bytes, const std::string& file) {
    const auto asset = AssetFile::parse(bytes, file, AssetLimits{});
    if (!asset) return asset.error();
    const auto hash = asset->templateHash("cheval-body-1");
    if (!hash) return hash.error();
    Body body;
    if (auto read = readCage(*asset, body); !read) return std::move(read).error();
    if (*hash != body.cageTemplate.hash) {
        return asset->refuse("asset.extras.cheval.template_hash", "it is not the hash of the cage in this file",
                             "make the body anew with cheval-bake", "the cage template is frozen");
    }
    auto mesh = asset->mesh("Body", {.normals = true, .uv = true, .weights = true, .triangles = true});
    if (!mesh) return mesh.error();
    body.mesh = std::move(mesh->mesh);
    auto joints = asset->jointPositions();
    if (!joints) return joints.error();
    body.joints = *joints;
    auto material = asset->material("Body");
    if (!material) return material.error();
    body.material = std::move(*material);
    return body;
}

Expected<Body> loadBody(const std::string& path) {
    const auto bytes = readAsset(path, AssetLimits{}.glb.fileBytes);
    if (!bytes) return bytes.error();
    return parseBody(*bytes, path);
}

}  // namespace cheval::fitting

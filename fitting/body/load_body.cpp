#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include <Eigen/Cholesky>

#include "fitting/body/body.h"
#include "fitting/garment/asset_file.h"

namespace cheval::fitting {

namespace {

constexpr float kUniqueUv = 1e-4F;
constexpr float kSeamTolerance = 1e-6F;  // metres
constexpr float kFarthestShape = 10.0F;  // metres a metre

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

Expected<void> readCage(const AssetFile& asset, Body& body, std::vector<std::vector<Eigen::Vector3f>>& shapes) {
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
    shapes = cage->shapes;
    return checkTemplate(asset, cageTemplate, body.outerCage);
}

using Displacements = std::vector<std::vector<Eigen::Vector3f>>;

// One column a shape.
Eigen::MatrixXf toColumns(const Displacements& shapes) {
    Eigen::MatrixXf columns(static_cast<Eigen::Index>(3 * shapes.front().size()),
                            static_cast<Eigen::Index>(shapes.size()));
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        for (std::size_t i = 0; i < shapes[k].size(); ++i) {
            columns.block<3, 1>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(k)) = shapes[k][i];
        }
    }
    return columns;
}

// A body without shapes is a mannequin that can be scaled alone.
Expected<void> readShapes(const AssetFile& asset, const Displacements& mesh, const Displacements& cage,
                          BodyShapes& shapes) {
    if (mesh.empty() && cage.empty()) return {};
    const auto refuse = [&asset](const char* key, const char* cause) {
        return asset.refuse(std::string("asset.extras.cheval.") + key, cause, "make the body anew with cheval-bake",
                            "the shapes are one set: mesh, cage, joints and what bodies are like");
    };
    constexpr auto kCount = static_cast<Eigen::Index>(kShapeParameterCount);
    if (mesh.size() != kShapeParameterCount || cage.size() != kShapeParameterCount) {
        return refuse("shape_joints", "the meshes have not 19 shapes each");
    }
    const auto read = [&asset](const char* key, std::size_t count) -> std::optional<Eigen::VectorXf> {
        const auto numbers = asset.numbers(key);
        if (!numbers || numbers->size() != count) return std::nullopt;
        const Eigen::VectorXf values =
            Eigen::Map<const Eigen::VectorXd>(numbers->data(), static_cast<Eigen::Index>(count)).cast<float>();
        return values.allFinite() && values.cwiseAbs().maxCoeff() < kFarthestShape ? std::optional(values)
                                                                                   : std::nullopt;
    };
    const auto joints = read("shape_joints", 3 * kJointCount * kShapeParameterCount);
    if (!joints) return refuse("shape_joints", "it is not 19 times 15 displacements");
    const auto mean = read("shape_mean", kShapeParameterCount);
    if (!mean) return refuse("shape_mean", "it is not 19 numbers");
    const auto covariance = read("shape_covariance", kShapeParameterCount * kShapeParameterCount);
    if (!covariance) return refuse("shape_covariance", "it is not 19 times 19 numbers");
    shapes.covariance = covariance->reshaped(kCount, kCount);
    if (!shapes.covariance.isApprox(shapes.covariance.transpose(), 1e-3F) ||
        Eigen::LLT<Eigen::MatrixXf>(shapes.covariance).info() != Eigen::Success) {
        return refuse("shape_covariance", "it is not positive definite");
    }
    shapes.mesh = toColumns(mesh);
    shapes.cage = toColumns(cage);
    shapes.joints = joints->reshaped(static_cast<Eigen::Index>(3 * kJointCount), kCount);
    shapes.mean = *mean;
    return {};
}

}  // namespace

std::vector<std::uint32_t> weldPoints(std::span<const Eigen::Vector3f> points) {
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&points](std::uint32_t i) { return std::tuple(points[i].x(), points[i].y(), points[i].z()); };
    std::sort(order.begin(), order.end(),
              [&key](std::uint32_t a, std::uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
    std::vector<std::uint32_t> weld(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
        weld[order[i]] = same ? weld[order[i - 1]] : order[i];
    }
    return weld;
}

Expected<Body> parseBody(std::span<const std::byte> bytes, const std::string& file) {
    AssetLimits limits;
    limits.glb.morphTargets = kShapeParameterCount;
    const auto asset = AssetFile::parse(bytes, file, limits);
    if (!asset) return asset.error();
    const auto hash = asset->templateHash("cheval-body-1");
    if (!hash) return hash.error();
    Body body;
    Displacements cageShapes;
    if (auto read = readCage(*asset, body, cageShapes); !read) return std::move(read).error();
    if (*hash != body.cageTemplate.hash) {
        return asset->refuse("asset.extras.cheval.template_hash", "it is not the hash of the cage in this file",
                             "make the body anew with cheval-bake", "the cage template is frozen");
    }
    auto mesh = asset->mesh("Body", {.normals = true, .uv = true, .weights = true, .triangles = true});
    if (!mesh) return mesh.error();
    body.mesh = std::move(mesh->mesh);
    body.meshWeld = weldPoints(body.mesh.positions);
    if (auto read = readShapes(*asset, mesh->shapes, cageShapes, body.shapes); !read) return std::move(read).error();
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

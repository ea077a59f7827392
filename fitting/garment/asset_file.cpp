#include "fitting/garment/asset_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>

#include "fitting/garment/gltf_access.h"
#include "hal/png/png.h"

namespace cheval::fitting {

namespace {

// Nothing that is worn reaches farther from the floor's centre than this, metres.
constexpr float kFarthest = 10.0F;

bool keepEncodedImage(tinygltf::Image* /*image*/, const int /*index*/, std::string* /*error*/, std::string* /*warning*/,
                      int /*width*/, int /*height*/, const unsigned char* /*bytes*/, int /*size*/, void* /*user*/) {
    return true;  // Decoded later, and only the one picture that is used.
}

bool isSound(const std::vector<float>& numbers, float limit) {
    return std::all_of(numbers.begin(), numbers.end(),
                       [limit](float number) { return std::isfinite(number) && std::abs(number) <= limit; });
}

std::vector<Eigen::Vector3f> toPoints(const std::vector<float>& numbers) {
    std::vector<Eigen::Vector3f> points(numbers.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    }
    return points;
}

/// An object's member, or a list's entry by its number from 0; null where there is none.
const tinygltf::Value* part(const tinygltf::Value& whole, const std::string& name) {
    if (whole.IsObject()) return whole.Has(name) ? &whole.Get(name) : nullptr;
    std::size_t number = 0;
    const auto read = std::from_chars(name.data(), name.data() + name.size(), number);
    const bool entry = whole.IsArray() && read.ec == std::errc() && read.ptr == name.data() + name.size();
    return entry && number < whole.ArrayLen() ? &whole.Get(static_cast<int>(number)) : nullptr;
}

}  // namespace

struct AssetFile::State {
    std::string file;
    AssetLimits limits;
    tinygltf::Model model;
    std::vector<Eigen::Affine3d> globals;

    [[nodiscard]] const tinygltf::Node* find(std::string_view name) const {
        const auto found = std::find_if(model.nodes.begin(), model.nodes.end(),
                                        [name](const tinygltf::Node& node) { return node.name == name; });
        return found == model.nodes.end() ? nullptr : &*found;
    }
    /// The value at a path of asset.extras.cheval, such as "sizes/ease"; null where there is none.
    [[nodiscard]] const tinygltf::Value* extra(const std::string& path) const {
        const tinygltf::Value& extras = model.asset.extras;
        if (!extras.IsObject() || !extras.Has("cheval") || !extras.Get("cheval").IsObject()) return nullptr;
        const tinygltf::Value* value = &extras.Get("cheval");
        for (std::size_t begin = 0; value != nullptr && begin <= path.size();) {
            const std::size_t end = std::min(path.find('/', begin), path.size());
            value = part(*value, path.substr(begin, end - begin));
            begin = end + 1;
        }
        return value;
    }
};

AssetFile::AssetFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
AssetFile::AssetFile(AssetFile&&) noexcept = default;
AssetFile& AssetFile::operator=(AssetFile&&) noexcept = default;
AssetFile::~AssetFile() = default;

Error AssetFile::refuse(std::string key, std::string cause, std::string mend, std::string why) const {
    return {.code = ErrorCode::invalidInput,
            .cause = std::move(cause),
            .mend = std::move(mend),
            .why = std::move(why),
            .file = state_->file,
            .key = std::move(key)};
}

Expected<AssetFile> AssetFile::parse(std::span<const std::byte> bytes, const std::string& file,
                                     const AssetLimits& limits) {
    if (auto checked = checkGlb(bytes, limits.glb, file); !checked) return std::move(checked).error();
    AssetFile asset(std::make_unique<State>());
    State& state = *asset.state_;
    state.file = file;
    state.limits = limits;
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keepEncodedImage, nullptr);
    std::string problem;
    std::string warning;
    bool loaded = false;
    try {
        loaded = loader.LoadBinaryFromMemory(&state.model, &problem, &warning,
                                             reinterpret_cast<const unsigned char*>(bytes.data()),
                                             static_cast<unsigned int>(bytes.size()));
    } catch (const std::exception& exception) {
        problem = exception.what();
    }
    if (!loaded) {
        return asset.refuse("", "the glTF cannot be read: " + problem.substr(0, problem.find('\n')), "export it again",
                            "it does not keep to glTF 2.0");
    }
    auto globals = globalTransforms(state.model);
    if (!globals) {
        return asset.refuse("nodes", "the nodes' transforms cannot be worked out", "export it again",
                            "a node has two parents, is its own ancestor or has an unsound transform");
    }
    state.globals = std::move(*globals);
    return asset;
}

std::vector<std::string> AssetFile::meshNodes() const {
    std::vector<std::string> names;
    for (const tinygltf::Node& node : state_->model.nodes) {
        if (node.mesh >= 0) names.push_back(node.name);
    }
    return names;
}

bool AssetFile::hasNode(std::string_view node) const {
    return state_->find(node) != nullptr;
}

bool AssetFile::has(const std::string& path) const {
    return state_->extra(path) != nullptr;
}

std::vector<std::string> AssetFile::keys(const std::string& path) const {
    const tinygltf::Value* const value = state_->extra(path);
    return value != nullptr && value->IsObject() ? value->Keys() : std::vector<std::string>();
}

std::size_t AssetFile::length(const std::string& path) const {
    const tinygltf::Value* const value = state_->extra(path);
    return value != nullptr && value->IsArray() ? value->ArrayLen() : 0;
}

std::optional<std::string> AssetFile::text(const std::string& key) const {
    const tinygltf::Value* const value = state_->extra(key);
    return value != nullptr && value->IsString() ? std::optional(value->Get<std::string>()) : std::nullopt;
}

std::optional<double> AssetFile::number(const std::string& key) const {
    const tinygltf::Value* const value = state_->extra(key);
    return value != nullptr && value->IsNumber() ? std::optional(value->GetNumberAsDouble()) : std::nullopt;
}

std::optional<std::vector<double>> AssetFile::numbers(const std::string& key) const {
    const tinygltf::Value* const value = state_->extra(key);
    if (value == nullptr || !value->IsArray()) return std::nullopt;
    std::vector<double> numbers(value->ArrayLen());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const tinygltf::Value& entry = value->Get(static_cast<int>(i));
        if (!entry.IsNumber()) return std::nullopt;
        numbers[i] = entry.GetNumberAsDouble();
    }
    return numbers;
}

Expected<std::uint64_t> AssetFile::templateHash(const std::string& format) const {
    const auto found = text("format");
    if (found != format) {
        return refuse("asset.extras.cheval.format",
                      found ? "the format is \"" + found->substr(0, 40) + "\"" : "it does not say its format",
                      "set it to \"" + format + "\"", "see fitting/garment/FORMAT.md");
    }
    const auto hash = text("template_hash");
    std::uint64_t value = 0;
    const bool read = hash && hash->size() == 16 &&
                      std::from_chars(hash->data(), hash->data() + 16, value, 16).ptr == hash->data() + 16;
    if (!read) {
        return refuse("asset.extras.cheval.template_hash", "it is not 16 hexadecimal digits",
                      "copy it from the body that the garment was made on", "it says which cage template was used");
    }
    return value;
}

Expected<AssetMesh> AssetFile::mesh(const std::string& nodeName, const MeshNeeds& needs) const {
    const tinygltf::Model& model = state_->model;
    const tinygltf::Node* const node = state_->find(nodeName);
    if (node == nullptr || node->mesh < 0 || static_cast<std::size_t>(node->mesh) >= model.meshes.size()) {
        return refuse(nodeName, "there is no mesh of that name", "add it, or correct the name",
                      "the mirror finds meshes by their nodes' names");
    }
    const Eigen::Affine3d& place = state_->globals[static_cast<std::size_t>(node - model.nodes.data())];
    if (!place.matrix().isApprox(Eigen::Matrix4d::Identity(), 1e-5)) {
        return refuse(nodeName, "the object is moved, turned or scaled", "apply its transforms (Blender: Ctrl+A)",
                      "meshes and cages stand where the reference body does");
    }
    const tinygltf::Primitive& primitive = model.meshes[static_cast<std::size_t>(node->mesh)].primitives.front();
    const auto attribute = [&](const char* name) {
        const auto found = primitive.attributes.find(name);
        return found == primitive.attributes.end() ? -1 : found->second;
    };
    const auto missing = [&](const char* name, const char* kind) {
        return refuse(nodeName + "." + name, "it is missing or not " + std::string(kind),
                      "switch it on in the exporter", "see fitting/garment/FORMAT.md");
    };

    AssetMesh result;
    result.node = nodeName;
    RestMesh& mesh = result.mesh;
    const int positionAccessor = attribute("POSITION");
    const std::uint64_t limit = state_->limits.glb.vertices;
    if (positionAccessor >= 0 && model.accessors[static_cast<std::size_t>(positionAccessor)].count > limit) {
        return refuse(
            nodeName,
            "it has " + std::to_string(model.accessors[static_cast<std::size_t>(positionAccessor)].count) + " vertices",
            "use a coarser mesh", "at most " + std::to_string(limit) + " are drawn");
    }
    const auto positions = readFloats(model, positionAccessor, 3);
    if (!positions) return missing("POSITION", "three floats");
    const std::size_t count = positions->size() / 3;
    const auto unsound = [&](const char* name) {
        return refuse(nodeName + "." + name, "a number is not finite or beyond all measure", "repair the mesh",
                      "a single such number would spoil every picture");
    };
    const auto otherLength = [&](const std::string& name) {
        return refuse(nodeName + "." + name, "it has another number of elements than POSITION", "export it again",
                      "glTF 2.0");
    };
    if (!isSound(*positions, kFarthest)) return unsound("POSITION");
    mesh.positions = toPoints(*positions);

    if (const int accessor = attribute("NORMAL"); accessor >= 0 || needs.normals) {
        const auto normals = readFloats(model, accessor, 3);
        if (!normals) return missing("NORMAL", "three floats");
        if (normals->size() != 3 * count) return otherLength("NORMAL");
        if (!isSound(*normals, 2.0F)) return unsound("NORMAL");
        mesh.normals = toPoints(*normals);
        for (Eigen::Vector3f& normal : mesh.normals) {
            if (normal.norm() < 0.5F) return unsound("NORMAL");
            normal.normalize();
        }
    }
    if (const int accessor = attribute("TEXCOORD_0"); accessor >= 0 || needs.uv) {
        const auto uv = readFloats(model, accessor, 2);
        if (!uv) return missing("TEXCOORD_0", "two floats");
        if (uv->size() != 2 * count) return otherLength("TEXCOORD_0");
        if (!isSound(*uv, 1000.0F)) return unsound("TEXCOORD_0");
        mesh.uv.resize(count);
        for (std::size_t i = 0; i < count; ++i)
            mesh.uv[i] = {(*uv)[2 * i], (*uv)[2 * i + 1]};
    }
    for (std::size_t i = 0; i < primitive.targets.size(); ++i) {
        const std::string name = "targets[" + std::to_string(i) + "].POSITION";
        const auto found = primitive.targets[i].find("POSITION");
        const auto moved = found == primitive.targets[i].end() ? std::nullopt : readFloats(model, found->second, 3);
        if (!moved) return missing(name.c_str(), "three floats");
        if (moved->size() != 3 * count) return otherLength(name);
        if (!isSound(*moved, kFarthest)) return unsound(name.c_str());
        result.shapes.push_back(toPoints(*moved));
    }
    for (const auto& [name, accessor] : primitive.attributes) {
        if (name.empty() || name[0] != '_') continue;
        const auto values = readFloats(model, accessor, 1);
        if (!values) continue;  // Not ours: our own are float scalars.
        if (values->size() != count) return otherLength(name);
        if (!isSound(*values, 1e6F)) return unsound(name.c_str());
        result.scalars[name] = *values;
    }

    if (attribute("JOINTS_0") >= 0 || attribute("WEIGHTS_0") >= 0 || needs.weights) {
        const auto joints = readWholeNumbers(model, attribute("JOINTS_0"), 4);
        if (!joints) return missing("JOINTS_0", "four bytes or shorts");
        const auto weights = readFloats(model, attribute("WEIGHTS_0"), 4);
        if (!weights) return missing("WEIGHTS_0", "four floats");
        if (joints->size() != 4 * count) return otherLength("JOINTS_0");
        if (weights->size() != 4 * count) return otherLength("WEIGHTS_0");
        if (!isSound(*weights, 2.0F)) return unsound("WEIGHTS_0");
        const std::size_t skinIndex = node->skin >= 0 ? static_cast<std::size_t>(node->skin) : 0;
        if (skinIndex >= model.skins.size()) {
            return refuse(nodeName, "it has weights but no skin", "export the armature too",
                          "the skin says which joints the numbers mean");
        }
        std::vector<std::uint8_t> jointOf;
        for (const int jointNode : model.skins[skinIndex].joints) {
            const std::string& name = model.nodes[static_cast<std::size_t>(jointNode)].name;
            const auto found = std::find(kJointNames.begin(), kJointNames.end(), name);
            if (found == kJointNames.end()) {
                return refuse("skins.joints", "there is no joint \"" + name.substr(0, 40) + "\"",
                              "use the mirror's 15 joints (head, neck, torso, left_shoulder …)",
                              "they are what the sensor sees");
            }
            jointOf.push_back(static_cast<std::uint8_t>(found - kJointNames.begin()));
        }
        mesh.weights.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            SkinningWeights& vertex = mesh.weights[i];
            float sum = 0.0F;
            for (std::size_t k = 0; k < 4; ++k) {
                const std::uint32_t joint = (*joints)[4 * i + k];
                const float weight = (*weights)[4 * i + k];
                if (weight < 0.0F || (weight > 0.0F && joint >= jointOf.size())) {
                    return refuse(nodeName + ".JOINTS_0",
                                  "vertex " + std::to_string(i) +
                                      " hangs on a joint that is not there, or with a "
                                      "negative weight",
                                  "normalise the weights and export again", "joints are those of the skin");
                }
                vertex.joint[k] = weight > 0.0F ? jointOf[joint] : std::uint8_t{0};
                vertex.weight[k] = weight;
                sum += weight;
            }
            if (std::abs(sum - 1.0F) > 0.02F) {
                return refuse(nodeName + ".WEIGHTS_0",
                              "the weights of vertex " + std::to_string(i) + " sum to " + std::to_string(sum),
                              "normalise all weights", "a vertex belongs to its bones wholly");
            }
            for (float& weight : vertex.weight)
                weight /= sum;
        }
    }

    if (primitive.indices >= 0 || needs.triangles) {
        const auto indices = readWholeNumbers(model, primitive.indices, 1);
        if (!indices) return missing("indices", "unsigned whole numbers");
        if (indices->size() % 3 != 0 || indices->size() / 3 > state_->limits.triangles) {
            return refuse(nodeName, "it has " + std::to_string(indices->size() / 3) + " triangles",
                          "use a coarser mesh", "at most " + std::to_string(state_->limits.triangles) + " are drawn");
        }
        for (const std::uint32_t index : *indices) {
            if (index >= count) {
                return refuse(nodeName + ".indices",
                              "a triangle uses vertex " + std::to_string(index) + " of " + std::to_string(count),
                              "export it again", "the file is damaged");
            }
        }
        mesh.triangles.resize(indices->size() / 3);
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            mesh.triangles[i] = {(*indices)[3 * i], (*indices)[3 * i + 1], (*indices)[3 * i + 2]};
        }
    }
    return result;
}

Expected<Material> AssetFile::material(const std::string& nodeName) const {
    const tinygltf::Model& model = state_->model;
    Material result;
    const tinygltf::Node* const node = state_->find(nodeName);
    if (node == nullptr || node->mesh < 0 || static_cast<std::size_t>(node->mesh) >= model.meshes.size()) return result;
    const int index = model.meshes[static_cast<std::size_t>(node->mesh)].primitives.front().material;
    if (index < 0) return result;
    const auto damaged = [&] {
        return refuse("materials", "it refers to something that is not there", "export it again",
                      "the file is damaged");
    };
    if (static_cast<std::size_t>(index) >= model.materials.size()) return damaged();
    const tinygltf::Material& material = model.materials[static_cast<std::size_t>(index)];
    result.name = material.name;
    result.doubleSided = material.doubleSided;
    result.roughness = static_cast<float>(std::clamp(material.pbrMetallicRoughness.roughnessFactor, 0.0, 1.0));
    const std::vector<double>& colour = material.pbrMetallicRoughness.baseColorFactor;
    for (std::size_t i = 0; i < std::min<std::size_t>(colour.size(), 4); ++i) {
        if (!std::isfinite(colour[i])) return damaged();
        result.baseColour[static_cast<Eigen::Index>(i)] = static_cast<float>(std::clamp(colour[i], 0.0, 1.0));
    }
    const int texture = material.pbrMetallicRoughness.baseColorTexture.index;
    if (texture < 0) return result;
    if (static_cast<std::size_t>(texture) >= model.textures.size()) return damaged();
    const int image = model.textures[static_cast<std::size_t>(texture)].source;
    if (image < 0 || static_cast<std::size_t>(image) >= model.images.size()) return damaged();
    const int viewIndex = model.images[static_cast<std::size_t>(image)].bufferView;
    if (viewIndex < 0 || static_cast<std::size_t>(viewIndex) >= model.bufferViews.size()) return damaged();
    const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(viewIndex)];
    const std::span<const unsigned char> encoded(
        model.buffers[static_cast<std::size_t>(view.buffer)].data.data() + view.byteOffset, view.byteLength);
    const hal::PngLimits limits{.maxPixels = state_->limits.texturePixels,
                                .maxFileBytes = static_cast<std::size_t>(state_->limits.glb.fileBytes)};
    auto decoded = hal::decodePng(std::as_bytes(encoded), result.baseColourTexture, limits);
    if (!decoded) {
        Error error = std::move(decoded).error();
        error.file = state_->file;
        error.key = "images[" + std::to_string(image) + "]";
        return std::move(error).within("the base colour texture");
    }
    return result;
}

Expected<std::array<Eigen::Vector3f, kJointCount>> AssetFile::jointPositions() const {
    std::array<Eigen::Vector3f, kJointCount> positions{};
    for (std::size_t i = 0; i < kJointCount; ++i) {
        const tinygltf::Node* const node = state_->find(kJointNames[i]);
        if (node == nullptr) {
            return refuse(std::string(kJointNames[i]), "there is no joint node of that name", "add it to the armature",
                          "the body has 15 joints");
        }
        const auto at = static_cast<std::size_t>(node - state_->model.nodes.data());
        positions[i] = state_->globals[at].translation().cast<float>();
        if (!positions[i].allFinite() || positions[i].norm() > kFarthest) {
            return refuse(std::string(kJointNames[i]), "the joint is beyond all measure", "put it within the body",
                          "the mirror measures in metres");
        }
    }
    return positions;
}

Expected<std::vector<std::byte>> readAsset(const std::string& path, std::uint64_t limitBytes) {
    std::vector<std::byte> bytes;
    auto read = hal::readBytes(path, static_cast<std::size_t>(limitBytes), bytes);
    if (!read) return std::move(read).error();
    return bytes;
}

}  // namespace cheval::fitting

#include "fitting/bake/glb_writer.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "hal/png/png.h"

namespace cheval::fitting::bake {
namespace {

std::string_view kindName(GarmentKind kind) {
    switch (kind) {
        case GarmentKind::top:
            return "top";
        case GarmentKind::trousers:
            return "trousers";
        case GarmentKind::skirt:
            return "skirt";
        case GarmentKind::dress:
            return "dress";
        case GarmentKind::outerwear:
            return "outerwear";
        case GarmentKind::headwear:
            return "headwear";
        case GarmentKind::other:
            break;
    }
    return "other";
}

/// One glTF document with one buffer, filled part by part.
class Document {
  public:
    Document() {
        model_.asset.version = "2.0";
        model_.asset.generator = "cheval-bake";
        model_.buffers.emplace_back();
        model_.scenes.emplace_back();
        model_.defaultScene = 0;
    }

    /// The 15 joints as nodes under the scene, and a skin over them in the order of Joint.
    void addSkin(const std::array<Eigen::Vector3f, kJointCount>& joints) {
        const int first = static_cast<int>(model_.nodes.size());
        for (std::size_t j = 0; j < kJointCount; ++j) {
            tinygltf::Node node;
            node.name = std::string(kJointNames[j]);
            const std::size_t parent = index(kJointParent[j]);
            const bool isRoot = parent == j;
            const Eigen::Vector3f place = isRoot ? joints[j] : Eigen::Vector3f(joints[j] - joints[parent]);
            node.translation = {place.x(), place.y(), place.z()};
            model_.nodes.push_back(node);
            if (isRoot) model_.scenes[0].nodes.push_back(first + static_cast<int>(j));
        }
        for (std::size_t j = 0; j < kJointCount; ++j) {
            const std::size_t parent = index(kJointParent[j]);
            if (parent != j) {
                model_.nodes[static_cast<std::size_t>(first) + parent].children.push_back(first + static_cast<int>(j));
            }
        }
        std::vector<float> inverseBind;
        for (const Eigen::Vector3f& joint : joints) {
            const std::array<float, 16> matrix = {1, 0, 0, 0, 0,          1,          0,          0,
                                                  0, 0, 1, 0, -joint.x(), -joint.y(), -joint.z(), 1};
            inverseBind.insert(inverseBind.end(), matrix.begin(), matrix.end());
        }
        tinygltf::Skin skin;
        skin.name = "Skeleton";
        skin.inverseBindMatrices = addFloats(inverseBind, TINYGLTF_TYPE_MAT4, 0, false);
        skin.skeleton = first + static_cast<int>(index(Joint::torso));
        for (std::size_t j = 0; j < kJointCount; ++j) {
            skin.joints.push_back(first + static_cast<int>(j));
        }
        model_.skins.push_back(skin);
    }

    Expected<void> addMaterial(const Material& material) {
        tinygltf::Material out;
        out.name = material.name;
        auto& pbr = out.pbrMetallicRoughness;
        pbr.baseColorFactor = {material.baseColour.x(), material.baseColour.y(), material.baseColour.z(),
                               material.baseColour.w()};
        pbr.metallicFactor = 0.0;
        pbr.roughnessFactor = material.roughness;
        out.doubleSided = material.doubleSided;
        if (!material.baseColourTexture.empty()) {
            // Cloth hides what is behind it: the texture goes without its alpha.
            hal::Image<hal::Rgb8> opaque(material.baseColourTexture.width, material.baseColourTexture.height);
            std::transform(material.baseColourTexture.pixels.begin(), material.baseColourTexture.pixels.end(),
                           opaque.pixels.begin(), [](const hal::Rgba8& pixel) {
                               return hal::Rgb8{pixel.r, pixel.g, pixel.b};
                           });
            std::vector<std::byte> png;
            if (auto encoded = hal::encodePng(std::as_const(opaque).view(), png, {.compression = 5}); !encoded) {
                return encoded.error();
            }
            tinygltf::Image image;
            image.name = material.name;
            image.mimeType = "image/png";
            image.bufferView = addView(png.data(), png.size(), 0);
            model_.images.push_back(image);
            tinygltf::Texture texture;
            texture.source = static_cast<int>(model_.images.size()) - 1;
            model_.textures.push_back(texture);
            pbr.baseColorTexture.index = static_cast<int>(model_.textures.size()) - 1;
        }
        model_.materials.push_back(out);
        return {};
    }

    using Scalars = std::vector<std::pair<std::string, std::vector<float>>>;

    /// A skinned mesh as a node of its own. `normals` may be empty; `material` −1: none.
    void addMesh(const std::string& name, std::span<const Eigen::Vector3f> positions,
                 std::span<const Eigen::Vector3f> normals, std::span<const Eigen::Vector2f> uv,
                 std::span<const SkinningWeights> weights, std::span<const Triangle> triangles, const Scalars& scalars,
                 int material, const Eigen::MatrixXf& shapes = {}) {
        tinygltf::Primitive primitive;
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        primitive.material = material;
        primitive.attributes["POSITION"] = addVectors(positions, true);
        if (!normals.empty()) primitive.attributes["NORMAL"] = addVectors(normals, false);
        std::vector<float> flatUv;
        for (const Eigen::Vector2f& point : uv) {
            flatUv.insert(flatUv.end(), {point.x(), point.y()});
        }
        primitive.attributes["TEXCOORD_0"] = addFloats(flatUv, TINYGLTF_TYPE_VEC2, TINYGLTF_TARGET_ARRAY_BUFFER, false);
        std::vector<std::uint8_t> joints;
        std::vector<float> shares;
        for (const SkinningWeights& weight : weights) {
            joints.insert(joints.end(), std::begin(weight.joint), std::end(weight.joint));
            shares.insert(shares.end(), std::begin(weight.weight), std::end(weight.weight));
        }
        primitive.attributes["JOINTS_0"] =
            addAccessor(addView(joints.data(), joints.size(), TINYGLTF_TARGET_ARRAY_BUFFER),
                        TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_TYPE_VEC4, weights.size());
        primitive.attributes["WEIGHTS_0"] = addFloats(shares, TINYGLTF_TYPE_VEC4, TINYGLTF_TARGET_ARRAY_BUFFER, false);
        for (const auto& [scalarName, values] : scalars) {
            primitive.attributes[scalarName] =
                addFloats(values, TINYGLTF_TYPE_SCALAR, TINYGLTF_TARGET_ARRAY_BUFFER, false);
        }
        std::vector<std::uint32_t> indices;
        for (const Triangle& triangle : triangles) {
            indices.insert(indices.end(), {triangle.a, triangle.b, triangle.c});
        }
        primitive.indices = addAccessor(
            addView(indices.data(), indices.size() * sizeof(std::uint32_t), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER),
            TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, indices.size());
        // Columns of displacements become morph targets.
        for (Eigen::Index k = 0; k < shapes.cols(); ++k) {
            std::vector<Eigen::Vector3f> moved(positions.size());
            for (std::size_t i = 0; i < moved.size(); ++i)
                moved[i] = shapes.block<3, 1>(static_cast<Eigen::Index>(3 * i), k);
            primitive.targets.push_back({{"POSITION", addVectors(moved, true)}});
        }
        tinygltf::Mesh mesh;
        mesh.name = name;
        if (shapes.cols() > 0) {
            tinygltf::Value::Array names;
            for (const std::string_view shape : kShapeParameterNames)
                names.emplace_back(std::string(shape));
            mesh.extras = tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(names)}});
        }
        mesh.primitives.push_back(primitive);
        model_.meshes.push_back(mesh);
        tinygltf::Node node;
        node.name = name;
        node.mesh = static_cast<int>(model_.meshes.size()) - 1;
        node.skin = 0;
        model_.scenes[0].nodes.push_back(static_cast<int>(model_.nodes.size()));
        model_.nodes.push_back(node);
    }

    Expected<std::vector<std::uint8_t>> encode(const tinygltf::Value::Object& chevalExtras) {
        model_.asset.extras = tinygltf::Value(tinygltf::Value::Object{{"cheval", tinygltf::Value(chevalExtras)}});
        tinygltf::TinyGLTF writer;
        std::ostringstream stream;
        if (!writer.WriteGltfSceneToStream(&model_, stream, false, true)) {
            return Error{.code = ErrorCode::internal, .cause = "the glTF document could not be written"};
        }
        const std::string text = std::move(stream).str();
        return std::vector<std::uint8_t>(text.begin(), text.end());
    }

  private:
    int addView(const void* data, std::size_t bytes, int target) {
        auto& buffer = model_.buffers[0].data;
        buffer.resize((buffer.size() + 3) / 4 * 4, 0);
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = buffer.size();
        view.byteLength = bytes;
        view.target = target;
        buffer.resize(buffer.size() + bytes);
        std::memcpy(buffer.data() + view.byteOffset, data, bytes);
        buffer.resize((buffer.size() + 3) / 4 * 4, 0);
        model_.bufferViews.push_back(view);
        return static_cast<int>(model_.bufferViews.size()) - 1;
    }

    int addAccessor(int view, int componentType, int type, std::size_t count) {
        tinygltf::Accessor accessor;
        accessor.bufferView = view;
        accessor.componentType = componentType;
        accessor.type = type;
        accessor.count = count;
        model_.accessors.push_back(accessor);
        return static_cast<int>(model_.accessors.size()) - 1;
    }

    int addFloats(const std::vector<float>& values, int type, int target, bool bounds) {
        const auto width = static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
        const int number = addAccessor(addView(values.data(), values.size() * sizeof(float), target),
                                       TINYGLTF_COMPONENT_TYPE_FLOAT, type, values.size() / width);
        if (bounds) {
            tinygltf::Accessor& accessor = model_.accessors.back();
            for (std::size_t i = 0; i < width; ++i) {
                double low = values[i];
                double high = values[i];
                for (std::size_t k = i; k < values.size(); k += width) {
                    low = std::min(low, static_cast<double>(values[k]));
                    high = std::max(high, static_cast<double>(values[k]));
                }
                accessor.minValues.push_back(low);
                accessor.maxValues.push_back(high);
            }
        }
        return number;
    }

    int addVectors(std::span<const Eigen::Vector3f> values, bool bounds) {
        std::vector<float> flat;
        flat.reserve(values.size() * 3);
        for (const Eigen::Vector3f& value : values) {
            flat.insert(flat.end(), {value.x(), value.y(), value.z()});
        }
        return addFloats(flat, TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER, bounds);
    }

    tinygltf::Model model_;
};

template <typename Values>
std::vector<float> asFloats(const Values& values) {
    std::vector<float> result;
    result.reserve(values.size());
    for (const auto value : values) {
        result.push_back(static_cast<float>(value));
    }
    return result;
}

/// Column by column.
tinygltf::Value asNumbers(const Eigen::MatrixXf& matrix) {
    tinygltf::Value::Array numbers;
    for (Eigen::Index k = 0; k < matrix.size(); ++k)
        numbers.emplace_back(static_cast<double>(matrix.reshaped()[k]));
    return tinygltf::Value(numbers);
}

}  // namespace

std::string hashText(std::uint64_t hash) {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
    return text.data();
}

Expected<std::string> readTemplateHash(const std::string& path) {
    const auto refuse = [&](std::string cause) {
        return Error{.code = ErrorCode::invalidInput,
                     .cause = std::move(cause),
                     .mend = "Give a .glb that cheval-bake made.",
                     .file = path};
    };
    std::ifstream file(path, std::ios::binary);
    if (!file) return refuse("the file cannot be opened");
    // Header (magic, version, length), then the JSON chunk's length and type: all 32 bits, little-endian.
    std::array<std::uint8_t, 20> head{};
    if (!file.read(reinterpret_cast<char*>(head.data()), head.size()) || std::memcmp(head.data(), "glTF", 4) != 0) {
        return refuse("the file is no binary glTF");
    }
    const std::uint32_t length = static_cast<std::uint32_t>(head[12]) | static_cast<std::uint32_t>(head[13]) << 8U |
                                 static_cast<std::uint32_t>(head[14]) << 16U |
                                 static_cast<std::uint32_t>(head[15]) << 24U;
    constexpr std::uint32_t kLongestJson = 16U << 20U;
    if (length > kLongestJson) return refuse("its description claims more than 16 MiB");
    std::string text(length, '\0');
    if (!file.read(text.data(), length)) return refuse("the file is cut short");
    const auto json = nlohmann::json::parse(text, nullptr, false);
    const nlohmann::json::json_pointer place("/asset/extras/cheval/template_hash");
    if (json.is_discarded() || !json.contains(place) || !json[place].is_string()) {
        return refuse("the file names no cage template");
    }
    return json[place].get<std::string>();
}

Expected<std::vector<std::uint8_t>> encodeBody(const Body& body) {
    Document document;
    document.addSkin(body.joints);
    if (auto added = document.addMaterial(body.material); !added) return added.error();
    const RestMesh& mesh = body.mesh;
    document.addMesh("Body", mesh.positions, mesh.normals, mesh.uv, mesh.weights, mesh.triangles, {}, 0,
                     body.shapes.mesh);
    const CageTemplate& cage = body.cageTemplate;
    document.addMesh(
        "Body_OuterCage", body.outerCage, {}, cage.uv, body.cageWeights, cage.triangles,
        {{"_WELD", asFloats(cage.weld)}, {"_MIRRORED", asFloats(cage.mirrored)}, {"_PART", asFloats(cage.part)}}, -1,
        body.shapes.cage);
    tinygltf::Value::Object extras = {{"format", tinygltf::Value(std::string("cheval-body-1"))},
                                      {"template_hash", tinygltf::Value(hashText(cage.hash))}};
    if (body.shapes.mesh.cols() > 0) {
        extras["shape_joints"] = asNumbers(body.shapes.joints);
        extras["shape_mean"] = asNumbers(body.shapes.mean);
        extras["shape_covariance"] = asNumbers(body.shapes.covariance);
    }
    return document.encode(extras);
}

Expected<std::vector<std::uint8_t>> encodeGarment(const Garment& garment, const Body& body) {
    Document document;
    document.addSkin(body.joints);
    if (auto added = document.addMaterial(garment.material); !added) return added.error();
    const RestMesh& mesh = garment.mesh;
    Document::Scalars meshScalars;
    if (std::any_of(garment.simulated.begin(), garment.simulated.end(), [](std::uint8_t v) { return v != 0; })) {
        meshScalars.emplace_back("_FREE", asFloats(garment.simulated));
    }
    document.addMesh(garment.name, mesh.positions, mesh.normals, mesh.uv, mesh.weights, mesh.triangles, meshScalars, 0);
    const CageTemplate& cage = body.cageTemplate;
    document.addMesh(garment.name + "_InnerCage", garment.innerCage, {}, cage.uv, body.cageWeights, cage.triangles,
                     {{"_COVERED", asFloats(garment.covered)}}, -1);
    document.addMesh(garment.name + "_OuterCage", garment.outerCage, {}, cage.uv, body.cageWeights, cage.triangles, {},
                     -1);
    return document.encode({{"format", tinygltf::Value(std::string("cheval-garment-1"))},
                            {"template_hash", tinygltf::Value(hashText(cage.hash))},
                            {"name", tinygltf::Value(garment.name)},
                            {"kind", tinygltf::Value(std::string(kindName(garment.kind)))},
                            {"layer", tinygltf::Value(static_cast<int>(garment.layerOrder))},
                            {"rigidity", tinygltf::Value(static_cast<double>(garment.rigidity))}});
}

Expected<void> writeFile(const std::string& path, const std::vector<std::uint8_t>& bytes) {
    const std::filesystem::path target(path);
    std::error_code failure;
    if (target.has_parent_path()) std::filesystem::create_directories(target.parent_path(), failure);
    const std::filesystem::path partial = target.string() + ".part";
    {
        std::ofstream file(partial, std::ios::binary | std::ios::trunc);
        file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!file.flush()) {
            return Error{.code = ErrorCode::resource,
                         .cause = "the file cannot be written",
                         .mend = "Check that the folder exists, may be written to and has room.",
                         .file = path};
        }
    }
    std::filesystem::rename(partial, target, failure);
    if (failure) {
        return Error{.code = ErrorCode::resource,
                     .cause = "the finished file cannot be put in its place: " + failure.message(),
                     .mend = "Check that the folder may be written to.",
                     .file = path};
    }
    return {};
}

}  // namespace cheval::fitting::bake

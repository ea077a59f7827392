#include "tests/support/glb_builder.h"

#include <cstdio>
#include <cstring>

namespace cheval::test {

using namespace fitting;

namespace {

std::string hexadecimal(std::uint64_t hash) {
    char text[17];
    (void)std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

template <typename Number>
std::vector<float> asFloats(const std::vector<Number>& numbers) {
    return {numbers.begin(), numbers.end()};
}

}  // namespace

GlbBuilder::GlbBuilder() {
    json = {{"asset", {{"version", "2.0"}}},
            {"nodes", nlohmann::json::array()},
            {"meshes", nlohmann::json::array()},
            {"accessors", nlohmann::json::array()},
            {"bufferViews", nlohmann::json::array()}};
}

int GlbBuilder::addAccessor(const void* from, std::size_t elementBytes, std::size_t count, int componentType,
                            const char* type) {
    binary.resize((binary.size() + 3) / 4 * 4);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", elementBytes * count}});
    const auto* bytes = static_cast<const std::uint8_t*>(from);
    binary.insert(binary.end(), bytes, bytes + elementBytes * count);
    json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                 {"componentType", componentType},
                                 {"count", count},
                                 {"type", type}});
    return static_cast<int>(json["accessors"].size()) - 1;
}

void GlbBuilder::addMesh(const std::string& node, const RestMesh& mesh) {
    nlohmann::json attributes;
    attributes["POSITION"] = addAccessor(mesh.positions.data(), 12, mesh.positions.size(), 5126, "VEC3");
    if (!mesh.normals.empty()) {
        attributes["NORMAL"] = addAccessor(mesh.normals.data(), 12, mesh.normals.size(), 5126, "VEC3");
    }
    if (!mesh.uv.empty()) attributes["TEXCOORD_0"] = addAccessor(mesh.uv.data(), 8, mesh.uv.size(), 5126, "VEC2");
    if (!mesh.weights.empty()) {
        std::vector<std::uint8_t> joints;
        std::vector<float> weights;
        for (const SkinningWeights& vertex : mesh.weights) {
            joints.insert(joints.end(), std::begin(vertex.joint), std::end(vertex.joint));
            weights.insert(weights.end(), std::begin(vertex.weight), std::end(vertex.weight));
        }
        attributes["JOINTS_0"] = addAccessor(joints.data(), 4, mesh.weights.size(), 5121, "VEC4");
        attributes["WEIGHTS_0"] = addAccessor(weights.data(), 16, mesh.weights.size(), 5126, "VEC4");
    }
    nlohmann::json primitive = {{"attributes", attributes}};
    if (!mesh.triangles.empty()) {
        primitive["indices"] = addAccessor(mesh.triangles.data(), 4, 3 * mesh.triangles.size(), 5125, "SCALAR");
    }
    json["meshes"].push_back({{"primitives", nlohmann::json::array({primitive})}});
    json["nodes"].push_back({{"name", node}, {"mesh", json["meshes"].size() - 1}});
}

void GlbBuilder::addScalar(const std::string& node, const std::string& attribute, const std::vector<float>& values) {
    const int added = addAccessor(values.data(), 4, values.size(), 5126, "SCALAR");
    primitive(node)["attributes"][attribute] = added;
}

void GlbBuilder::addSkin(const std::array<Eigen::Vector3f, kJointCount>& joints) {
    nlohmann::json list;
    for (std::size_t i = 0; i < kJointCount; ++i) {
        list.push_back(json["nodes"].size());
        json["nodes"].push_back(
            {{"name", kJointNames[i]}, {"translation", {joints[i].x(), joints[i].y(), joints[i].z()}}});
    }
    json["skins"] = nlohmann::json::array({{{"joints", list}}});
    for (nlohmann::json& node : json["nodes"]) {
        if (node.contains("mesh") &&
            json["meshes"][node["mesh"].get<std::size_t>()]["primitives"][0]["attributes"].contains("JOINTS_0")) {
            node["skin"] = 0;
        }
    }
}

void GlbBuilder::addTexture(const std::string& node, const std::vector<std::byte>& png) {
    binary.resize((binary.size() + 3) / 4 * 4);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", png.size()}});
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(png.data());
    binary.insert(binary.end(), bytes, bytes + png.size());
    json["images"].push_back({{"bufferView", json["bufferViews"].size() - 1}, {"mimeType", "image/png"}});
    json["textures"].push_back({{"source", json["images"].size() - 1}});
    json["materials"].push_back(
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", json["textures"].size() - 1}}}}}});
    primitive(node)["material"] = json["materials"].size() - 1;
}

nlohmann::json& GlbBuilder::primitive(const std::string& node) {
    for (nlohmann::json& candidate : json["nodes"]) {
        if (candidate["name"] == node) return json["meshes"][candidate["mesh"].get<std::size_t>()]["primitives"][0];
    }
    return json["no such node"];
}

nlohmann::json& GlbBuilder::accessor(const std::string& node, const std::string& attribute) {
    const nlohmann::json& found = primitive(node);
    const auto number = attribute == "indices" ? found["indices"] : found["attributes"][attribute];
    return json["accessors"][number.get<std::size_t>()];
}

std::uint8_t* GlbBuilder::data(const std::string& node, const std::string& attribute) {
    const auto view = accessor(node, attribute)["bufferView"].get<std::size_t>();
    return binary.data() + json["bufferViews"][view]["byteOffset"].get<std::size_t>();
}

void GlbBuilder::removeNode(const std::string& node) {
    for (nlohmann::json& candidate : json["nodes"]) {
        if (candidate["name"] == node) candidate = {{"name", "removed"}};
    }
}

std::vector<std::byte> GlbBuilder::bytes() const {
    nlohmann::json document = json;
    if (!document.contains("buffers")) {
        document["buffers"] = nlohmann::json::array({{{"byteLength", binary.size()}}});
    }
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::uint8_t> padded = binary;
    padded.resize((padded.size() + 3) / 4 * 4);
    std::vector<std::byte> out;
    const auto word = [&out](std::size_t value) {
        for (unsigned i = 0; i < 4; ++i)
            out.push_back(static_cast<std::byte>(value >> (8U * i) & 0xFFU));
    };
    word(0x46546C67);
    word(2);
    word(12 + 8 + text.size() + 8 + padded.size());
    word(text.size());
    word(0x4E4F534A);
    for (const char c : text)
        out.push_back(static_cast<std::byte>(c));
    word(padded.size());
    word(0x004E4942);
    for (const std::uint8_t byte : padded)
        out.push_back(static_cast<std::byte>(byte));
    return out;
}

GlbBuilder bodyGlb(const Body& body) {
    GlbBuilder glb;
    glb.addMesh("Body", body.mesh);
    RestMesh cage;
    cage.positions = body.outerCage;
    cage.uv = body.cageTemplate.uv;
    cage.weights = body.cageWeights;
    cage.triangles = body.cageTemplate.triangles;
    glb.addMesh("Body_OuterCage", cage);
    glb.addScalar("Body_OuterCage", "_WELD", asFloats(body.cageTemplate.weld));
    glb.addScalar("Body_OuterCage", "_MIRRORED", asFloats(body.cageTemplate.mirrored));
    std::vector<float> parts;
    for (const BodyPart part : body.cageTemplate.part)
        parts.push_back(static_cast<float>(part));
    glb.addScalar("Body_OuterCage", "_PART", parts);
    glb.addSkin(body.joints);
    glb.json["asset"]["extras"]["cheval"] = {{"format", "cheval-body-1"},
                                             {"template_hash", hexadecimal(body.cageTemplate.hash)}};
    return glb;
}

GlbBuilder garmentGlb(const Garment& garment, const Body& body) {
    GlbBuilder glb;
    glb.addMesh(garment.name, garment.mesh);
    glb.addScalar(garment.name, "_FREE", asFloats(garment.simulated));
    for (const bool inner : {true, false}) {
        RestMesh cage;
        cage.positions = inner ? garment.innerCage : garment.outerCage;
        cage.uv = body.cageTemplate.uv;
        cage.triangles = body.cageTemplate.triangles;
        glb.addMesh(garment.name + (inner ? "_InnerCage" : "_OuterCage"), cage);
    }
    glb.addScalar(garment.name + "_InnerCage", "_COVERED", asFloats(garment.covered));
    glb.addSkin(body.joints);
    glb.json["asset"]["extras"]["cheval"] = {
        {"format", "cheval-garment-1"}, {"template_hash", hexadecimal(body.cageTemplate.hash)},
        {"name", garment.name},         {"kind", garment.kind == GarmentKind::top ? "top" : "trousers"},
        {"layer", garment.layerOrder},  {"rigidity", 0.25}};
    return glb;
}

}  // namespace cheval::test

#include "fitting/garment/glb_check.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string_view>

#include <nlohmann/json.hpp>

namespace cheval::fitting {

namespace {

using nlohmann::json;

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr std::uint64_t kHeaderBytes = 12;
constexpr std::uint64_t kChunkHeaderBytes = 8;

const char* const kExportAgain = "export it again, as glTF Binary (.glb)";

std::uint32_t readWord(std::span<const std::byte> bytes, std::uint64_t at) {
    std::array<std::uint8_t, 4> word{};
    std::memcpy(word.data(), bytes.data() + at, word.size());
    return std::uint32_t{word[0]} | std::uint32_t{word[1]} << 8U | std::uint32_t{word[2]} << 16U |
           std::uint32_t{word[3]} << 24U;
}

std::string megabytes(std::uint64_t bytes) {
    return bytes < (1U << 20U) ? std::to_string(bytes) + " bytes" : std::to_string(bytes >> 20U) + " MiB";
}

// How deep arrays and objects nest, without parsing: quotes and escapes are all that matters.
std::size_t nestingOf(std::string_view text) {
    std::size_t depth = 0;
    std::size_t deepest = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\') {
                ++i;
            } else if (c == '"') {
                quoted = false;
            }
        } else if (c == '"') {
            quoted = true;
        } else if (c == '[' || c == '{') {
            deepest = std::max(deepest, ++depth);
        } else if ((c == ']' || c == '}') && depth > 0) {
            --depth;
        }
    }
    return deepest;
}

struct Chunks {
    std::string_view jsonText;
    std::uint64_t binaryBytes = 0;
};

class Checker {
  public:
    Checker(const GlbLimits& limits, const std::string& file) : limits_(limits), file_(file) {}

    Expected<Chunks> splitChunks(std::span<const std::byte> bytes) const;
    Expected<void> checkDocument(const json& document, std::uint64_t binaryBytes);

  private:
    [[nodiscard]] Error refuse(std::string key, std::string cause, std::string mend, std::string why) const {
        return {.code = ErrorCode::invalidInput,
                .cause = std::move(cause),
                .mend = std::move(mend),
                .why = std::move(why),
                .file = file_,
                .key = std::move(key)};
    }
    // A whole number of at least 0, or the default when the member is absent; nothing when it is anything else.
    static std::optional<std::uint64_t> whole(const json& object, const char* member, std::uint64_t absent) {
        const auto found = object.find(member);
        if (found == object.end()) return absent;
        if (!found->is_number_unsigned()) return std::nullopt;
        const auto value = found->get<std::uint64_t>();
        return value < (std::uint64_t{1} << 53U) ? std::optional(value) : std::nullopt;
    }

    Expected<void> checkLists(const json& document) const;
    Expected<void> checkBuffers(const json& document, std::uint64_t binaryBytes);
    Expected<void> checkViews(const json& views);
    Expected<void> checkAccessor(const json& accessor, const json& views, const std::string& key) const;
    bool soundTargets(const json& targets, std::size_t accessors) const;
    Expected<void> checkMeshes(const json& document) const;
    Expected<void> checkImages(const json& document) const;
    Expected<void> checkReferences(const json& document) const;

    const GlbLimits& limits_;
    const std::string& file_;
    std::uint64_t bufferBytes_ = 0;
};

Expected<Chunks> Checker::splitChunks(std::span<const std::byte> bytes) const {
    const std::uint64_t size = bytes.size();
    if (size > limits_.fileBytes) {
        return refuse("", "the file has " + megabytes(size), "use smaller textures and fewer vertices",
                      "assets over " + megabytes(limits_.fileBytes) + " are not loaded");
    }
    if (size < kHeaderBytes + kChunkHeaderBytes || readWord(bytes, 0) != kMagic) {
        return refuse("", "this is not a binary glTF file", kExportAgain, "it does not begin as one");
    }
    if (readWord(bytes, 4) != 2) {
        return refuse("", "this is glTF version " + std::to_string(readWord(bytes, 4)), kExportAgain,
                      "version 2 is read");
    }
    const std::uint64_t claimed = readWord(bytes, 8);
    if (claimed != size) {
        return refuse("", "the file has " + std::to_string(size) + " bytes but says " + std::to_string(claimed),
                      "copy or export it again", claimed > size ? "it is truncated" : "something was appended to it");
    }
    const std::uint64_t jsonBytes = readWord(bytes, 12);
    const std::uint64_t jsonAt = kHeaderBytes + kChunkHeaderBytes;
    if (readWord(bytes, 16) != kJsonChunk || jsonBytes > size - jsonAt || jsonBytes % 4 != 0) {
        return refuse("", "the description claims " + megabytes(jsonBytes) + " of a file of " + megabytes(size),
                      kExportAgain, "the file is damaged");
    }
    if (jsonBytes > limits_.jsonBytes) {
        return refuse("", "the description has " + megabytes(jsonBytes), "export the garment alone",
                      "over " + megabytes(limits_.jsonBytes) + " it is not parsed");
    }
    Chunks chunks;
    chunks.jsonText = {reinterpret_cast<const char*>(bytes.data() + jsonAt), jsonBytes};
    const std::uint64_t binaryAt = jsonAt + jsonBytes;
    if (binaryAt == size) return chunks;
    if (size - binaryAt < kChunkHeaderBytes || readWord(bytes, binaryAt + 4) != kBinChunk ||
        readWord(bytes, binaryAt) > size - binaryAt - kChunkHeaderBytes) {
        return refuse("", "the binary chunk claims more than the file holds", kExportAgain, "the file is damaged");
    }
    chunks.binaryBytes = readWord(bytes, binaryAt);
    return chunks;
}

Expected<void> Checker::checkLists(const json& document) const {
    for (const char* list : {"nodes", "meshes", "accessors", "bufferViews", "buffers", "materials", "textures",
                             "images", "samplers", "skins", "scenes", "animations", "cameras"}) {
        const auto found = document.find(list);
        if (found == document.end()) continue;
        if (!found->is_array() || found->size() > limits_.objects) {
            return refuse(list, "it is not a list of at most " + std::to_string(limits_.objects),
                          "export the garment alone", "an asset holds one body or one garment");
        }
        for (const json& entry : *found) {
            if (!entry.is_object()) return refuse(list, "an entry is not an object", kExportAgain, "glTF 2.0");
        }
    }
    const auto required = document.find("extensionsRequired");
    if (required != document.end() && (!required->is_array() || !required->empty())) {
        return refuse("extensionsRequired", "the file needs glTF extensions",
                      "switch off compression (Draco, meshopt, KTX) in the exporter", "none is understood here");
    }
    return {};
}

Expected<void> Checker::checkBuffers(const json& document, std::uint64_t binaryBytes) {
    const auto buffers = document.find("buffers");
    if (buffers == document.end() || buffers->size() != 1) {
        return refuse("buffers", "there is not exactly one buffer", kExportAgain, "all data is within the file");
    }
    const json& buffer = buffers->front();
    if (buffer.contains("uri")) {
        return refuse("buffers[0].uri", "the data lies in another file", kExportAgain,
                      "an asset opens nothing but itself");
    }
    const auto length = whole(buffer, "byteLength", 0);
    if (!length || *length == 0 || *length > binaryBytes) {
        return refuse("buffers[0].byteLength",
                      "the buffer claims " + (length ? megabytes(*length) : std::string("no number")) + " of the " +
                          megabytes(binaryBytes) + " that the file holds",
                      kExportAgain, "a buffer is within the file");
    }
    bufferBytes_ = *length;
    return {};
}

Expected<void> Checker::checkViews(const json& views) {
    for (std::size_t i = 0; i < views.size(); ++i) {
        const json& view = views[i];
        const std::string key = "bufferViews[" + std::to_string(i) + "]";
        const auto buffer = whole(view, "buffer", 1);
        const auto offset = whole(view, "byteOffset", 0);
        const auto length = whole(view, "byteLength", 0);
        const auto stride = whole(view, "byteStride", 4);
        if (!buffer || *buffer != 0 || !offset || !length || *length == 0 || *offset > bufferBytes_ ||
            *length > bufferBytes_ - *offset) {
            return refuse(key, "it reaches outside the buffer", kExportAgain, "the file is damaged");
        }
        if (!stride || *stride < 4 || *stride > 252 || *stride % 4 != 0) {
            return refuse(key + ".byteStride", "the stride is not 4, 8 … 252", kExportAgain, "glTF 2.0");
        }
    }
    return {};
}

std::uint64_t componentBytes(std::uint64_t componentType) {
    switch (componentType) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            return 0;
    }
}

std::uint64_t componentCount(const std::string& type) {
    constexpr std::array<std::pair<std::string_view, std::uint64_t>, 5> kTypes = {
        {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}}};
    for (const auto& [name, count] : kTypes) {
        if (type == name) return count;
    }
    return 0;
}

Expected<void> Checker::checkAccessor(const json& accessor, const json& views, const std::string& key) const {
    if (accessor.contains("sparse")) {
        return refuse(key + ".sparse", "the data is sparse", "export without sparse accessors", "they are not read");
    }
    const auto viewIndex = whole(accessor, "bufferView", views.size());
    const auto offset = whole(accessor, "byteOffset", 0);
    const auto count = whole(accessor, "count", 0);
    const auto componentType = whole(accessor, "componentType", 0);
    const auto type = accessor.find("type");
    if (!viewIndex || *viewIndex >= views.size() || !offset || !count || !componentType || type == accessor.end() ||
        !type->is_string()) {
        return refuse(key, "its description is not complete", kExportAgain, "glTF 2.0");
    }
    const auto normalized = accessor.find("normalized");
    if (normalized != accessor.end() && !normalized->is_boolean()) {
        return refuse(key + ".normalized", "it is neither true nor false", kExportAgain, "glTF 2.0");
    }
    const std::uint64_t component = componentBytes(*componentType);
    const std::uint64_t components = componentCount(type->get<std::string>());
    if (component == 0 || components == 0) {
        return refuse(key, "its component type or shape is unknown", kExportAgain, "glTF 2.0");
    }
    if (*count == 0 || *count > std::max(limits_.indices, limits_.vertices)) {
        return refuse(key + ".count", "it claims " + std::to_string(*count) + " elements", "use a coarser mesh",
                      "1 to " + std::to_string(std::max(limits_.indices, limits_.vertices)) + " are read");
    }
    const json& view = views[*viewIndex];
    const std::uint64_t viewBytes = *whole(view, "byteLength", 0);
    const std::uint64_t element = component * components;
    const std::uint64_t stride = view.contains("byteStride") ? *whole(view, "byteStride", 0) : element;
    if (stride < element || *offset > viewBytes || (*count - 1) * stride + element > viewBytes - *offset) {
        return refuse(key, "its " + std::to_string(*count) + " elements reach outside its buffer view", kExportAgain,
                      "the file is damaged");
    }
    return {};
}

bool Checker::soundTargets(const json& targets, std::size_t accessors) const {
    if (!targets.is_array() || targets.size() > limits_.morphTargets) return false;
    return std::all_of(targets.begin(), targets.end(), [&](const json& target) {
        return target.is_object() && target.size() <= limits_.objects &&
               std::all_of(target.begin(), target.end(), [&](const json& attribute) {
                   return attribute.is_number_unsigned() && attribute.get<std::uint64_t>() < accessors;
               });
    });
}

Expected<void> Checker::checkMeshes(const json& document) const {
    const std::size_t accessors = document.contains("accessors") ? document["accessors"].size() : 0;
    const auto meshes = document.find("meshes");
    if (meshes == document.end()) return {};
    for (std::size_t i = 0; i < meshes->size(); ++i) {
        const std::string key = "meshes[" + std::to_string(i) + "]";
        const auto primitives = (*meshes)[i].find("primitives");
        if (primitives == (*meshes)[i].end() || !primitives->is_array() || primitives->size() != 1 ||
            !primitives->front().is_object()) {
            return refuse(key, "the mesh has not exactly one primitive", "give the object one material",
                          "each mesh is drawn in one piece");
        }
        const json& primitive = primitives->front();
        const auto mode = whole(primitive, "mode", 4);
        const bool targets = primitive.contains("targets");
        if (!mode || *mode != 4 || (targets && limits_.morphTargets == 0)) {
            return refuse(key, "it is not plain triangles", "export triangles, without shape keys",
                          "only triangles are drawn");
        }
        if (targets && !soundTargets(primitive["targets"], accessors)) {
            return refuse(key + ".targets", "it refers to data that is not there, or has too many shape keys",
                          kExportAgain, "at most " + std::to_string(limits_.morphTargets) + " are used");
        }
        const auto indices = whole(primitive, "indices", accessors);
        const auto attributes = primitive.find("attributes");
        bool sound = indices && (!primitive.contains("indices") || *indices < accessors) &&
                     attributes != primitive.end() && attributes->is_object() && attributes->size() <= limits_.objects;
        if (sound) {
            for (const json& attribute : *attributes) {
                sound = sound && attribute.is_number_unsigned() && attribute.get<std::uint64_t>() < accessors;
            }
        }
        if (!sound) return refuse(key, "it refers to data that is not there", kExportAgain, "the file is damaged");
    }
    return {};
}

Expected<void> Checker::checkImages(const json& document) const {
    const auto images = document.find("images");
    if (images == document.end()) return {};
    const std::size_t views = document.contains("bufferViews") ? document["bufferViews"].size() : 0;
    for (std::size_t i = 0; i < images->size(); ++i) {
        const json& image = (*images)[i];
        const std::string key = "images[" + std::to_string(i) + "]";
        if (image.contains("uri")) {
            return refuse(key + ".uri", "the texture lies in another file", kExportAgain,
                          "an asset opens nothing but itself");
        }
        const auto view = whole(image, "bufferView", views);
        if (!view || *view >= views) {
            return refuse(key, "the texture is not in the file", kExportAgain, "the file is damaged");
        }
    }
    return {};
}

// Lists of node numbers: a loader follows them.
Expected<void> Checker::checkReferences(const json& document) const {
    const std::size_t nodes = document.contains("nodes") ? document["nodes"].size() : 0;
    const auto inRange = [nodes](const json& list) {
        return list.is_array() && list.size() <= nodes && std::all_of(list.begin(), list.end(), [nodes](const json& n) {
                   return n.is_number_unsigned() && n.get<std::uint64_t>() < nodes;
               });
    };
    for (const auto& [list, member] : {std::pair{"nodes", "children"}, {"skins", "joints"}, {"scenes", "nodes"}}) {
        const auto found = document.find(list);
        if (found == document.end()) continue;
        for (const json& entry : *found) {
            const auto numbers = entry.find(member);
            if (numbers != entry.end() && !inRange(*numbers)) {
                return refuse(std::string(list) + "." + member, "it refers to nodes that are not there", kExportAgain,
                              "the file is damaged");
            }
        }
    }
    return {};
}

Expected<void> Checker::checkDocument(const json& document, std::uint64_t binaryBytes) {
    if (auto checked = checkLists(document); !checked) return checked;
    if (auto checked = checkBuffers(document, binaryBytes); !checked) return checked;
    const json none = json::array();
    const json& views = document.contains("bufferViews") ? document["bufferViews"] : none;
    if (auto checked = checkViews(views); !checked) return checked;
    if (document.contains("accessors")) {
        const json& accessors = document["accessors"];
        for (std::size_t i = 0; i < accessors.size(); ++i) {
            auto checked = checkAccessor(accessors[i], views, "accessors[" + std::to_string(i) + "]");
            if (!checked) return checked;
        }
    }
    if (auto checked = checkMeshes(document); !checked) return checked;
    if (auto checked = checkImages(document); !checked) return checked;
    return checkReferences(document);
}

}  // namespace

Expected<void> checkGlb(std::span<const std::byte> bytes, const GlbLimits& limits, const std::string& file) {
    Checker checker(limits, file);
    auto chunks = checker.splitChunks(bytes);
    if (!chunks) return std::move(chunks).error();
    Error unreadable{.code = ErrorCode::invalidInput,
                     .cause = "the description cannot be read",
                     .mend = kExportAgain,
                     .why = "it is not sound JSON",
                     .file = file};
    if (nestingOf(chunks->jsonText) > limits.nesting) return unreadable;
    const json document = json::parse(chunks->jsonText, nullptr, false);
    if (!document.is_object()) return unreadable;
    return checker.checkDocument(document, chunks->binaryBytes);
}

}  // namespace cheval::fitting

#include "fitting/garment/gltf_access.h"

#include <cmath>
#include <cstddef>
#include <cstring>

namespace cheval::fitting {

namespace {

// Calls `take(element, component, address)` for every number of an accessor.
template <typename Take>
void forEachNumber(const tinygltf::Model& model, const tinygltf::Accessor& accessor, int components, Take take) {
    const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
    const std::vector<unsigned char>& data = model.buffers[static_cast<std::size_t>(view.buffer)].data;
    const auto componentBytes =
        static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType)));
    const auto count = static_cast<std::size_t>(components);
    const std::size_t stride = view.byteStride != 0 ? view.byteStride : componentBytes * count;
    const unsigned char* const first = data.data() + view.byteOffset + accessor.byteOffset;
    for (std::size_t element = 0; element < accessor.count; ++element) {
        for (std::size_t component = 0; component < count; ++component) {
            take(element * count + component, first + element * stride + component * componentBytes);
        }
    }
}

const tinygltf::Accessor* accessorOf(const tinygltf::Model& model, int accessor, int components) {
    if (accessor < 0 || static_cast<std::size_t>(accessor) >= model.accessors.size()) return nullptr;
    const tinygltf::Accessor& found = model.accessors[static_cast<std::size_t>(accessor)];
    const int type = components == 1 ? TINYGLTF_TYPE_SCALAR : components;
    return found.type == type ? &found : nullptr;
}

template <typename Number>
Number readNumber(const unsigned char* from) {
    Number value{};
    std::memcpy(&value, from, sizeof value);
    return value;
}

std::optional<Eigen::Affine3d> localTransform(const tinygltf::Node& node) {
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (node.matrix.size() == 16) {
        transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
        if (!transform.matrix().row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1))) return std::nullopt;
    } else {
        const bool sound = node.matrix.empty() && (node.translation.empty() || node.translation.size() == 3) &&
                           (node.rotation.empty() || node.rotation.size() == 4) &&
                           (node.scale.empty() || node.scale.size() == 3);
        if (!sound) return std::nullopt;
        if (!node.translation.empty()) transform.translate(Eigen::Map<const Eigen::Vector3d>(node.translation.data()));
        if (!node.rotation.empty()) {
            const Eigen::Quaterniond rotation(Eigen::Map<const Eigen::Vector4d>(node.rotation.data()));
            if (!(std::abs(rotation.norm() - 1.0) < 1e-3)) return std::nullopt;
            transform.rotate(rotation.normalized());
        }
        if (!node.scale.empty()) transform.scale(Eigen::Map<const Eigen::Vector3d>(node.scale.data()).eval());
    }
    return transform.matrix().allFinite() ? std::optional(transform) : std::nullopt;
}

}  // namespace

std::optional<std::vector<float>> readFloats(const tinygltf::Model& model, int accessor, int components) {
    const tinygltf::Accessor* const found = accessorOf(model, accessor, components);
    if (found == nullptr || found->componentType != TINYGLTF_COMPONENT_TYPE_FLOAT) return std::nullopt;
    std::vector<float> values(found->count * static_cast<std::size_t>(components));
    forEachNumber(model, *found, components,
                  [&](std::size_t i, const unsigned char* from) { values[i] = readNumber<float>(from); });
    return values;
}

std::optional<std::vector<std::uint32_t>> readWholeNumbers(const tinygltf::Model& model, int accessor, int components) {
    const tinygltf::Accessor* const found = accessorOf(model, accessor, components);
    if (found == nullptr) return std::nullopt;
    std::vector<std::uint32_t> values(found->count * static_cast<std::size_t>(components));
    const auto read = [&](auto number) {
        forEachNumber(model, *found, components, [&](std::size_t i, const unsigned char* from) {
            values[i] = readNumber<decltype(number)>(from);
        });
    };
    switch (found->componentType) {
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            read(std::uint8_t{});
            break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            read(std::uint16_t{});
            break;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            read(std::uint32_t{});
            break;
        default:
            return std::nullopt;
    }
    return values;
}

std::optional<std::vector<Eigen::Affine3d>> globalTransforms(const tinygltf::Model& model) {
    const std::size_t count = model.nodes.size();
    std::vector<std::size_t> parent(count, count);
    for (std::size_t i = 0; i < count; ++i) {
        for (const int child : model.nodes[i].children) {
            if (child < 0 || static_cast<std::size_t>(child) >= count) return std::nullopt;
            if (parent[static_cast<std::size_t>(child)] != count) return std::nullopt;
            parent[static_cast<std::size_t>(child)] = i;
        }
    }
    std::vector<Eigen::Affine3d> globals(count);
    for (std::size_t i = 0; i < count; ++i) {
        Eigen::Affine3d transform = Eigen::Affine3d::Identity();
        std::size_t steps = 0;
        for (std::size_t node = i; node != count; node = parent[node]) {
            const auto local = localTransform(model.nodes[node]);
            if (!local || ++steps > count) return std::nullopt;
            transform = *local * transform;
        }
        if (!transform.matrix().allFinite()) return std::nullopt;
        globals[i] = transform;
    }
    return globals;
}

}  // namespace cheval::fitting

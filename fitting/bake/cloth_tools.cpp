#include "fitting/bake/cloth_tools.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "fitting/bake/spline.h"

namespace cheval::fitting::bake {
namespace {

std::vector<Triangle> trianglesOf(const std::vector<Cloth::Face>& faces) {
    std::vector<Triangle> triangles;
    for (const Cloth::Face& face : faces) {
        triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
        triangles.push_back({face.vertex[0], face.vertex[2], face.vertex[3]});
    }
    return triangles;
}

double latticeNoise(int x, int y, int z) {
    auto h = static_cast<std::uint32_t>(x) * 0x8DA6B343U ^ static_cast<std::uint32_t>(y) * 0xD8163841U ^
             static_cast<std::uint32_t>(z) * 0xCB1AB31FU;
    h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
    h = (h ^ (h >> 12U)) * 0x297A2D39U;
    h ^= h >> 15U;
    return static_cast<double>(h) / 2147483647.5 - 1.0;
}

/// Mixes the weights of several skin vertices; at most four bones stay.
SkinningWeights mix(const std::vector<std::pair<double, const SkinningWeights*>>& parts) {
    std::array<double, kJointCount> row{};
    for (const auto& [share, weights] : parts) {
        for (std::size_t i = 0; i < 4; ++i) {
            row[weights->joint[i]] += share * static_cast<double>(weights->weight[i]);
        }
    }
    SkinningWeights result;
    double sum = 0.0;
    std::array<double, 4> kept{};
    for (std::size_t i = 0; i < 4; ++i) {
        const auto best = std::max_element(row.begin(), row.end());
        kept[i] = *best;
        result.joint[i] = *best > 0.0 ? static_cast<std::uint8_t>(best - row.begin()) : std::uint8_t{0};
        sum += kept[i];
        *best = 0.0;
    }
    for (std::size_t i = 0; i < 4; ++i) {
        result.weight[i] = static_cast<float>(kept[i] / sum);
    }
    return result;
}

}  // namespace

double smoothNoise(const Vec3& place) {
    std::array<int, 3> cell{};
    std::array<double, 3> blend{};
    for (int i = 0; i < 3; ++i) {
        const double floor = std::floor(place[i]);
        cell[static_cast<std::size_t>(i)] = static_cast<int>(floor);
        blend[static_cast<std::size_t>(i)] = smoothStep(0.0, 1.0, place[i] - floor);
    }
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1;
        const int dy = (corner >> 1) & 1;
        const int dz = (corner >> 2) & 1;
        const double share = (dx != 0 ? blend[0] : 1.0 - blend[0]) * (dy != 0 ? blend[1] : 1.0 - blend[1]) *
                             (dz != 0 ? blend[2] : 1.0 - blend[2]);
        sum += share * latticeNoise(cell[0] + dx, cell[1] + dy, cell[2] + dz);
    }
    return sum;
}

Tailor::Tailor(const BodyModel& model) : model_(model) {
    std::vector<Triangle> triangles;
    for (const QuadMesh::Quad& quad : model.fine.quads) {
        for (const Triangle& triangle : cut(quad)) {
            triangles.push_back(triangle);
        }
    }
    skinNormals_ = vertexNormals(model.fine.positions, triangles);
}

void Tailor::takeSkin(const Cover& cover) {
    cloth_.coveredSkin.assign(model_.fine.positions.size(), 0);
    cloth_.clothOnSkin.assign(model_.fine.positions.size(), 0);
    for (const QuadMesh::Quad& quad : model_.fine.quads) {
        const std::optional<Placement> placement = cover(quad);
        if (!placement) continue;
        Cloth::Face face;
        face.panel = placement->panel;
        face.at = placement->at;
        for (std::size_t c = 0; c < 4; ++c) {
            const std::uint32_t v = quad.vertex[c];
            if (cloth_.coveredSkin[v] == 0) {
                cloth_.coveredSkin[v] = 1;
                cloth_.clothOnSkin[v] = static_cast<std::uint32_t>(cloth_.positions.size());
                cloth_.positions.push_back(model_.fine.positions[v]);
                cloth_.weights.push_back(model_.fineWeights[v]);
                skinOf_.push_back(v);
                hanging_.push_back(0);
            }
            face.vertex[c] = cloth_.clothOnSkin[v];
        }
        cloth_.faces.push_back(face);
    }
}

std::uint32_t Tailor::addHanging(const Vec3& place) {
    cloth_.positions.push_back(place);
    cloth_.weights.emplace_back();
    hanging_.push_back(1);
    return static_cast<std::uint32_t>(cloth_.positions.size()) - 1;
}

void Tailor::connect() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const Cloth::Face& face : cloth_.faces) {
        for (std::size_t c = 0; c < 4; ++c) {
            ++uses[std::minmax(face.vertex[c], face.vertex[(c + 1) % 4])];
        }
    }
    onEdge_.assign(cloth_.positions.size(), 0);
    for (const auto& [edge, count] : uses) {
        if (count == 1) onEdge_[edge.first] = onEdge_[edge.second] = 1;
    }
    around_.assign(cloth_.positions.size(), {});
    for (const auto& [edge, count] : uses) {
        // What lies on an edge is drawn along the edge alone.
        if (count == 1 || onEdge_[edge.first] == 0) around_[edge.first].push_back(edge.second);
        if (count == 1 || onEdge_[edge.second] == 0) around_[edge.second].push_back(edge.first);
    }
}

void Tailor::smooth(int rounds, double share) {
    connect();
    for (int round = 0; round < rounds; ++round) {
        std::vector<Vec3> moved = cloth_.positions;
        for (std::size_t v = 0; v < moved.size(); ++v) {
            if (around_[v].empty()) continue;
            Vec3 mean = Vec3::Zero();
            for (const std::uint32_t other : around_[v]) {
                mean += cloth_.positions[other];
            }
            moved[v] += share * (mean / static_cast<double>(around_[v].size()) - moved[v]);
        }
        cloth_.positions = std::move(moved);
    }
}

void Tailor::clear(const std::function<double(const Vec3&)>& clearance) {
    const Field field = [this](const Vec3& point) { return model_.field.mirrored(point); };
    for (Vec3& place : cloth_.positions) {
        const double least = clearance(place);
        if (field(place) < least) place = project(field, place, least, false);
    }
}

void Tailor::fold(const std::function<double(const Vec3&, const Vec3&)>& depth) {
    const std::vector<Vec3> normals = vertexNormals(cloth_.positions, trianglesOf(cloth_.faces));
    for (std::size_t v = 0; v < cloth_.positions.size(); ++v) {
        cloth_.positions[v] += depth(cloth_.positions[v], normals[v]) * normals[v];
    }
}

void Tailor::weighHanging() {
    constexpr std::size_t kNearest = 24;
    // Only trunk and legs carry what hangs.
    std::set<std::uint32_t> carriers;
    for (const QuadMesh::Quad& quad : model_.fine.quads) {
        if (quad.chart == Chart::trunk || quad.chart == Chart::leftLeg || quad.chart == Chart::rightLeg) {
            carriers.insert(quad.vertex.begin(), quad.vertex.end());
        }
    }
    std::vector<std::pair<double, std::uint32_t>> near;
    for (std::size_t v = 0; v < cloth_.positions.size(); ++v) {
        if (hanging_[v] == 0) continue;
        near.clear();
        for (const std::uint32_t skin : carriers) {
            near.emplace_back((model_.fine.positions[skin] - cloth_.positions[v]).squaredNorm(), skin);
        }
        std::partial_sort(near.begin(), near.begin() + kNearest, near.end());
        std::vector<std::pair<double, const SkinningWeights*>> parts;
        for (std::size_t i = 0; i < kNearest; ++i) {
            parts.emplace_back(1.0 / (near[i].first + 1e-4), &model_.fineWeights[near[i].second]);
        }
        cloth_.weights[v] = mix(parts);
    }
}

void Tailor::turnEdges(double thickness) {
    connect();
    const std::vector<Vec3> normals = vertexNormals(cloth_.positions, trianglesOf(cloth_.faces));
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const Cloth::Face& face : cloth_.faces) {
        for (std::size_t c = 0; c < 4; ++c) {
            ++uses[std::minmax(face.vertex[c], face.vertex[(c + 1) % 4])];
        }
    }
    // The neighbour of an edge vertex that lies inside the cloth.
    std::vector<std::uint32_t> inner(cloth_.positions.size(), 0);
    for (const auto& [edge, count] : uses) {
        const auto [a, b] = edge;
        if (count == 1) continue;
        if (onEdge_[a] != 0 && onEdge_[b] == 0) inner[a] = b;
        if (onEdge_[b] != 0 && onEdge_[a] == 0) inner[b] = a;
    }
    struct Turned {
        std::uint32_t lip, inside;
    };
    std::map<std::uint32_t, Turned> turned;
    const auto turn = [&](std::uint32_t v) {
        const auto found = turned.find(v);
        if (found != turned.end()) return found->second;
        const Vec3 place = cloth_.positions[v];
        const Vec3 back = cloth_.positions[inner[v]];
        const Vec3 out = (place - back).normalized();
        cloth_.positions.push_back(place + 0.45 * thickness * out - 0.5 * thickness * normals[v]);
        cloth_.positions.push_back(place + 0.65 * (back - place) - thickness * normals[v]);
        for (int i = 0; i < 2; ++i) {
            cloth_.weights.push_back(cloth_.weights[v]);
            hanging_.push_back(0);
        }
        const auto count = static_cast<std::uint32_t>(cloth_.positions.size());
        return turned[v] = {count - 2, count - 1};
    };
    const std::size_t faceCount = cloth_.faces.size();
    for (std::size_t f = 0; f < faceCount; ++f) {
        for (std::size_t c = 0; c < 4; ++c) {
            const Cloth::Face face = cloth_.faces[f];
            const std::size_t next = (c + 1) % 4;
            const std::uint32_t a = face.vertex[c];
            const std::uint32_t b = face.vertex[next];
            if (uses.at(std::minmax(a, b)) != 1) continue;
            const Turned ta = turn(a);
            const Turned tb = turn(b);
            Cloth::Face border = face;
            border.turned = true;
            border.at = {face.at[next], face.at[c], face.at[c], face.at[next]};
            border.vertex = {b, a, ta.lip, tb.lip};
            cloth_.faces.push_back(border);
            border.vertex = {tb.lip, ta.lip, ta.inside, tb.inside};
            cloth_.faces.push_back(border);
        }
    }
}

}  // namespace cheval::fitting::bake

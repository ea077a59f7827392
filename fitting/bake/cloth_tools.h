// What every cut shares: taking quads off the skin, smoothing, folds, clearance and turned edges.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "fitting/bake/cloth_cut.h"

namespace cheval::fitting::bake {

/// Where a face of the skin goes in the garment; nothing where it is not covered.
struct Placement {
    Panel panel = Panel::front;
    std::array<GridPlace, 4> at{};
};
using Cover = std::function<std::optional<Placement>(const QuadMesh::Quad&)>;

/// A cloth being cut, with the body under it.
class Tailor {
  public:
    explicit Tailor(const BodyModel& model);
    /// Takes the covered quads of the skin.
    void takeSkin(const Cover& cover);
    [[nodiscard]] Cloth& cloth() { return cloth_; }
    [[nodiscard]] const BodyModel& model() const { return model_; }
    [[nodiscard]] const Vec3& skinNormal(std::size_t fineVertex) const { return skinNormals_[fineVertex]; }
    /// The fine body vertex under each cloth vertex that was taken from the skin.
    [[nodiscard]] const std::vector<std::uint32_t>& skinOf() const { return skinOf_; }
    /// Adds a vertex that hangs free of the skin; its weights come from the nearest skin.
    std::uint32_t addHanging(const Vec3& place);
    void addFace(const Cloth::Face& face) { cloth_.faces.push_back(face); }

    /// Pulls vertices towards their neighbours; those on an edge only along it.
    void smooth(int rounds, double share);
    /// Pushes whatever is closer to the skin than `clearance(place)` metres out to it.
    void clear(const std::function<double(const Vec3& place)>& clearance);
    /// Moves the cloth along its normals by `depth(place)` metres.
    void fold(const std::function<double(const Vec3& place, const Vec3& normal)>& depth);
    /// Weights of hanging vertices become those of the nearest skin, smoothly.
    void weighHanging();
    /// Gives every open edge a lip and a turned-in border, so that the cloth has a thickness where one sees it.
    void turnEdges(double thickness);

  private:
    void connect();

    const BodyModel& model_;
    Cloth cloth_;
    std::vector<Vec3> skinNormals_;
    std::vector<std::uint32_t> skinOf_;
    std::vector<std::vector<std::uint32_t>> around_;
    std::vector<std::uint8_t> onEdge_;
    std::vector<std::uint8_t> hanging_;
};

/// Smooth noise in −1…1, the same everywhere and always; features are about 1 unit wide.
double smoothNoise(const Vec3& place);

}  // namespace cheval::fitting::bake

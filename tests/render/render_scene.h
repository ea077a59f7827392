// A small world for tests of drawing: a person of capsules before a patterned wall, seen by a perfect sensor in any
// mount, and a tube of cloth that they wear. Everything comes from a few formulas, so that a test can say where each
// thing must appear.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fitting/material.h"
#include "fitting/mesh.h"
#include "fitting/skeleton.h"
#include "hal/frame.h"
#include "hal/image.h"
#include "render/renderer.h"

namespace cheval::test {

/// How the sensor hangs: upright, or with the picture's right or left edge upwards.
enum class Mounting : std::uint8_t { upright, rightEdgeUp, leftEdgeUp };

struct RenderSceneOptions {
    Mounting mounting = Mounting::upright;
    bool colour = true;
    bool armAcross = false;  ///< The left forearm is held before the chest.
    bool sideMarker = true;  ///< A red ball beside the person, at their left.
    bool dressed = true;
    float personX = 0.0F;  ///< Mirror frame, metres.
    float personZ = 2.2F;
    float clothBehind = 0.0F;  ///< Moves the garment away from the glass, metres.
};

/// Owns what a render::Scene borrows.
class RenderScene {
  public:
    explicit RenderScene(const RenderSceneOptions& options);

    /// The scene as the renderer takes it; valid while this lives.
    [[nodiscard]] render::Scene scene(render::View view = render::View::mirror) const;
    /// Material 0: the mannequin; 1: striped cloth.
    [[nodiscard]] std::span<const fitting::Material> materials() const { return materials_; }
    [[nodiscard]] const fitting::PosedMesh& mesh() const { return mesh_; }
    fitting::PosedMesh& mesh() { return mesh_; }
    [[nodiscard]] const fitting::SensorPlacement& placement() const { return placement_; }
    [[nodiscard]] const hal::Intrinsics& intrinsics() const { return intrinsics_; }
    [[nodiscard]] bool rotated() const { return options_.mounting != Mounting::upright; }
    /// Where the red ball is, mirror frame.
    [[nodiscard]] Eigen::Vector3f marker() const;
    /// Where the chest's front is, mirror frame.
    [[nodiscard]] Eigen::Vector3f chest() const;
    /// Where the forearm is, mirror frame; only with armAcross.
    [[nodiscard]] Eigen::Vector3f forearm() const;

    static constexpr hal::Rgb8 kMarkerColour{220, 30, 30};
    static constexpr hal::Rgb8 kSkinColour{205, 160, 135};
    static constexpr std::uint8_t kUserLabel = 3;

  private:
    void makeMaterials();
    void makeMesh();
    void addTube(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius, fitting::PartKind kind,
                 std::uint32_t material, std::uint8_t layer);
    void takePicture();

    RenderSceneOptions options_;
    hal::Intrinsics intrinsics_;
    fitting::SensorPlacement placement_;
    hal::Image<hal::Rgb8> colour_;
    hal::Image<std::uint16_t> depth_;
    hal::Image<std::uint8_t> userMap_;
    std::vector<fitting::Material> materials_;
    fitting::PosedMesh mesh_;
    fitting::Skeleton skeleton_;
};

}  // namespace cheval::test

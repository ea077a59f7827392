// The part that GL does: garments (and in the avatar view the body) drawn over the rectangle that they cover, and read
// back. Everything full-screen is done elsewhere, on the CPU.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fitting/material.h"
#include "fitting/mesh.h"
#include "hal/expected.h"
#include "hal/image.h"
#include "render/gl_context.h"
#include "render/projection.h"

namespace cheval::render {

/// What to draw and how.
struct GarmentView {
    Projection projection = Projection::Zero();
    bool withBody = false;  ///< The avatar view draws the mannequin too.
    Eigen::Vector3f exposure = Eigen::Vector3f::Ones();
};

/// GL objects for meshes and materials. Thread-bound; the context must be current for every call and outlive this.
class GarmentPass {
  public:
    /// Uploads the materials. `width` × `height` is the display's size; distances are drawn at most at
    /// `distanceSize` pixels squared.
    static Expected<std::unique_ptr<GarmentPass>> create(GlContext& context, int width, int height, int distanceSize,
                                                         std::span<const fitting::Material> materials);
    ~GarmentPass();
    GarmentPass(const GarmentPass&) = delete;
    GarmentPass& operator=(const GarmentPass&) = delete;

    /// Hands the vertices to GL, and indices and parts when topologyRevision moved. Refuses indices beyond the vertices
    /// and materials that were never given.
    Expected<void> upload(const fitting::PosedMesh& mesh);
    /// The display's pixels that the uploaded mesh covers, at most `width` × `height`; empty when it is out of view.
    [[nodiscard]] PixelRect bounds(const fitting::PosedMesh& mesh, const GarmentView& view) const;

    /// Draws the part `rect` of the display at `columns` × `rows` pixels and starts the work; does not wait.
    void drawColour(const GarmentView& view, const PixelRect& rect, int columns, int rows);
    /// Waits for drawColour(): alpha is 255 where there is cloth, else all is 0.
    void readColour(hal::ImageView<hal::Rgba8> into) const;
    /// As drawColour(), with distances instead of colours, of the part (left, top, width, height) of the display.
    void drawDistance(const GarmentView& view, const Eigen::Vector4f& part, int columns, int rows);
    /// Waits for drawDistance(): millimetres = 256·r + g where b is 255.
    void readDistance(hal::ImageView<hal::Rgba8> into) const;
    /// An error that GL met since the last call.
    [[nodiscard]] Expected<void> check() const;

  private:
    struct Target {
        unsigned framebuffer = 0, colour = 0, depth = 0;
    };
    struct Look {
        unsigned texture = 0;
        Eigen::Vector3f baseColour = Eigen::Vector3f::Ones();
        float sheen = 0.0F;
        bool doubleSided = false;
    };
    struct Part {
        fitting::MeshPart part;
        std::uint32_t firstVertex = 0, lastVertex = 0;
    };

    GarmentPass(GlContext& context, int width, int height) : context_(context), width_(width), height_(height) {}
    Expected<void> createTarget(Target& target, int width, int height) const;
    Expected<void> createPrograms();
    /// Draws a triangle in every look: a software driver compiles for each kind of drawing when it first meets it,
    /// which would hold up the first dressed picture by some frames.
    Expected<void> warmUp();
    Expected<Look> createLook(const fitting::Material& material) const;
    Expected<void> takeTopology(const fitting::PosedMesh& mesh);
    void begin(const Target& target, int columns, int rows) const;
    void read(const Target& target, hal::ImageView<hal::Rgba8> into) const;

    GlContext& context_;
    int width_, height_;
    unsigned cloth_ = 0, distance_ = 0;
    int clothClip_ = -1, clothClipDepth_ = -1, clothBias_ = -1, clothEye_ = -1, clothExposure_ = -1, clothSheen_ = -1,
        clothBaseColour_ = -1, distanceClip_ = -1;
    unsigned vertexArray_ = 0, vertexBuffer_ = 0, indexBuffer_ = 0;
    std::size_t vertexCapacity_ = 0, indexCapacity_ = 0;  ///< Bytes.
    unsigned white_ = 0;
    Target colourTarget_, distanceTarget_;
    std::vector<Look> looks_;
    std::vector<Part> parts_;  ///< Outermost layer first, the body last.
    std::uint64_t topologyRevision_ = 0;
    std::size_t vertexCount_ = 0;
    bool hasTopology_ = false;
};

}  // namespace cheval::render

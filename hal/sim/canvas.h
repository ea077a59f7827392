// A small z-buffer rasteriser with two by two samples a pixel, for the simulated room and the people in it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "hal/sim/loft.h"
#include "hal/sim/view.h"

namespace cheval::hal::sim {

inline constexpr int kSamplesAcross = 2;  ///< Samples a pixel in each direction.

/// Pixels from (left, top) up to but not including (right, bottom).
struct PixelBox {
    int left = 0, top = 0, right = 0, bottom = 0;
    [[nodiscard]] bool empty() const { return left >= right || top >= bottom; }
    [[nodiscard]] PixelBox grown(int by, int width, int height) const;
    /// The least box around both.
    [[nodiscard]] PixelBox joined(const PixelBox& other) const;
};

/// A vertex on its way to the canvas: sample coordinates, 1/z in 1/m, and sRGB 0…255.
struct CanvasVertex {
    float x, y, nearness;
    float r, g, b;
};

/// What one sample shows: red, green, blue in three bytes, lowest first, then four bits of material and four of owner.
using Paint = std::uint32_t;
constexpr Paint paint(std::uint32_t r, std::uint32_t g, std::uint32_t b, Material material, std::uint32_t owner = 0) {
    return r | g << 8U | b << 16U | static_cast<std::uint32_t>(material) << 24U | owner << 28U;
}
constexpr Material materialOf(Paint what) {
    return static_cast<Material>(what >> 24U & 0xfU);
}
/// 0: the room; else 1 + the number of a figure.
constexpr std::uint8_t ownerOf(Paint what) {
    return static_cast<std::uint8_t>(what >> 28U);
}

/// Thread-bound. Takes memory when made, never when drawn on.
class Canvas {
  public:
    Canvas(int width, int height);

    /// Empties the samples of these pixels.
    void clear(const PixelBox& box);
    /// Draws what faces the viewer and is nearer than what is there. `owner` is under 16. Without `coloured` all is
    /// black, and drawn in two thirds of the time.
    void draw(std::span<const CanvasVertex> vertices, const Mesh& mesh, std::uint32_t owner = 0, bool coloured = true);
    void put(int sampleX, int sampleY, float nearness, Paint what);

    /// The surface that a pixel shows: the nearest samples that belong together.
    struct Pixel {
        float nearness = 0.0F;  ///< Their mean, which is that of the pixel's centre; 0 where nothing is.
        int samples = 0;        ///< How many they are.
        Paint nearest = 0;      ///< What the nearest of them shows.
    };
    [[nodiscard]] Pixel pixel(int x, int y) const;

    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int sampleWidth() const { return width_ * kSamplesAcross; }
    [[nodiscard]] int sampleHeight() const { return height_ * kSamplesAcross; }
    [[nodiscard]] const float* nearnessRow(int sampleY) const { return &nearness_[offset(sampleY)]; }
    [[nodiscard]] const Paint* paintRow(int sampleY) const { return &paint_[offset(sampleY)]; }

  private:
    [[nodiscard]] std::size_t offset(int sampleY) const {
        return static_cast<std::size_t>(sampleY) * static_cast<std::size_t>(sampleWidth());
    }
    template <bool kColoured>
    void drawTriangle(const CanvasVertex& a, const CanvasVertex& b, const CanvasVertex& c, Paint colourless);

    int width_, height_;
    std::vector<float> nearness_;  ///< 0 where nothing is.
    std::vector<Paint> paint_;
};

/// Lights and projects `mesh` whose vertices are at `positions` with `normals` (mirror frame), and returns the box of
/// pixels that it may touch. Vertices that lie nearer than 0.2 m to the sensor's plane make the box empty. Without
/// `coloured` it only projects.
PixelBox light(const View& view, const Mesh& mesh, std::span<const Eigen::Vector3f> positions,
               std::span<const Eigen::Vector3f> normals, std::span<CanvasVertex> vertices, bool coloured = true);

}  // namespace cheval::hal::sim

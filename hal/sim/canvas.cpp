#include "hal/sim/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;

/// From linear light to a byte's range, by the root that toLinear squares.
float toByte(float linear) {
    return 255.0F * std::sqrt(std::clamp(linear, 0.0F, 1.0F));
}

constexpr float kNearest = 0.2F;
constexpr float kTogether = 0.98F;  ///< Samples whose depths differ by less show one surface.
constexpr float kFixed = 65536.0F;

}  // namespace

PixelBox PixelBox::grown(int by, int width, int height) const {
    if (empty()) return *this;
    return {std::max(0, left - by), std::max(0, top - by), std::min(width, right + by), std::min(height, bottom + by)};
}

PixelBox PixelBox::joined(const PixelBox& other) const {
    if (empty()) return other;
    if (other.empty()) return *this;
    return {std::min(left, other.left), std::min(top, other.top), std::max(right, other.right),
            std::max(bottom, other.bottom)};
}

Canvas::Canvas(int width, int height)
    : width_(width), height_(height), nearness_(offset(sampleHeight()), 0.0F), paint_(offset(sampleHeight()), 0) {}

void Canvas::clear(const PixelBox& box) {
    if (box.empty()) return;
    for (int y = kSamplesAcross * box.top; y < kSamplesAcross * box.bottom; ++y) {
        float* row = &nearness_[offset(y)];
        std::fill(row + kSamplesAcross * box.left, row + kSamplesAcross * box.right, 0.0F);
    }
}

void Canvas::put(int sampleX, int sampleY, float nearness, Paint what) {
    const std::size_t at = offset(sampleY) + static_cast<std::size_t>(sampleX);
    nearness_[at] = nearness;
    paint_[at] = what;
}

Canvas::Pixel Canvas::pixel(int x, int y) const {
    const float* upper = nearnessRow(kSamplesAcross * y) + kSamplesAcross * x;
    const float* lower = nearnessRow(kSamplesAcross * y + 1) + kSamplesAcross * x;
    const std::array<float, 4> samples = {upper[0], upper[1], lower[0], lower[1]};
    const std::size_t nearest =
        static_cast<std::size_t>(std::max_element(samples.begin(), samples.end()) - samples.begin());
    if (!(samples[nearest] > 0.0F)) return {};
    Pixel result;
    result.nearest = paintRow(kSamplesAcross * y + static_cast<int>(nearest / 2))[kSamplesAcross * x + nearest % 2];
    const float together = kTogether * samples[nearest];
    for (const float sample : samples) {
        if (sample < together) continue;
        result.nearness += sample;
        ++result.samples;
    }
    result.nearness /= static_cast<float>(result.samples);
    return result;
}

void Canvas::draw(std::span<const CanvasVertex> vertices, const Mesh& mesh, std::uint32_t owner, bool coloured) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& [a, b, c] = mesh.triangles[i];
        const Paint colourless = paint(0, 0, 0, mesh.materials[i], owner);
        if (coloured) {
            drawTriangle<true>(vertices[a], vertices[b], vertices[c], colourless);
        } else {
            drawTriangle<false>(vertices[a], vertices[b], vertices[c], colourless);
        }
    }
}

template <bool kColoured>
void Canvas::drawTriangle(const CanvasVertex& a, const CanvasVertex& b, const CanvasVertex& c, Paint colourless) {
    // The picture's y runs down and the mirror frame is seen from its −Z side: what faces the viewer runs clockwise
    // in it.
    const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(area < 0.0F)) return;
    const float lowest = std::min({a.y, b.y, c.y});
    const float highest = std::max({a.y, b.y, c.y});
    const int top = std::max(0, static_cast<int>(std::ceil(lowest)));
    const int bottom = std::min(sampleHeight() - 1, static_cast<int>(std::floor(highest)));
    if (top > bottom) return;
    // Many triangles of hands and faces fall between the samples.
    if (std::ceil(std::min({a.x, b.x, c.x})) > std::floor(std::max({a.x, b.x, c.x}))) return;

    const float scale = 1.0F / area;
    const auto slopes = [&](float va, float vb, float vc) {
        const float db = vb - va;
        const float dc = vc - va;
        return std::array<float, 2>{(db * (c.y - a.y) - dc * (b.y - a.y)) * scale,
                                    (dc * (b.x - a.x) - db * (c.x - a.x)) * scale};
    };
    const auto nearness = slopes(a.nearness, b.nearness, c.nearness);
    const auto red = slopes(a.r, b.r, c.r);
    const auto green = slopes(a.g, b.g, c.g);
    const auto blue = slopes(a.b, b.b, c.b);
    const float nearest = std::max({a.nearness, b.nearness, c.nearness});
    const float farthest = std::min({a.nearness, b.nearness, c.nearness});
    const std::array<const CanvasVertex*, 4> loop = {&a, &b, &c, &a};

    for (int y = top; y <= bottom; ++y) {
        const float fy = static_cast<float>(y);
        float left = 1e9F;
        float right = -1e9F;
        for (std::size_t e = 0; e < 3; ++e) {
            const CanvasVertex* upper = loop[e];
            const CanvasVertex* lower = loop[e + 1];
            // Both triangles of an edge must find the very same crossing, or cracks open between them.
            if (upper->y > lower->y) std::swap(upper, lower);
            if (fy < upper->y || fy > lower->y) continue;
            const float rise = lower->y - upper->y;
            const float x = rise > 0.0F ? upper->x + (fy - upper->y) * ((lower->x - upper->x) / rise) : upper->x;
            left = std::min(left, x);
            right = std::max(right, x);
            if (!(rise > 0.0F)) {
                left = std::min(left, lower->x);
                right = std::max(right, lower->x);
            }
        }
        const int from = std::max(0, static_cast<int>(std::ceil(left)));
        const int to = std::min(sampleWidth() - 1, static_cast<int>(std::floor(right)));
        if (from > to) continue;
        // Values are taken at both ends of the span and held to what the corners allow: slivers have slopes without
        // meaning.
        const float dy = fy - a.y;
        const float dxFrom = static_cast<float>(from) - a.x;
        const float dxTo = static_cast<float>(to) - a.x;
        const float share = to > from ? 1.0F / static_cast<float>(to - from) : 0.0F;
        const auto atNearness = [&](float dx) {
            return std::clamp(a.nearness + dx * nearness[0] + dy * nearness[1], farthest, nearest);
        };
        float near = atNearness(dxFrom);
        const float nearStep = (atNearness(dxTo) - near) * share;
        const std::size_t row = offset(y);
        if constexpr (!kColoured) {
            for (int x = from; x <= to; ++x) {
                const std::size_t at = row + static_cast<std::size_t>(x);
                if (near > nearness_[at]) {
                    nearness_[at] = near;
                    paint_[at] = colourless;
                }
                near += nearStep;
            }
            continue;
        }
        const auto span = [&](float value, const std::array<float, 2>& slope) {
            const float first = std::clamp(value + dxFrom * slope[0] + dy * slope[1], 0.0F, 255.0F);
            const float last = std::clamp(value + dxTo * slope[0] + dy * slope[1], 0.0F, 255.0F);
            return std::array<std::int32_t, 2>{static_cast<std::int32_t>(first * kFixed),
                                               static_cast<std::int32_t>((last - first) * share * kFixed)};
        };
        auto [r, stepR] = span(a.r, red);
        auto [g, stepG] = span(a.g, green);
        auto [bl, stepB] = span(a.b, blue);
        for (int x = from; x <= to; ++x) {
            const std::size_t at = row + static_cast<std::size_t>(x);
            if (near > nearness_[at]) {
                nearness_[at] = near;
                const auto byte = [](std::int32_t value) { return static_cast<std::uint32_t>(value) >> 16U & 0xffU; };
                paint_[at] = byte(r) | byte(g) << 8U | byte(bl) << 16U | colourless;
            }
            near += nearStep;
            r += stepR;
            g += stepG;
            bl += stepB;
        }
    }
}

PixelBox light(const View& view, const Mesh& mesh, std::span<const Vector3f> positions,
               std::span<const Vector3f> normals, std::span<CanvasVertex> vertices, bool coloured) {
    // A large soft window light from the upper left of the glass, a weaker one from the other side, and what walls and
    // floor throw back.
    const Vector3f key = Vector3f(-0.45F, 0.62F, -0.64F).normalized();
    const Vector3f fill = Vector3f(0.75F, 0.25F, -0.60F).normalized();
    const Vector3f keyColour(0.60F, 0.585F, 0.55F);
    const Vector3f fillColour(0.17F, 0.18F, 0.20F);
    const Vector3f above(0.40F, 0.405F, 0.41F);
    const Vector3f below(0.235F, 0.215F, 0.19F);
    const Intrinsics& lens = view.intrinsics();
    float minX = 1e9F;
    float minY = 1e9F;
    float maxX = -1e9F;
    float maxY = -1e9F;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Vector3f seen = view.toSensor(positions[i]);
        if (seen.z() < kNearest) return {};
        const float inverse = 1.0F / seen.z();
        CanvasVertex& vertex = vertices[i];
        vertex.x = kSamplesAcross * (lens.cx + lens.fx * seen.x() * inverse + 0.5F) - 0.5F;
        vertex.y = kSamplesAcross * (lens.cy - lens.fy * seen.y() * inverse + 0.5F) - 0.5F;
        vertex.nearness = inverse;
        if (coloured) {
            const Vector3f& n = normals[i];
            const Vector3f toEye = (view.place() - positions[i]).normalized();
            // Wrapped around the terminator, as a large light does.
            const float keyed = std::max(0.0F, (n.dot(key) + 0.25F) * 0.8F);
            const float filled = std::max(0.0F, n.dot(fill));
            const float up = 0.5F + 0.5F * n.y();
            const float facing = std::max(0.0F, n.dot(toEye));
            const float rim = 0.80F + 0.20F * std::sqrt(facing);
            const Vector3f light = rim * (keyed * keyColour + filled * fillColour + up * above + (1.0F - up) * below);
            const Vector3f colour = mesh.albedo[i].cwiseProduct(light);
            vertex.r = toByte(colour.x());
            vertex.g = toByte(colour.y());
            vertex.b = toByte(colour.z());
        }
        minX = std::min(minX, vertex.x);
        minY = std::min(minY, vertex.y);
        maxX = std::max(maxX, vertex.x);
        maxY = std::max(maxY, vertex.y);
    }
    const auto pixel = [](float sample) {
        return static_cast<int>(std::floor(std::clamp(sample, -1e5F, 1e5F) / kSamplesAcross));
    };
    return PixelBox{pixel(minX), pixel(minY), pixel(maxX) + 1, pixel(maxY) + 1}.grown(1, lens.width, lens.height);
}

}  // namespace cheval::hal::sim

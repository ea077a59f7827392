#include "render/depth_shading.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cheval::render {
namespace {

constexpr int kRadius = 2;
/// A reading that moved less than this is the same surface seen again.
constexpr float kStillMetres = 0.05F;
constexpr float kFreshness = 0.4F;
/// A pixel without a reading counts as "not the shopper" by this much: it closes holes in a shirt without letting the
/// outline swell into an empty background.
constexpr float kHoleWeight = 0.45F;

float smoothStep(float from, float to, float value) {
    const float t = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
    return t * t * (3.0F - 2.0F * t);
}

std::uint8_t byte(float value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F));
}

}  // namespace

hal::ImageView<const hal::Rgb8> DepthShading::shade(const CameraPicture& camera, const MirrorMapping& mapping,
                                                    int displayWidth, int displayHeight) {
    if (camera.depth.width != width_ || camera.depth.height != height_) {
        width_ = camera.depth.width;
        height_ = camera.depth.height;
        const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
        picture_.resize(width_, height_);
        steady_.assign(pixels, 0.0F);
        person_.assign(pixels, 0);
        for (auto* values : {&personDepth_, &personWeight_, &sceneDepth_, &sceneWeight_, &scratch_})
            values->assign(pixels, 0.0F);
        column_.assign(static_cast<std::size_t>(std::max(width_, height_)), 0.0F);
    }
    const auto corner = [&](float x, float y) {
        const int column = static_cast<int>(mapping.cropLeft + x / mapping.scale);
        const int row = static_cast<int>(mapping.cropTop + y / mapping.scale);
        return mapping.sensorPixel(std::clamp(column, 0, mapping.mirroredWidth() - 1),
                                   std::clamp(row, 0, mapping.mirroredHeight() - 1));
    };
    const Eigen::Vector2i a = corner(0.0F, 0.0F);
    const Eigen::Vector2i b = corner(static_cast<float>(displayWidth), static_cast<float>(displayHeight));
    constexpr int kRim = 4;
    Region region{.x0 = std::max(std::min(a.x(), b.x()) - kRim, 0), .y0 = std::max(std::min(a.y(), b.y()) - kRim, 0)};
    region.width = std::min(std::max(a.x(), b.x()) + kRim + 1, width_) - region.x0;
    region.height = std::min(std::max(a.y(), b.y()) + kRim + 1, height_) - region.y0;

    steady(camera, region);
    blur(region, true, personDepth_, personWeight_);
    blur(region, false, sceneDepth_, sceneWeight_);
    light(camera, mapping, region);
    return picture_.view();
}

void DepthShading::steady(const CameraPicture& camera, const Region& region) {
    const bool knowsUser = !camera.userMap.empty() && camera.userLabel != 0 && camera.userMap.width == width_ &&
                           camera.userMap.height == height_;
    for (int y = 0; y < region.height; ++y) {
        const std::uint16_t* depth = camera.depth.row(region.y0 + y) + region.x0;
        const std::uint8_t* map = knowsUser ? camera.userMap.row(region.y0 + y) + region.x0 : nullptr;
        float* before = steady_.data() + static_cast<std::ptrdiff_t>(region.y0 + y) * width_ + region.x0;
        std::uint8_t* person = person_.data() + static_cast<std::ptrdiff_t>(y) * region.width;
        for (int x = 0; x < region.width; ++x) {
            const float now = static_cast<float>(depth[x]) * 1e-3F;
            const bool still = depth[x] != 0 && std::abs(now - before[x]) < kStillMetres;
            before[x] = still ? before[x] + (now - before[x]) * kFreshness : now;
            person[x] = map != nullptr && map[x] == camera.userLabel ? 1 : 0;
        }
    }
}

void DepthShading::boxBlur(const Region& region, std::vector<float>& values) {
    const int width = region.width;
    const int height = region.height;
    // Along rows, then along columns with one running sum a column, so that memory is walked in order.
    for (int y = 0; y < height; ++y) {
        const float* from = values.data() + static_cast<std::ptrdiff_t>(y) * width;
        float* to = scratch_.data() + static_cast<std::ptrdiff_t>(y) * width;
        for (int x = 0; x < width; ++x) {
            if (x >= kRadius && x < width - kRadius) {
                to[x] = from[x - 2] + from[x - 1] + from[x] + from[x + 1] + from[x + 2];
                continue;
            }
            float sum = 0.0F;
            for (int each = std::max(x - kRadius, 0); each <= std::min(x + kRadius, width - 1); ++each)
                sum += from[each];
            to[x] = sum;
        }
    }
    constexpr float kNormal = 1.0F / ((2 * kRadius + 1) * (2 * kRadius + 1));
    for (int y = 0; y < height; ++y) {
        float* to = values.data() + static_cast<std::ptrdiff_t>(y) * width;
        std::fill(to, to + width, 0.0F);
        for (int each = std::max(y - kRadius, 0); each <= std::min(y + kRadius, height - 1); ++each) {
            const float* from = scratch_.data() + static_cast<std::ptrdiff_t>(each) * width;
            for (int x = 0; x < width; ++x)
                to[x] += from[x];
        }
        for (int x = 0; x < width; ++x)
            to[x] *= kNormal;
    }
}

void DepthShading::blur(const Region& region, bool person, std::vector<float>& depth, std::vector<float>& weight) {
    for (int y = 0; y < region.height; ++y) {
        const float* from = steady_.data() + static_cast<std::ptrdiff_t>(region.y0 + y) * width_ + region.x0;
        const auto row = static_cast<std::ptrdiff_t>(y) * region.width;
        for (int x = 0; x < region.width; ++x) {
            const bool counts = from[x] > 0.0F && (person_[static_cast<std::size_t>(row + x)] != 0) == person;
            depth[static_cast<std::size_t>(row + x)] = counts ? from[x] : 0.0F;
            weight[static_cast<std::size_t>(row + x)] = counts ? 1.0F : 0.0F;
        }
    }
    // Two boxes make nearly a Gaussian of 2 pixels (D10's clean-up, with holes filled from their neighbours).
    for (int pass = 0; pass < 2; ++pass) {
        boxBlur(region, depth);
        boxBlur(region, weight);
    }
}

void DepthShading::light(const CameraPicture& camera, const MirrorMapping& mapping, const Region& region) {
    // Slopes are turned to the display's axes, so that light falls from the same side however the sensor hangs.
    const Eigen::Matrix2f turn = mapping.displayFromSensor().topLeftCorner<2, 2>() / mapping.scale;
    const Eigen::Vector3f key = Eigen::Vector3f(-0.45F, 0.62F, 0.64F).normalized();
    const Eigen::Vector3f fill = Eigen::Vector3f(0.8F, 0.05F, 0.6F).normalized();
    const auto width = static_cast<std::size_t>(region.width);
    const auto normalAt = [&](const std::vector<float>& depth, const std::vector<float>& weight, int x, int y,
                              float z) -> Eigen::Vector3f {
        const auto value = [&](int column, int row) {
            const auto i = static_cast<std::size_t>(std::clamp(row, 0, region.height - 1)) * width +
                           static_cast<std::size_t>(std::clamp(column, 0, region.width - 1));
            return weight[i] > 0.02F ? depth[i] / weight[i] : z;
        };
        const float perPixel = 0.5F / z;
        const Eigen::Vector2f slope(
            std::clamp((value(x + 1, y) - value(x - 1, y)) * camera.intrinsics.fx * perPixel, -2.5F, 2.5F),
            std::clamp((value(x, y + 1) - value(x, y - 1)) * camera.intrinsics.fy * perPixel, -2.5F, 2.5F));
        const Eigen::Vector2f onDisplay = turn * slope;
        // Display x right, y up, z towards the viewer.
        return Eigen::Vector3f(onDisplay.x(), -onDisplay.y(), 1.0F).normalized();
    };
    for (int y = 0; y < region.height; ++y) {
        hal::Rgb8* out = picture_.view().row(region.y0 + y) + region.x0;
        for (int x = 0; x < region.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
            const float person = personWeight_[i];
            const float scene = sceneWeight_[i];
            const float known = person + scene + kHoleWeight * (1.0F - person - scene);
            const float alpha = person > 0.02F ? smoothStep(0.42F, 0.68F, person / known) : 0.0F;
            Eigen::Array3f colour(17.0F, 19.0F, 24.0F);
            if (alpha < 1.0F && scene > 0.02F) {
                const float z = sceneDepth_[i] / scene;
                const Eigen::Vector3f normal = normalAt(sceneDepth_, sceneWeight_, x, y, z);
                const float lit = 0.35F + 0.65F * std::max(normal.dot(key), 0.0F);
                const float fade = std::clamp(1.25F - z * 0.22F, 0.2F, 1.0F) * std::min(scene * 1.4F, 1.0F);
                colour += Eigen::Array3f(30.0F, 34.0F, 42.0F) * (lit * fade);
            }
            if (alpha > 0.0F) {
                const float z = personDepth_[i] / person;
                const Eigen::Vector3f normal = normalAt(personDepth_, personWeight_, x, y, z);
                const float wrapped = std::max((normal.dot(key) + 0.35F) / 1.35F, 0.0F);
                const float second = std::max(normal.dot(fill), 0.0F);
                const float facing = 0.55F + 0.45F * normal.z();
                const Eigen::Array3f lit =
                    facing * (Eigen::Array3f(74.0F, 62.0F, 57.0F) + Eigen::Array3f(150.0F, 128.0F, 108.0F) * wrapped +
                              Eigen::Array3f(14.0F, 20.0F, 28.0F) * second);
                colour += (lit - colour) * alpha;
            }
            out[x] = {byte(colour.x()), byte(colour.y()), byte(colour.z())};
        }
    }
}

}  // namespace cheval::render

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
constexpr float kHoleWeight = 0.4F;
/// Farther than this from the shopper around it, a reading of theirs is a misread edge.
constexpr float kMisreadMetres = 0.3F;
/// Reach of one smoothing pass along a row or column, in pixels, and how often both are gone through.
constexpr int kReach = 4;
constexpr int kPasses = 2;

/// Steps beyond this part surfaces from one another; less is noise, which grows with the distance's square
/// (Khoshelham & Elberink 2012: 15 mm at 3 m).
float surfaceStep(float metres) {
    return 0.035F + 0.008F * metres * metres;
}

float smoothStep(float from, float to, float value) {
    const float t = std::clamp((value - from) / (to - from), 0.0F, 1.0F);
    return t * t * (3.0F - 2.0F * t);
}

/// Adds to each sum its neighbour's depth where that is the same surface. The four rows never overlap, which lets the
/// compiler take several pixels at a time.
void gather(const float* __restrict__ from, const float* __restrict__ neighbour, float* __restrict__ sum,
            float* __restrict__ weight, int count) {
    for (int x = 0; x < count; ++x) {
        const float here = from[x];
        const float there = neighbour[x];
        const float same = std::abs(there - here) < surfaceStep(here) ? 1.0F : 0.0F;
        sum[x] += same * there;
        weight[x] += same;
    }
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
        for (auto* values : {&person_, &personDepth_, &scene_, &depth_, &alpha_, &scratch_, &weight_})
            values->assign(pixels, 0.0F);
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
    // Two boxes make nearly a Gaussian of 2 pixels (D10's clean-up).
    for (auto* values : {&person_, &personDepth_, &scene_}) {
        boxBlur(region, *values);
        boxBlur(region, *values);
    }
    repair(region);
    for (int pass = 0; pass < kPasses; ++pass)
        flatten(region);
    light(camera, mapping, region);
    return picture_.view();
}

void DepthShading::steady(const CameraPicture& camera, const Region& region) {
    const bool knowsUser = !camera.userMap.empty() && camera.userLabel != 0;
    for (int y = 0; y < region.height; ++y) {
        const std::uint16_t* depth = camera.depth.row(region.y0 + y) + region.x0;
        const std::uint8_t* map = knowsUser ? camera.userMap.row(region.y0 + y) + region.x0 : nullptr;
        float* before = steady_.data() + static_cast<std::ptrdiff_t>(region.y0 + y) * width_ + region.x0;
        const auto row = static_cast<std::ptrdiff_t>(y) * region.width;
        for (int x = 0; x < region.width; ++x) {
            const float now = static_cast<float>(depth[x]) * 1e-3F;
            const bool still = depth[x] != 0 && std::abs(now - before[x]) < kStillMetres;
            before[x] = still ? before[x] + (now - before[x]) * kFreshness : now;
            const bool person = depth[x] != 0 && map != nullptr && map[x] == camera.userLabel;
            const auto i = static_cast<std::size_t>(row + x);
            person_[i] = person ? 1.0F : 0.0F;
            personDepth_[i] = person ? before[x] : 0.0F;
            scene_[i] = depth[x] != 0 && !person ? 1.0F : 0.0F;
            depth_[i] = before[x];
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

void DepthShading::repair(const Region& region) {
    const auto pixels = static_cast<std::size_t>(region.width) * static_cast<std::size_t>(region.height);
    for (std::size_t i = 0; i < pixels; ++i) {
        const float person = person_[i];
        alpha_[i] = 0.0F;
        if (person < 0.02F) continue;
        const float known = person + scene_[i] + kHoleWeight * (1.0F - person - scene_[i]);
        alpha_[i] = smoothStep(0.42F, 0.68F, person / known);
        if (alpha_[i] <= 0.0F) continue;
        // What belongs to the shopper but was not read, or was read on the wall behind, lies where they are around it.
        const float around = personDepth_[i] / person;
        if (std::abs(depth_[i] - around) > kMisreadMetres) depth_[i] = around;
    }
}

void DepthShading::flatten(const Region& region) {
    // A mean along rows, then along columns, over what belongs to the same surface: noise goes, steps stay. Rows are
    // walked whole for each neighbour, so that the compiler takes several pixels at a time.
    const int width = region.width;
    const int height = region.height;
    const auto at = [width](std::vector<float>& values, int y) {
        return values.data() + static_cast<std::ptrdiff_t>(y) * width;
    };
    for (int y = 0; y < height; ++y) {
        const float* from = at(depth_, y);
        float* sum = at(scratch_, y);
        float* weight = at(weight_, y);
        std::copy(from, from + width, sum);
        std::fill(weight, weight + width, 1.0F);
        for (int step = 1; step <= kReach && step < width; ++step) {
            gather(from, from + step, sum, weight, width - step);
            gather(from + step, from, sum + step, weight + step, width - step);
        }
        for (int x = 0; x < width; ++x)
            sum[x] /= weight[x];
    }
    for (int y = 0; y < height; ++y) {
        const float* from = at(scratch_, y);
        float* sum = at(depth_, y);
        float* weight = at(weight_, y);
        std::copy(from, from + width, sum);
        std::fill(weight, weight + width, 1.0F);
        for (int each = std::max(y - kReach, 0); each <= std::min(y + kReach, height - 1); ++each) {
            if (each != y) gather(from, at(scratch_, each), sum, weight, width);
        }
        for (int x = 0; x < width; ++x)
            sum[x] /= weight[x];
    }
}

void DepthShading::light(const CameraPicture& camera, const MirrorMapping& mapping, const Region& region) {
    // Slopes are turned to the display's axes, so that light falls from the same side however the sensor hangs.
    const Eigen::Matrix2f turn = mapping.displayFromSensor().topLeftCorner<2, 2>() / mapping.scale;
    const Eigen::Vector3f key = Eigen::Vector3f(-0.5F, 0.6F, 0.62F).normalized();
    const Eigen::Vector3f fill = Eigen::Vector3f(0.8F, 0.05F, 0.6F).normalized();
    const int width = region.width;
    constexpr int kSpan = 2;
    // Metres a pixel along one axis: the mean of both sides, or the side that is the same surface.
    const auto slope = [](float before, float here, float after, int stepsBefore, int stepsAfter) {
        const float limit = surfaceStep(here);
        const bool usesBefore = stepsBefore > 0 && std::abs(here - before) < limit;
        const bool usesAfter = stepsAfter > 0 && std::abs(after - here) < limit;
        if (!usesBefore && !usesAfter) return 0.0F;
        const float from = usesBefore ? before : here;
        const float to = usesAfter ? after : here;
        return (to - from) / static_cast<float>((usesBefore ? stepsBefore : 0) + (usesAfter ? stepsAfter : 0));
    };
    for (int y = 0; y < region.height; ++y) {
        hal::Rgb8* out = picture_.view().row(region.y0 + y) + region.x0;
        const float* here = depth_.data() + static_cast<std::ptrdiff_t>(y) * width;
        const int up = std::min(kSpan, y);
        const int down = std::min(kSpan, region.height - 1 - y);
        const float* above = here - static_cast<std::ptrdiff_t>(up) * width;
        const float* below = here + static_cast<std::ptrdiff_t>(down) * width;
        const float* alphas = alpha_.data() + static_cast<std::ptrdiff_t>(y) * width;
        for (int x = 0; x < width; ++x) {
            const float z = here[x];
            const float alpha = alphas[x];
            Eigen::Array3f colour(17.0F, 19.0F, 24.0F);
            if (z <= 0.0F) {
                // A hole in the scene takes what surrounds it, in the mean.
                colour += Eigen::Array3f(13.0F, 15.0F, 19.0F) *
                          std::min(scene_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                          static_cast<std::size_t>(x)] *
                                       1.5F,
                                   1.0F);
            } else {
                const int left = std::min(kSpan, x);
                const int right = std::min(kSpan, width - 1 - x);
                const Eigen::Vector2f slopes(
                    slope(here[x - left], z, here[x + right], left, right) * camera.intrinsics.fx / z,
                    slope(above[x], z, below[x], up, down) * camera.intrinsics.fy / z);
                // Steeper than this is a ragged edge, not a form.
                const Eigen::Vector2f onDisplay = (turn * slopes).cwiseMax(-1.4F).cwiseMin(1.4F);
                // Display x right, y up, z towards the viewer.
                const Eigen::Vector3f normal = Eigen::Vector3f(onDisplay.x(), -onDisplay.y(), 1.0F).normalized();
                if (alpha < 1.0F) {
                    const float lit = 0.7F + 0.3F * std::max(normal.dot(key), 0.0F);
                    const float fade = std::clamp(1.3F - z * 0.23F, 0.22F, 1.0F);
                    colour += Eigen::Array3f(27.0F, 31.0F, 39.0F) * (lit * fade);
                }
                if (alpha > 0.0F) {
                    const float wrapped = std::max((normal.dot(key) + 0.3F) / 1.3F, 0.0F);
                    const float second = std::max(normal.dot(fill), 0.0F);
                    const float facing = 0.5F + 0.5F * normal.z();
                    const Eigen::Array3f lit = facing * (Eigen::Array3f(64.0F, 54.0F, 51.0F) +
                                                         Eigen::Array3f(162.0F, 138.0F, 116.0F) * wrapped +
                                                         Eigen::Array3f(14.0F, 20.0F, 28.0F) * second);
                    colour += (lit - colour) * alpha;
                }
            }
            out[x] = {byte(colour.x()), byte(colour.y()), byte(colour.z())};
        }
    }
}

}  // namespace cheval::render

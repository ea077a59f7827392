#include "render/avatar_view.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cheval::render {
namespace {

/// The camera stands this far before the figure, at this height: near enough for a person's perspective, far enough
/// not to flatter.
constexpr float kDistance = 3.8F;
constexpr float kEyeHeight = 1.15F;
/// Heights at the figure that come out at the display's top and bottom edge. The carousel lies below the feet.
constexpr float kTop = 2.14F;
constexpr float kBottom = -0.70F;
constexpr double kFollowSeconds = 0.5;
constexpr double kGapSeconds = 1.0;

}  // namespace

Projection AvatarView::follow(const fitting::Skeleton& skeleton) {
    if (skeleton.present()) {
        const Eigen::Vector3f torso = skeleton[fitting::Joint::torso].position;
        const Eigen::Vector2f now(torso.x(), torso.z());
        const double gap = hal::seconds(skeleton.captureTime - lastTime_);
        if (now.allFinite()) {
            const bool jump = !followed_ || gap < 0.0 || gap > kGapSeconds;
            root_ += (now - root_) * (jump ? 1.0F : static_cast<float>(1.0 - std::exp(-gap / kFollowSeconds)));
            followed_ = true;
            lastTime_ = skeleton.captureTime;
        }
    }
    const auto width = static_cast<float>(width_);
    const auto height = static_cast<float>(height_);
    const float focal = height * kDistance / (kTop - kBottom);
    const float horizon = focal * (kTop - kEyeHeight) / kDistance;
    Projection projection;
    // The camera looks along +Z. A mirror shows +X at the right, where a camera would show it at the left.
    const float eyeX = root_.x();
    const float eyeZ = root_.y() - kDistance;
    projection.row(0) << focal, 0, width / 2.0F, -focal * eyeX - width / 2.0F * eyeZ;
    projection.row(1) << 0, -focal, horizon, focal * kEyeHeight - horizon * eyeZ;
    projection.row(2) << 0, 0, 1, -eyeZ;
    return projection;
}

void AvatarView::paintBackdrop() {
    backdrop_.resize(width_, height_);
    const auto width = static_cast<float>(width_);
    const auto height = static_cast<float>(height_);
    std::uint32_t noise = 1;
    for (int y = 0; y < height_; ++y) {
        const float v = (static_cast<float>(y) + 0.5F) / height;
        // A seamless paper roll: the wall runs into the floor in a wide curve at about knee height.
        const float floor = std::clamp((v - 0.62F) / 0.2F, 0.0F, 1.0F);
        const float bend = floor * floor * (3.0F - 2.0F * floor);
        for (int x = 0; x < width_; ++x) {
            const float u = (static_cast<float>(x) + 0.5F) / width - 0.5F;
            const float glow = std::exp(-(u * u * 3.2F + (v - 0.4F) * (v - 0.4F) * 3.0F));
            const float wall = 0.50F + 0.33F * glow;
            const float ground = 0.80F - 0.30F * u * u - 0.16F * std::max(v - 0.82F, 0.0F) / 0.18F;
            const float value = (wall + (ground - wall) * bend) * 255.0F;
            // A little noise, or the gradient shows steps on a large display.
            noise = noise * 1664525U + 1013904223U;
            const float dither = static_cast<float>(noise >> 24U) / 255.0F;
            const auto tint = [&](float factor) {
                return static_cast<std::uint8_t>(std::clamp(value * factor + dither, 0.0F, 255.0F));
            };
            backdrop_.view().at(x, y) = {tint(1.0F), tint(0.985F), tint(0.965F), 255};
        }
    }
}

void AvatarView::shadow(const Projection& projection, const Eigen::Vector3f& centre, const Eigen::Vector2f& radii,
                        float depth, hal::ImageView<hal::Rgba8> target) const {
    constexpr float kReach = 1.0F;
    const Eigen::Vector2f middle = projectPoint(projection, centre);
    const Eigen::Vector2f right = projectPoint(projection, centre + Eigen::Vector3f(radii.x(), 0, 0));
    const Eigen::Vector2f near = projectPoint(projection, centre - Eigen::Vector3f(0, 0, radii.y()));
    const float radiusX = right.x() - middle.x();
    const float radiusY = near.y() - middle.y();
    if (!(radiusX > 1.0F) || !(radiusY > 1.0F) || radiusX > static_cast<float>(width_)) return;
    const auto bound = [](float value, int limit) {
        return static_cast<int>(std::clamp(value, 0.0F, static_cast<float>(limit)));
    };
    const int x0 = bound(middle.x() - radiusX * kReach, width_);
    const int x1 = bound(middle.x() + radiusX * kReach + 1.0F, width_);
    const int y0 = bound(middle.y() - radiusY * kReach, height_);
    const int y1 = bound(middle.y() + radiusY * kReach + 1.0F, height_);
    for (int y = y0; y < y1; ++y) {
        const float dy = (static_cast<float>(y) + 0.5F - middle.y()) / radiusY;
        hal::Rgba8* row = target.row(y);
        for (int x = x0; x < x1; ++x) {
            const float dx = (static_cast<float>(x) + 0.5F - middle.x()) / radiusX;
            const float rest = std::max(1.0F - dx * dx - dy * dy, 0.0F);
            const auto keep = static_cast<unsigned>(256.0F * (1.0F - depth * rest * rest));
            row[x].r = static_cast<std::uint8_t>(row[x].r * keep >> 8U);
            row[x].g = static_cast<std::uint8_t>(row[x].g * keep >> 8U);
            row[x].b = static_cast<std::uint8_t>(row[x].b * keep >> 8U);
        }
    }
}

void AvatarView::draw(const Projection& projection, const fitting::Skeleton& skeleton, bool figure,
                      hal::ImageView<hal::Rgba8> target) {
    for (int y = 0; y < height_; ++y)
        std::memcpy(target.row(y), backdrop_.view().row(y), static_cast<std::size_t>(width_) * sizeof(hal::Rgba8));
    if (!figure || !skeleton.present()) return;
    Eigen::Vector3f under(root_.x(), 0.0F, root_.y());
    shadow(projection, under, {0.62F, 0.42F}, 0.34F, target);
    for (const fitting::Joint joint : {fitting::Joint::leftFoot, fitting::Joint::rightFoot}) {
        const Eigen::Vector3f foot = skeleton[joint].position;
        if (!foot.allFinite()) continue;
        // A lifted foot throws a weaker shadow.
        const float touch = std::clamp(1.0F - (foot.y() - 0.12F) * 3.0F, 0.0F, 1.0F);
        shadow(projection, {foot.x(), 0.0F, foot.z() - 0.06F}, {0.13F, 0.2F}, 0.42F * touch, target);
    }
}

}  // namespace cheval::render

#include "hal/sim/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "hal/sim/figure.h"
#include "hal/sim/hash.h"
#include "hal/sim/rounding.h"

namespace cheval::hal::sim {

namespace {

using Eigen::Vector3f;
using fitting::Side;

/// Pixels around a person that their shadow and edges change: the disparity of someone 1 m from the sensor, less the
/// wall's, and the reach of the edge test.
constexpr int kSensorReach = 40;

}  // namespace

Scene::Scene(const WorldOptions& options, const View& view, const Room& room)
    : options_(options),
      view_(view),
      room_(room),
      canvas_(view.intrinsics().width, view.intrinsics().height),
      sensor_(view.intrinsics(), room, scramble(options.seed, 0x5e75U), options.noiseScale),
      figures_(figuresOf(options.script)),
      depth_(room.depth),
      material_(room.material) {
    for (Figure& figure : figures_) {
        figure.mesh.reserve(kMaximumFigureVertices, kMaximumFigureTriangles);
        figure.positions.reserve(kMaximumFigureVertices);
        figure.normals.reserve(kMaximumFigureVertices);
        figure.vertices.reserve(kMaximumFigureVertices);
    }
    owner_.resize(view.intrinsics().width, view.intrinsics().height);
}

ExactView Scene::exact() const {
    return {.depth = depth_.view(), .owner = owner_.view()};
}

void Scene::prepare(std::uint32_t visit) {
    if (prepared_ && visit_ == visit) return;
    castVisit(options_, visit, cast_);
    for (std::size_t i = 0; i < cast_.performers.size(); ++i) {
        const Performer& performer = cast_.performers.view()[i];
        Figure& figure = figures_[i];
        figure.rig = rigOf(performer);
        if (performer.kind == FigureKind::dog) {
            buildDog(performer.dog, figure.rig, figure.mesh);
        } else {
            buildFigure(performer.shopper, figure.rig, figure.mesh);
        }
        figure.positions.resize(figure.mesh.positions.size());
        figure.normals.resize(figure.mesh.positions.size());
        figure.vertices.resize(figure.mesh.positions.size());
    }
    prepared_ = true;
    visit_ = visit;
}

void Scene::pose(Figure& figure, double seconds) {
    for (std::size_t i = 0; i < figure.positions.size(); ++i) {
        const Hold& hold = figure.mesh.holds[i];
        const Vector3f& p = figure.mesh.positions[i];
        const Vector3f& n = figure.mesh.normals[i];
        if (hold.share <= 0.0F || hold.first == hold.second) {
            figure.positions[i] = figure.pose.apply(figure.rig, hold.first, p);
            figure.normals[i] = figure.pose.rotation[hold.first] * n;
        } else {
            const float share = hold.share;
            figure.positions[i] = (1.0F - share) * figure.pose.apply(figure.rig, hold.first, p) +
                                  share * figure.pose.apply(figure.rig, hold.second, p);
            figure.normals[i] = ((1.0F - share) * (figure.pose.rotation[hold.first] * n) +
                                 share * (figure.pose.rotation[hold.second] * n))
                                    .normalized();
        }
    }
    // Cloth that hangs shifts and folds anew as its wearer moves and turns, and a little by itself.
    const Eigen::Matrix3f& facing = figure.pose.rotation[bone(Bone::pelvis)];
    const Vector3f& place = figure.pose.position[bone(Bone::pelvis)];
    const float drive = 2.0F * std::atan2(facing(0, 2), facing(2, 2)) + 6.0F * (place.x() + place.z()) +
                        0.5F * std::sin(0.8F * static_cast<float>(seconds));
    for (const Fold& fold : figure.mesh.folds) {
        const float sway = fold.angle + drive;
        const float wide = 4.0F * fold.angle + fold.phase - 2.0F * drive;
        const float narrow = 7.0F * fold.angle + 2.0F * fold.phase + 3.0F * drive;
        const float out = 0.45F * std::sin(sway) + 0.35F * std::sin(wide) + 0.20F * std::sin(narrow);
        const float slope = 0.45F * std::cos(sway) + 1.4F * std::cos(wide) + 1.4F * std::cos(narrow);
        const float across = std::cos(fold.angle);
        const float ahead = std::sin(fold.angle);
        const Hold& hold = figure.mesh.holds[fold.vertex];
        const Eigen::Matrix3f& rotation = figure.pose.rotation[hold.first];
        figure.positions[fold.vertex] += rotation * Vector3f(fold.reach * out * across, 0.0F, fold.reach * out * ahead);
        // About 0.15 m from the body's axis a fold's slope turns the light by this much.
        Vector3f& normal = figure.normals[fold.vertex];
        const float tilt = fold.reach * slope / 0.15F;
        normal = (normal + rotation * Vector3f(tilt * ahead, 0.0F, -tilt * across)).normalized();
    }
}

PixelBox Scene::draw(const Moment& moment, std::size_t which) {
    const Performer& performer = cast_.performers.view()[which];
    if (!inRoom(cast_, performer, moment)) return {};
    Figure& figure = figures_[which];
    figure.pose = poseOf(cast_, performer, figure.rig, moment);
    pose(figure, moment.seconds);
    const PixelBox box = light(view_, figure.mesh, figure.positions, figure.normals, figure.vertices, options_.colour);
    if (!box.empty())
        canvas_.draw(figure.vertices, figure.mesh, static_cast<std::uint32_t>(which) + 1, options_.colour);
    return box;
}

/// What feet and body take from the floor's light: a tight dark spot under each sole, a wide soft one under the body.
void Scene::castShadows(const Performer& performer, const Figure& figure, ImageView<Rgb8> colour) const {
    // A dog's are too faint to tell.
    if (performer.kind == FigureKind::dog) return;
    struct Spot {
        float x, z, tight, strength;
    };
    std::array<Spot, 6> spots{};
    std::size_t count = 0;
    for (const Side side : {Side::left, Side::right}) {
        const std::size_t foot = bone(side, SideBone::foot);
        const Vector3f ankle = figure.pose.position[foot];
        const float size = 0.055F * performer.shopper.stature;
        for (const float ahead : {-0.010F, 0.065F}) {
            const Vector3f point = figure.pose.apply(
                figure.rig, foot, figure.rig.rest[foot] + performer.shopper.stature * Vector3f(0.0F, -0.045F, ahead));
            const float height = std::max(0.0F, point.y() - 0.01F);
            spots[count++] = {point.x(), point.z(), 1.0F / (size * size * (1.0F + 30.0F * height)),
                              0.46F / (1.0F + 12.0F * height)};
        }
        // Light comes from the glass: the body's shade falls away from it.
        spots[count++] = {0.5F * (ankle.x() + figure.pose.position[0].x()), ankle.z() + 0.16F, 1.0F / 0.075F, 0.20F};
    }
    // The rectangle of pixels that sees the floor near the feet.
    const Intrinsics& lens = view_.intrinsics();
    float minX = 1e9F, minY = 1e9F, maxX = -1e9F, maxY = -1e9F;
    for (const Spot& spot : spots) {
        for (const float dx : {-0.6F, 0.6F}) {
            for (const float dz : {-0.6F, 0.6F}) {
                const Vector3f seen = view_.toSensor(Vector3f(spot.x + dx, 0.0F, spot.z + dz));
                if (seen.z() < 0.3F) continue;
                const auto at = view_.project(seen);
                minX = std::min(minX, at.x());
                maxX = std::max(maxX, at.x());
                minY = std::min(minY, at.y());
                maxY = std::max(maxY, at.y());
            }
        }
    }
    const auto within = [](float value, int limit) {
        return static_cast<int>(std::clamp(value, 0.0F, static_cast<float>(limit)));
    };
    for (int y = within(minY, lens.height); y < within(maxY, lens.height); ++y) {
        for (int x = within(minX, lens.width); x < within(maxX, lens.width); ++x) {
            const Vector3f ray = view_.ray(static_cast<float>(x), static_cast<float>(y));
            if (!(ray.y() < 0.0F)) continue;
            const float distance = -view_.place().y() / ray.y();
            // Only where the room shows its floor.
            if (std::abs(1000.0F * distance - room_.depth.view().at(x, y)) > 30.0F) continue;
            const Vector3f p = view_.place() + distance * ray;
            float light = 1.0F;
            for (const Spot& spot : spots) {
                const float dx = p.x() - spot.x;
                const float dz = p.z() - spot.z;
                const float fall = 1.0F + (dx * dx + dz * dz) * spot.tight;
                light *= 1.0F - spot.strength / (fall * fall);
            }
            Rgb8& pixel = colour.at(x, y);
            const auto dim = [light](std::uint8_t value) {
                return static_cast<std::uint8_t>(nearestWhole(static_cast<float>(value) * light));
            };
            pixel = {dim(pixel.r), dim(pixel.g), dim(pixel.b)};
        }
    }
}

void Scene::resolve(const PixelBox& box, ImageView<Rgb8> colour) {
    for (int y = box.top; y < box.bottom; ++y) {
        float* depthRow = depth_.view().row(y);
        Material* materialRow = material_.view().row(y);
        std::uint8_t* ownerRow = owner_.view().row(y);
        for (int x = box.left; x < box.right; ++x) {
            const Canvas::Pixel pixel = canvas_.pixel(x, y);
            if (pixel.samples == 0) continue;
            // 1/m against mm.
            const float roomNearness = depthRow[x] > 0.0F ? 1000.0F / depthRow[x] : 0.0F;
            if (pixel.nearness < roomNearness) continue;
            // A pixel belongs to what covers half of it.
            if (2 * pixel.samples >= kSamplesAcross * kSamplesAcross) {
                depthRow[x] = 1000.0F / pixel.nearness;
                materialRow[x] = materialOf(pixel.nearest);
                ownerRow[x] = ownerOf(pixel.nearest);
            }
            if (colour.empty()) continue;
            Rgb8& shown = colour.at(x, y);
            std::array<std::uint32_t, 3> sum = {2, 2, 2};
            for (int sub = 0; sub < kSamplesAcross * kSamplesAcross; ++sub) {
                const int sx = kSamplesAcross * x + sub % kSamplesAcross;
                const int sy = kSamplesAcross * y + sub / kSamplesAcross;
                if (canvas_.nearnessRow(sy)[sx] > 0.0F) {
                    const Paint sample = canvas_.paintRow(sy)[sx];
                    for (std::size_t c = 0; c < 3; ++c)
                        sum[c] += sample >> (8U * c) & 0xffU;
                } else {
                    sum[0] += shown.r;
                    sum[1] += shown.g;
                    sum[2] += shown.b;
                }
            }
            shown = {static_cast<std::uint8_t>(sum[0] / 4), static_cast<std::uint8_t>(sum[1] / 4),
                     static_cast<std::uint8_t>(sum[2] / 4)};
        }
    }
}

void Scene::render(std::uint64_t frame, double worldSeconds, ImageView<std::uint16_t> depth, ImageView<Rgb8> colour) {
    const Intrinsics& lens = view_.intrinsics();
    if (!colour.empty()) {
        for (int y = 0; y < lens.height; ++y)
            std::copy_n(room_.colour.view().row(y), lens.width, colour.row(y));
    }
    // Wipe away who was here in the frame before.
    for (int y = drawn_.top; y < drawn_.bottom; ++y) {
        const int count = std::max(0, drawn_.right - drawn_.left);
        std::copy_n(room_.depth.view().row(y) + drawn_.left, count, depth_.view().row(y) + drawn_.left);
        std::copy_n(room_.material.view().row(y) + drawn_.left, count, material_.view().row(y) + drawn_.left);
        std::fill_n(owner_.view().row(y) + drawn_.left, count, std::uint8_t{0});
    }
    canvas_.clear(drawn_);
    drawn_ = {};
    const Moment moment = momentAt(options_, worldSeconds);
    prepare(moment.visit);
    const std::span<const Performer> performers = cast_.performers.view();
    std::array<PixelBox, kMaximumFigures> boxes;
    for (std::size_t i = 0; i < performers.size(); ++i) {
        boxes[i] = draw(moment, i);
        drawn_ = drawn_.joined(boxes[i]);
    }
    for (std::size_t i = 0; i < performers.size(); ++i) {
        if (!colour.empty() && !boxes[i].empty()) castShadows(performers[i], figures_[i], colour);
    }
    if (!drawn_.empty()) resolve(drawn_, colour);
    if (options_.sensorNoise) {
        sensor_.sense(depth_, material_, drawn_.grown(kSensorReach, lens.width, lens.height), frame, depth);
        return;
    }
    for (int y = 0; y < lens.height; ++y) {
        const float* exact = depth_.view().row(y);
        std::uint16_t* row = depth.row(y);
        for (int x = 0; x < lens.width; ++x) {
            const bool inRange = exact[x] >= kNearestMm && exact[x] <= kFarthestMm;
            row[x] = inRange ? static_cast<std::uint16_t>(nearestWhole(exact[x])) : std::uint16_t{0};
        }
    }
}

}  // namespace cheval::hal::sim

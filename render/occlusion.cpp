#include "render/occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cheval::render {
namespace {

/// What is nearer than the cloth by more than this may hide it. An arm laid on the belly stands out by its own
/// thickness, 70 to 90 mm; cloth and skin differ by less than 40.
constexpr int kMarginMm = 55;
/// A belly that is rounder than the mannequin's is nearer too, but runs smoothly into what the cloth covers. An arm, a
/// chin or a bag ends in a step, of the camera's depth or of the cloth's (a collar's back against its front).
constexpr int kStepMm = 30;
/// Part of a surface's outline, in percent, that must be steps.
constexpr int kLeastSteps = 35;
/// What is nearer than the cloth by this much in the mean is in front, however it ends.
constexpr int kFarInFrontMm = 200;
/// The shopper's own chest, hip or upper arm may stand out too, where the garment fits badly; only head, forearms and
/// hands are believed to be in front. Part of a surface, in percent, that must belong to one of them.
constexpr int kLeastOfLimb = 30;
/// Generous, for hair and sleeves.
constexpr float kHeadRadiusMm = 200.0F;
constexpr float kForearmRadiusMm = 110.0F;
constexpr float kFingersMm = 120.0F;  ///< From the palm's centre on.
/// The body as tracked lies a little before or behind the body as seen; that is no occlusion. Limits to what is
/// believed.
constexpr float kLeastOffset = -0.04F;
constexpr float kGreatestOffset = 0.12F;
constexpr float kOffsetFollow = 0.25F;
/// Part of a new frame's verdict that is taken at once: a flickering edge is worse than one that is 30 ms late.
constexpr int kFreshness = 154;  // of 256
/// Half the width of the smoothing window, in cells.
constexpr int kRadius = 2;

enum Kind : std::uint8_t { kBare = 0, kHole, kUser, kNearer, kWalked, kFront };

}  // namespace

CellGrid cellGrid(const MirrorMapping& mapping, const PixelRect& rect) {
    CellGrid grid;
    if (rect.empty()) return grid;
    const int longest = std::max(mapping.mirroredWidth(), mapping.mirroredHeight());
    grid.cell = std::max((longest + kMaximumCells - 1) / kMaximumCells, 1);
    const float size = mapping.scale * static_cast<float>(grid.cell);  // Display pixels a cell.
    const float originX = mapping.cropLeft * mapping.scale;
    const float originY = mapping.cropTop * mapping.scale;
    const auto cells = [&](float from, int limit) { return std::clamp(static_cast<int>(std::floor(from)), 0, limit); };
    const int limitX = (mapping.mirroredWidth() + grid.cell - 1) / grid.cell;
    const int limitY = (mapping.mirroredHeight() + grid.cell - 1) / grid.cell;
    // One cell more on each side, for the bilinear samples at the rim.
    grid.x0 = cells((static_cast<float>(rect.x0) + originX) / size - 1.0F, limitX);
    grid.y0 = cells((static_cast<float>(rect.y0) + originY) / size - 1.0F, limitY);
    grid.columns = cells((static_cast<float>(rect.x1) + originX) / size + 2.0F, limitX) - grid.x0;
    grid.rows = cells((static_cast<float>(rect.y1) + originY) / size + 2.0F, limitY) - grid.y0;
    grid.part = {static_cast<float>(grid.x0) * size - originX, static_cast<float>(grid.y0) * size - originY,
                 static_cast<float>(grid.columns) * size, static_cast<float>(grid.rows) * size};
    return grid;
}

void Occlusion::reset() {
    std::fill(visible_.begin(), visible_.end(), std::uint8_t{255});
    std::fill(lastSeen_.begin(), lastSeen_.end(), 0U);
    frame_ = 1;
    hasOffset_ = false;
    offset_ = 0.0F;
}

void Occlusion::update(const CellGrid& grid, const MirrorMapping& mapping, const CameraPicture& camera,
                       const fitting::Skeleton& skeleton, hal::ImageView<const hal::Rgba8> distances) {
    const int columns = (mapping.mirroredWidth() + grid.cell - 1) / grid.cell;
    const int rows = (mapping.mirroredHeight() + grid.cell - 1) / grid.cell;
    if (columns != columns_ || rows != rows_ || grid.cell != cell_) {
        columns_ = columns;
        rows_ = rows;
        cell_ = grid.cell;
        const auto cells = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
        visible_.assign(cells, 255);
        lastSeen_.assign(cells, 0);
        nearer_.assign(cells, 0);
        seen_.assign(cells, 0);
        kind_.assign(cells, 0);
        surface_.assign(cells, 0);
        hidden_.assign(cells, 0);
        all_.assign(cells, 0);
        reset();
    }
    ++frame_;
    if (camera.depth.empty() || grid.empty()) return;
    placeLimbs(camera, skeleton);
    compare(grid, mapping, camera, distances);
    separate(grid, mapping);
    smooth(grid);
}

void Occlusion::compare(const CellGrid& grid, const MirrorMapping& mapping, const CameraPicture& camera,
                        hal::ImageView<const hal::Rgba8> distances) {
    constexpr int kBins = 128;
    constexpr int kBinMm = 5;
    constexpr int kLowestMm = -200;
    std::array<int, kBins> histogram{};
    int counted = 0;
    const bool knowsUser = !camera.userMap.empty() && camera.userLabel != 0;
    for (int y = 0; y < grid.rows; ++y) {
        const hal::Rgba8* distance = distances.row(y);
        for (int x = 0; x < grid.columns; ++x) {
            const auto i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(x);
            kind_[i] = kBare;
            nearer_[i] = 0;
            if (distance[x].b == 0) continue;
            const int pictureX = std::min((grid.x0 + x) * grid.cell + grid.cell / 2, mapping.mirroredWidth() - 1);
            const int pictureY = std::min((grid.y0 + y) * grid.cell + grid.cell / 2, mapping.mirroredHeight() - 1);
            const Eigen::Vector2i pixel = mapping.sensorPixel(pictureX, pictureY);
            const int seen = camera.depth.at(pixel.x(), pixel.y());
            if (seen == 0) {
                kind_[i] = kHole;
                continue;
            }
            const int cloth = distance[x].r * 256 + distance[x].g;
            nearer_[i] = static_cast<std::int16_t>(std::clamp(cloth - seen, -30000, 30000));
            // Who stands before the shopper is judged by nearness alone, further down.
            const bool user = !knowsUser || camera.userMap.at(pixel.x(), pixel.y()) == camera.userLabel;
            kind_[i] = user ? kUser : kFront;
            seen_[i] = static_cast<std::uint16_t>(seen);
            const int bin = (nearer_[i] - kLowestMm) / kBinMm;
            if (user && nearer_[i] >= kLowestMm && bin < kBins) {
                ++histogram[static_cast<std::size_t>(bin)];
                ++counted;
            }
        }
    }
    // Arms only ever add to the near side, so the body's own offset lies a little below the median.
    int below = 0;
    int bin = 0;
    while (bin < kBins - 1 && (below += histogram[static_cast<std::size_t>(bin)]) * 5 < counted * 2)
        ++bin;
    if (counted < 50) return;
    const float measured =
        std::clamp(static_cast<float>(kLowestMm + bin * kBinMm) * 1e-3F, kLeastOffset, kGreatestOffset);
    offset_ = hasOffset_ ? offset_ + (measured - offset_) * kOffsetFollow : measured;
    hasOffset_ = true;
}

void Occlusion::placeLimbs(const CameraPicture& camera, const fitting::Skeleton& skeleton) {
    using fitting::Joint;
    constexpr float kSeen = 0.5F;
    intrinsics_ = camera.intrinsics;
    knowsLimbs_ = skeleton.present();
    const auto at = [&](Joint joint) {
        knowsLimbs_ = knowsLimbs_ && skeleton[joint].confidence >= kSeen && skeleton[joint].position.allFinite();
        return camera.placement.toSensor(skeleton[joint].position);
    };
    const auto forearm = [&](Joint elbow, Joint hand) {
        const Eigen::Vector3f from = at(elbow);
        const Eigen::Vector3f to = at(hand);
        return Limb{.from = from, .to = to + kFingersMm * (to - from).normalized(), .radius = kForearmRadiusMm};
    };
    const Eigen::Vector3f head = at(Joint::head);
    limbs_ = {Limb{.from = head, .to = head, .radius = kHeadRadiusMm}, forearm(Joint::leftElbow, Joint::leftHand),
              forearm(Joint::rightElbow, Joint::rightHand)};
}

bool Occlusion::onLimb(const CellGrid& grid, const MirrorMapping& mapping, std::size_t cell) const {
    const auto columns = static_cast<std::size_t>(grid.columns);
    const int x = grid.x0 + static_cast<int>(cell % columns);
    const int y = grid.y0 + static_cast<int>(cell / columns);
    const Eigen::Vector2i pixel =
        mapping.sensorPixel(std::min(x * grid.cell + grid.cell / 2, mapping.mirroredWidth() - 1),
                            std::min(y * grid.cell + grid.cell / 2, mapping.mirroredHeight() - 1));
    const Eigen::Vector3f point = fitting::unproject(intrinsics_, static_cast<float>(pixel.x()),
                                                     static_cast<float>(pixel.y()), static_cast<float>(seen_[cell]));
    return std::any_of(limbs_.begin(), limbs_.end(), [&](const Limb& limb) {
        const Eigen::Vector3f along = limb.to - limb.from;
        const float length2 = along.squaredNorm();
        const float t = length2 > 0.0F ? std::clamp((point - limb.from).dot(along) / length2, 0.0F, 1.0F) : 0.0F;
        return (point - limb.from - t * along).squaredNorm() < limb.radius * limb.radius;
    });
}

void Occlusion::separate(const CellGrid& grid, const MirrorMapping& mapping) {
    const int limit = kMarginMm + static_cast<int>(std::lround(offset_ * 1000.0F));
    const auto cells = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
    for (std::size_t i = 0; i < cells; ++i) {
        if (kind_[i] == kUser && nearer_[i] > limit) kind_[i] = kNearer;
        // Somebody else hides the cloth by being nearer, and by nothing less.
        if (kind_[i] == kFront && nearer_[i] <= limit) kind_[i] = kUser;
    }
    for (std::size_t i = 0; i < cells; ++i) {
        if (kind_[i] != kNearer) continue;
        const bool front = standsOut(grid, mapping, i);
        for (std::size_t each = 0; each < walked_; ++each)
            kind_[surface_[each]] = front ? kFront : kUser;
    }
}

bool Occlusion::standsOut(const CellGrid& grid, const MirrorMapping& mapping, std::size_t seed) {
    const auto columns = static_cast<std::size_t>(grid.columns);
    const auto rows = static_cast<std::size_t>(grid.rows);
    std::int64_t sum = 0;
    std::size_t ofLimb = 0;
    int outline = 0;
    int steps = 0;
    walked_ = 1;
    surface_[0] = static_cast<std::uint32_t>(seed);
    kind_[seed] = kWalked;
    for (std::size_t next = 0; next < walked_; ++next) {
        const std::size_t i = surface_[next];
        sum += nearer_[i];
        if (knowsLimbs_ && onLimb(grid, mapping, i)) ++ofLimb;
        const std::size_t x = i % columns;
        const std::size_t y = i / columns;
        const auto visit = [&](std::size_t j) {
            if (kind_[j] == kBare || kind_[j] == kWalked) return;
            if (kind_[j] == kHole) {
                // Steps are where readings are lost.
                ++outline;
                ++steps;
                return;
            }
            const int seenStep = seen_[j] - seen_[i];
            if (kind_[j] == kNearer && std::abs(seenStep) < kStepMm) {
                kind_[j] = kWalked;
                surface_[walked_++] = static_cast<std::uint32_t>(j);
                return;
            }
            const int clothStep = (seen_[i] + nearer_[i]) - (seen_[j] + nearer_[j]);
            ++outline;
            if (seenStep > kStepMm || clothStep > kStepMm) ++steps;
        };
        if (x > 0) visit(i - 1);
        if (x + 1 < columns) visit(i + 1);
        if (y > 0) visit(i - columns);
        if (y + 1 < rows) visit(i + columns);
    }
    if (sum > static_cast<std::int64_t>(walked_) * kFarInFrontMm) return true;
    if (knowsLimbs_ && ofLimb * 100 < walked_ * kLeastOfLimb) return false;
    return outline > 0 && steps * 100 >= outline * kLeastSteps;
}

void Occlusion::smooth(const CellGrid& grid) {
    const auto columns = static_cast<std::size_t>(grid.columns);
    // The share of hidden cells in a window round each, among those that tell: outside the cloth nothing tells; a hole
    // tells half, for visible, since a hole beside an arm is the arm's shadow on what lies behind it.
    for (int y = 0; y < grid.rows; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * columns;
        unsigned hidden = 0;
        unsigned all = 0;
        const auto take = [&](int x, unsigned sign) {
            if (x < 0 || x >= grid.columns) return;
            const std::size_t i = row + static_cast<std::size_t>(x);
            if (kind_[i] == kBare) return;
            all += sign * (kind_[i] == kHole ? 1U : 2U);
            if (kind_[i] == kFront) hidden += sign * 2U;
        };
        for (int x = -kRadius; x < kRadius; ++x)
            take(x, 1U);
        for (int x = 0; x < grid.columns; ++x) {
            take(x + kRadius, 1U);
            hidden_[row + static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(hidden);
            all_[row + static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(all);
            take(x - kRadius, ~0U);  // Minus one, modulo 2³².
        }
    }
    for (int y = 0; y < grid.rows; ++y) {
        const int first = std::max(y - kRadius, 0);
        const int last = std::min(y + kRadius, grid.rows - 1);
        const auto target = static_cast<std::size_t>(grid.y0 + y) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(grid.x0);
        for (std::size_t x = 0; x < columns; ++x) {
            unsigned hidden = 0;
            unsigned all = 0;
            for (int each = first; each <= last; ++each) {
                hidden += hidden_[static_cast<std::size_t>(each) * columns + x];
                all += all_[static_cast<std::size_t>(each) * columns + x];
            }
            if (all == 0) {
                visible_[target + x] = 255;
                continue;
            }
            // Steepened about one half, so that the window rounds the outline without blurring it away.
            const int share = static_cast<int>(256U * hidden / all);
            const int steep = std::clamp((share - 128) * 2 + 128, 0, 255);
            const int verdict = 255 - steep;
            const int before = lastSeen_[target + x] + 1 == frame_ ? visible_[target + x] : verdict;
            visible_[target + x] = static_cast<std::uint8_t>(before + (verdict - before) * kFreshness / 256);
            lastSeen_[target + x] = frame_;
        }
    }
}

void Occlusion::visibleRow(const MirrorMapping& mapping, float left, float y, float step, int count,
                           std::uint8_t* visible) const {
    if (visible_.empty()) {
        std::fill(visible, visible + count, std::uint8_t{255});
        return;
    }
    const float perCell = 1.0F / (mapping.scale * static_cast<float>(cell_));
    const auto cell = static_cast<float>(cell_);
    // 16.16 fixed point along the row; cell centres at whole numbers.
    const float row = std::clamp(y * perCell + mapping.cropTop / cell - 0.5F, 0.0F, static_cast<float>(rows_ - 1));
    const int first = static_cast<int>(row);
    const std::size_t upper = static_cast<std::size_t>(first) * static_cast<std::size_t>(columns_);
    const std::size_t lower =
        static_cast<std::size_t>(std::min(first + 1, rows_ - 1)) * static_cast<std::size_t>(columns_);
    const int weightY = static_cast<int>((row - static_cast<float>(first)) * 256.0F);
    auto at = static_cast<std::int64_t>((left * perCell + mapping.cropLeft / cell - 0.5F) * 65536.0F);
    const auto stride = static_cast<std::int64_t>(step * perCell * 65536.0F);
    const std::int64_t end = static_cast<std::int64_t>(columns_ - 1) << 16;
    for (int i = 0; i < count; ++i, at += stride) {
        const std::int64_t here = std::clamp<std::int64_t>(at, 0, end);
        const auto x = static_cast<std::size_t>(here >> 16);
        const std::size_t next = std::min(x + 1, static_cast<std::size_t>(columns_ - 1));
        const int weightX = static_cast<int>((here & 0xFFFF) >> 8);
        const int top = visible_[upper + x] * (256 - weightX) + visible_[upper + next] * weightX;
        const int bottom = visible_[lower + x] * (256 - weightX) + visible_[lower + next] * weightX;
        visible[i] = static_cast<std::uint8_t>((top * (256 - weightY) + bottom * weightY) >> 16);
    }
}

}  // namespace cheval::render

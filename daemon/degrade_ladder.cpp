#include "daemon/degrade_ladder.h"

#include <algorithm>
#include <array>

namespace cheval::daemon {

namespace {

constexpr std::array<Rung, 7> kRungs = {{
    {.name = "full"},
    {.name = "half the cloth iterations", .clothIterations = 0.5F},
    {.name = "render scale 0.75", .clothIterations = 0.5F, .renderScale = 0.75F},
    {.name = "render scale 0.5", .clothIterations = 0.5F, .renderScale = 0.5F},
    {.name = "coarser meshes", .clothIterations = 0.5F, .renderScale = 0.5F, .levelOfDetail = 1},
    {.name = "two thirds of the frame rate",
     .clothIterations = 0.5F,
     .renderScale = 0.5F,
     .levelOfDetail = 1,
     .rateShare = 2.0 / 3.0},
    {.name = "half the frame rate", .clothIterations = 0.5F, .renderScale = 0.5F, .levelOfDetail = 1, .rateShare = 0.5},
}};

}  // namespace

std::span<const Rung> DegradeLadder::rungs() {
    return kRungs;
}

DegradeLadder::DegradeLadder(const LadderOptions& options) : options_(options), upAfter_(options.upAfter) {}

const Rung& DegradeLadder::rung() const {
    return kRungs[level_];
}

bool DegradeLadder::offered(std::size_t level) const {
    if (level == 0) return true;
    const Rung& here = kRungs[level];
    const Rung& before = kRungs[level - 1];
    return (options_.haveCloth && here.clothIterations != before.clothIterations) ||
           here.renderScale != before.renderScale ||
           (options_.haveLevelsOfDetail && here.levelOfDetail != before.levelOfDetail) ||
           here.rateShare != before.rateShare;
}

std::size_t DegradeLadder::below() const {
    std::size_t level = level_;
    while (++level < kRungs.size()) {
        if (offered(level)) return level;
    }
    return level_;
}

std::size_t DegradeLadder::above() const {
    std::size_t level = level_;
    while (level > 0) {
        if (offered(--level)) return level;
    }
    return level_;
}

bool DegradeLadder::update(double load) {
    if (!options_.enabled) return false;
    if (steppedUp_) ++sinceUp_;

    late_ = load > 1.0 ? late_ + 1 : std::max(late_ - 1, 0);
    if (late_ >= options_.downAfter) {
        late_ = 0;
        spare_ = 0;
        const std::size_t next = below();
        if (next == level_) return false;
        // A step up that did not hold was too early: wait longer before the next try, so that the ladder does not
        // swing.
        const bool tookBack = steppedUp_ && sinceUp_ <= options_.upAfter;
        upAfter_ = tookBack ? std::min(upAfter_ * 2, options_.longestUpAfter) : options_.upAfter;
        steppedUp_ = false;
        level_ = next;
        return true;
    }

    const std::size_t previous = above();
    if (previous == level_) return false;
    const double predicted = load * kRungs[previous].rateShare / kRungs[level_].rateShare;
    spare_ = predicted < options_.upBelow ? spare_ + 1 : 0;
    if (spare_ < upAfter_) return false;
    spare_ = 0;
    late_ = 0;
    sinceUp_ = 0;
    steppedUp_ = true;
    level_ = previous;
    return true;
}

}  // namespace cheval::daemon

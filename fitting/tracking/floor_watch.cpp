#include "fitting/tracking/floor_watch.h"

#include <cmath>

#include "fitting/tracking/floor_search.h"

namespace cheval::fitting::tracking {
namespace {

constexpr float kRadiansPerDegree = 3.14159265F / 180.0F;
/// By how much a floor must differ: half as much again as the placement's corrections reach.
constexpr float kTiltApart = 4.5F * kRadiansPerDegree;
constexpr float kHeightApart = 0.15F;

bool apart(const MountEstimate& a, const MountEstimate& b) {
    return std::abs(a.height - b.height) > kHeightApart || std::abs(a.tilt - b.tilt) > kTiltApart ||
           std::abs(between(a.roll, b.roll)) > kTiltApart;
}

/// Found, and with hardly anything far under it: a strip of wall is no floor.
bool isFloor(const FloorFitJob& fit) {
    return fit.found && 4 * fit.under <= fit.support;
}

}  // namespace

void FloorWatch::reset() {
    begun_ = elsewhere_ = false;
    against_ = 0;
    looks_ = 0;
}

FloorWatch::Verdict FloorWatch::judge(const Cloud& cloud, std::uint32_t seed) const {
    if (!known_) return Verdict::unseen;
    FloorFitJob expected{.cloud = &cloud};
    if (!expected.isValid()) return Verdict::unseen;
    expected.run();
    if (isFloor(expected) && !apart(expected.corrected, written_)) return Verdict::agrees;
    FloorSearchJob search{.cloud = &cloud, .roll = written_.roll, .seed = seed};
    search.run();
    if (!search.found) return Verdict::unseen;
    FloorFitJob found{.cloud = &cloud, .start = floorUnder(cloud.placement, search.mount)};
    found.run();
    if (!isFloor(found)) return Verdict::unseen;
    return apart(found.corrected, written_) ? Verdict::differs : Verdict::agrees;
}

void FloorWatch::update(const Cloud& cloud, hal::TimePoint time) {
    if (begun_ && time >= last_ && time - last_ < kBetweenLooks) return;
    begun_ = true;
    last_ = time;
    const Verdict verdict = judge(cloud, ++looks_);
    if (verdict == Verdict::unseen) return;
    against_ = (verdict == Verdict::differs) != elsewhere_ ? against_ + 1 : 0;
    if (against_ < kBelieved) return;
    elsewhere_ = !elsewhere_;
    against_ = 0;
}

}  // namespace cheval::fitting::tracking
